//! Automatic exposure of several sequences of one scene.

use std::sync::OnceLock;

use crate::scene::Selection;

/// Selections whose light decides one automatic exposure, and that exposure once it is found.
///
/// The clips, cameras and variants of a scene share one, so that their images compare. Runs of one selection share its own, which is
/// measured once for all of them.
#[derive(Debug)]
pub struct SharedExposure {
    /// The measured selections, with their cameras.
    pub selections: Vec<Selection>,
    /// Columns and rows of the images whose shape is measured, whichever sequence asks first.
    pub resolution: (u32, u32),
    found_ev: OnceLock<f32>,
}

impl SharedExposure {
    /// The exposure of `selections` in images of the shape of `resolution`, which is measured when the first of their sequences
    /// needs it.
    pub fn new(selections: Vec<Selection>, resolution: (u32, u32)) -> Self {
        Self { selections, resolution, found_ev: OnceLock::new() }
    }

    /// The exposure, measured by `measure` unless it is known.
    ///
    /// # Errors
    /// Those of `measure`.
    pub(super) fn find<E>(&self, measure: impl FnOnce() -> Result<f32, E>) -> Result<f32, E> {
        if let Some(&ev) = self.found_ev.get() {
            return Ok(ev);
        }
        let ev = measure()?;
        Ok(*self.found_ev.get_or_init(|| ev))
    }
}
