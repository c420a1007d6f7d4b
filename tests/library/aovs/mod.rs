//! What a film holds besides colour: sums on every scene, independence of how it is made, and motion that is known.

mod motion;
mod stage;
mod suite;
