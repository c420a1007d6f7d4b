//! Regression suites: a folder of shots and a folder of reference images.
//!
//! ```text
//! suite.toml ──Suite::read──▶ Suite ──discover──▶ SuiteShot… ──run──▶ SuiteResult ──▶ page, JUnit, JSON
//!                                                               │
//!                                     pending images (name.exr.new, name.exr.changed.new) ──accept, reject──▶ references (name.exr)
//! ```
//!
//! Every shot is rendered through [`crate::sequence`] into a temporary folder, so that the files equal those of `rayframe render`.
//! An image fails when it has no reference, another size, or differences beyond the limits; a reference fails when no shot renders it.
//! Only [`Acceptance::accept`] writes references, and [`run`] never calls it.
//!
//! Shots are read by [`crate::shot`]. A test of another project:
//!
//! ```no_run
//! use rayframe::cancel::CancelFlag;
//! use rayframe::regression::suite::{RunOptions, Suite, is_ci, run};
//!
//! # fn main() -> rayframe::error::Result<()> {
//! let suite = Suite::read("images".as_ref())?;
//! let options = RunOptions { keeps_pending: !is_ci(), ..RunOptions::default() };
//! let result = run(&suite, &options, &CancelFlag::new(), &|_, _| {})?;
//! assert!(result.passes(), "{}", result.failures().join("\n"));
//! # Ok(())
//! # }
//! ```

mod accept_rendered;
mod acceptance;
mod approvals;
mod changed_files;
mod coverage;
mod covered_jobs;
mod discover;
mod filter;
mod input_files;
mod large_scenes;
mod limits;
mod merge_reports;
mod names;
mod orphans;
mod page;
mod pending;
mod referenced_inputs;
mod renamed;
mod render;
mod rendered_images;
mod rendered_report;
mod report_archive;
mod retimed;
mod run;
mod run_options;
mod shard;
mod shell;
mod stored_reference;
mod suite_file;
mod test_shot;
mod told_content;
mod unchanged;
mod verdict_cache;
mod views;

pub use accept_rendered::{RenderedChange, RenderedChecks, select_rendered};
pub use acceptance::{Acceptance, Unopened};
pub use approvals::{Approval, read_approvals};
pub use covered_jobs::image_names;
pub use discover::{SuiteShot, discover};
pub use input_files::{input_files, is_report_image, report_files};
pub use merge_reports::{RESULT_FILE, check_result_place, merge_reports};
pub use orphans::finish;
pub use page::{PageCommands, folders, report_page, suite_title};
pub use pending::{
    Pending, PendingKind, PendingSelection, compare_pending, discard_stray_comparisons, is_ci, pending,
    reject,
};
pub use rendered_images::{RenderedImage, check_images_place};
pub use rendered_report::RenderedReport;
pub use run::{OnShot, chosen_shots, run};
pub use run_options::RunOptions;
pub use shard::Shard;
pub use shell::{name_and_options, shell_quoted, shell_word};
pub use suite_file::{SUITE_FILE, Suite};
pub use told_content::refers_to_another_image;
