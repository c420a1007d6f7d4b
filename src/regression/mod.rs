//! Reference pictures: every scene of a folder is rendered small and compared with what is stored for it.
//!
//! [`run`] finds the [`Shot`]s of a [`Suite`], renders each and compares it with its reference by [`compare`]. A missing,
//! different or dangling reference is a failure; so is an accepted one, so that a run that wrote something never passes
//! for one that checked it. A picture that differs is written beside its difference to the suite's report folder.
//!
//! Nothing is printed here, and time, if a clip moves, is frame / 24 s as on the command line.

mod compare;
mod picture;
mod render;
mod report;
mod shots;
mod suite;
mod surroundings;

pub use compare::{Differences, Tolerance, Verdict, compare};
pub use picture::Picture;
pub use render::SceneRenderer;
pub use shots::{Shot, discover};
pub use suite::{Failure, Mode, Outcome, Suite, run};

/// Frames a second of all suites.
const FRAMES_PER_SECOND: i32 = 24;
