//! AOVs of a film: sums of light passes on every scene, independence of threads and crops, and known motion.

mod motion;
mod stage;
mod suite;
