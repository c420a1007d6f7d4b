//! A folder of shots against a folder of references.
//!
//! ```text
//! suite.toml ──Suite::read──▶ Suite ──discover──▶ SuiteShot… ──run──▶ SuiteResult ──▶ page, JUnit, JSON
//!                                                               │
//!                                     name.exr.new beside the references ──accept, reject──▶ name.exr
//! ```
//!
//! Every shot is rendered through [`crate::sequence`] into a folder of its own, so that what is compared is what `rayframe render`
//! writes. A picture without reference, a reference without picture, another size and whatever the limits do not allow fail.
//! Nothing here writes a reference but [`accept`], and [`run`] never calls it.
//!
//! What a shot file means is for the command line to say: a [`ShotReader`] makes jobs of shots. A test of another project:
//!
//! ```no_run
//! use rayframe::cancel::CancelFlag;
//! use rayframe::shot::ShotFiles;
//! use rayframe::regression::suite::{RunOptions, Suite, is_ci, run};
//!
//! # fn main() -> rayframe::error::Result<()> {
//! let suite = Suite::read("pictures".as_ref())?;
//! let options = RunOptions { keeps_pending: !is_ci(), ..RunOptions::default() };
//! let result = run(&suite, &ShotFiles, &options, &CancelFlag::new(), &|_, _| {})?;
//! assert!(result.passes(), "{}", result.failures().join("\n"));
//! # Ok(())
//! # }
//! ```

mod approvals;
mod discover;
mod filter;
mod limits;
mod names;
mod orphans;
mod page;
mod pending;
mod render;
mod run;
mod shell;
mod suite_file;
mod test_shot;

pub use approvals::{Approval, read_approvals};
pub use discover::{ShotReader, SuiteShot, discover};
pub use orphans::{finish, orphaned_references};
pub use page::{folders, report_page};
pub use pending::{Pending, PendingKind, accept, check_acceptable, compare_pending, is_ci, pending, reject};
pub use run::{OnShot, RunOptions, chosen_shots, run};
pub use shell::shell_word;
pub use suite_file::{SUITE_FILE, Suite};
pub use test_shot::{TestContext, test_shot};
