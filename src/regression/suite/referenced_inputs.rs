//! Inputs of shots below the folder of references, which are no references.

use std::cell::OnceCell;

use super::names::reference_path;
use super::{Suite, SuiteShot};
use crate::shot::{NamedImages, ShotRequest};

/// Inputs of shots that have names of references.
pub(super) struct ReferencedInputs<'a> {
    suite: &'a Suite,
    shots: &'a [SuiteShot],
    /// Found when they are asked for.
    images: OnceCell<NamedImages>,
}

impl<'a> ReferencedInputs<'a> {
    /// `shots` are all shots of the suite.
    pub(super) fn new(suite: &'a Suite, shots: &'a [SuiteShot]) -> Self {
        Self { suite, shots, images: OnceCell::new() }
    }

    /// Whether the file of the reference `name` is an environment or a plate of a shot.
    pub(super) fn contains(&self, name: &str) -> bool {
        let images = self.images.get_or_init(|| {
            let mut images = NamedImages::default();
            for shot in self.shots {
                // The error is that of the shot.
                let request = ShotRequest { path: &shot.path, suite: Some(&self.suite.file), overrides: &[] };
                let _ = images.add(&request);
            }
            images
        });
        images.contains(&reference_path(&self.suite.references, name))
    }
}
