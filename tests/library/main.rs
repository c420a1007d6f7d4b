//! The library from outside, one subject a module.

mod aovs;
mod bvh;
mod conformance;
mod corruptions;
mod known_answers;
mod motion_blur;
mod references;
mod scenes;
mod sequence;
mod source_tree;
mod stage;
