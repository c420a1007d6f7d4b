//! What a range of samples cannot be combined with.

use crate::output::{Aov, AovSet};

use super::choices::DenoiserKind;
use super::definitions::SettingValues;
use super::environment_source::BackgroundSource;
use super::output_pattern::OutputFormat;

impl SettingValues {
    /// Why only the samples of `sample_range` cannot be rendered; `None` where they can, or where all are.
    pub(crate) fn sample_range_refusal(&self) -> Option<String> {
        let last = self.sample_range?.last;
        if self.lacks_samples_of_range() {
            let samples = self.samples;
            return Some(format!("ends at {last}, but `samples` {samples} are 0 to {}", samples - 1));
        }
        let beside = [
            (self.has_uneven_times(), "`samples` must be a multiple of `time_samples`"),
            (self.noise.is_some(), "`noise` decides by all samples of a pixel"),
            (self.time_limit.is_some(), "`time_limit` ends at any sample"),
            (self.denoise != DenoiserKind::None, "`denoise` needs all samples"),
            (self.has_no_exr_files(), "only EXR files hold sums; end `output` with .exr"),
            (self.has_plate(), "a plate can only be put behind all samples"),
            (self.split_aovs, "the sums are in one file; leave out `split_aovs`"),
            (self.has_mattes(), "Cryptomattes cannot be added up; render them without a range"),
            (self.is_lossy(), "sums need a lossless compression such as zip"),
        ];
        let (_, why) = beside.into_iter().find(|(is_there, _)| *is_there)?;
        Some(format!("cannot be used here: {why}"))
    }

    /// Whether the range ends beyond `samples`.
    pub(super) fn lacks_samples_of_range(&self) -> bool {
        self.sample_range.is_some_and(|range| range.last >= self.samples)
    }

    /// Whether the times of the shutter have different numbers of samples.
    pub(super) fn has_uneven_times(&self) -> bool {
        self.shutter.is_some() && !self.samples.is_multiple_of(self.time_samples)
    }

    /// Whether the output is of another format than EXR.
    pub(super) fn has_no_exr_files(&self) -> bool {
        self.output.as_ref().is_some_and(|output| output.format() != OutputFormat::Exr)
    }

    /// Whether an image is the background.
    pub(super) fn has_plate(&self) -> bool {
        matches!(self.background, BackgroundSource::Plate(_))
    }

    /// Whether EXR files hold Cryptomattes.
    pub(super) fn has_mattes(&self) -> bool {
        self.has_aov(|aov| matches!(aov, Aov::CryptoObject | Aov::CryptoMaterial))
    }

    /// Whether an AOV is such.
    pub(super) fn has_aov(&self, is_such: impl Fn(Aov) -> bool) -> bool {
        self.aovs.iter().flat_map(AovSet::as_slice).any(|aov| is_such(*aov))
    }

    /// Whether the compression of EXR files loses precision.
    pub(super) fn is_lossy(&self) -> bool {
        self.exr.is_some_and(|(_, compression)| compression.is_lossy())
    }
}
