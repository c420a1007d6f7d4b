//! Memory of a frame's pixels: films, sums of samples, and files while they are encoded.

use crate::film::{
    AovFlags, CoverageSample, ExactSum, GuideSample, GuideSums, LightPasses, LightSums, NoiseSample,
    PixelCenterSample, PixelMoments, PixelSums, PixelWindow, SumFlags,
};
use crate::output::{Aov, ExrOutput};
use crate::render::PixelFilter;
use crate::sequence::Shutter;

/// A pixel of a film, which takes tiles as they end.
const BYTES_A_FILM_PIXEL: u128 = 16;
/// Filter weights of a pixel of two films, where a filter has negative lobes.
const BYTES_OF_WEIGHTS: u128 = 2 * 4;
/// Share of their size to which channels besides the colour are compressed: most are smooth or constant. Colour is noise and keeps its size.
const COMPRESSED_SHARE: u128 = 4;
/// Copies of the exact sums of a frame that a checkpoint or a file of a sample range takes: its own, the channels, and the encoded file.
const STORED_SUM_COPIES: u128 = 3;
/// A pixel of denoising: guides of two films (24 each), noisy colours of two films (12), their channels (24), three images for the denoiser (12
/// each) and one of its files (12).
const BYTES_A_DENOISED_PIXEL: u128 = 2 * 24 + 2 * 12 + 24 + 3 * 12 + 12;
/// A pixel of the denoiser's own process: 689 MiB at 1280x720 and 1526 MiB at 1920x1080, of version 2.5.1.
const BYTES_OF_DENOISER: u128 = 790;
/// Instances that cover a pixel: most pixels have one or two, edges and foliage more.
const SHARES_A_PIXEL: usize = 4;

/// What is kept of every pixel of an image.
#[derive(Clone, Copy, Debug)]
pub struct PixelMemory<'a> {
    /// The pixels.
    pub window: PixelWindow,
    /// The shutter.
    pub shutter: Shutter,
    /// The reconstruction filter.
    pub filter: PixelFilter,
    /// The frame's files.
    pub exr: &'a ExrOutput,
    /// The sums of paths.
    pub sums: Option<SumFlags>,
    /// Whether the sums are stored.
    pub stores_sums: bool,
    /// Whether a denoiser runs beside.
    pub is_denoised: bool,
}

impl PixelMemory<'_> {
    /// Most bytes for one frame; where `has_next`, a frame is traced while the one before is encoded.
    pub(super) fn bytes(&self, has_next: bool) -> u128 {
        let aovs = self.exr.aov_flags();
        let film = BYTES_A_FILM_PIXEL + aov_bytes(aovs);
        let tracing = self.tracing_bytes(aovs);
        let (channels, compressed) = self.file_bytes();
        let bytes_a_pixel = if has_next {
            // The memory of the channels before is freed and not always returned to the system.
            2 * film + tracing + 2 * channels + compressed
        } else {
            film + tracing.max(channels + compressed)
        };
        u128::from(self.window.width()) * u128::from(self.window.height()) * bytes_a_pixel
    }

    /// Bytes a pixel besides the film while samples are summed.
    fn tracing_bytes(&self, aovs: AovFlags) -> u128 {
        let Some(sums) = self.sums else {
            let has_scratch = self.shutter.time_samples > 1;
            let scratch = BYTES_A_FILM_PIXEL + aov_bytes(AovFlags { centers: false, ..aovs });
            let weights = if self.filter.has_negative_lobes() { BYTES_OF_WEIGHTS } else { 0 };
            return if has_scratch { scratch + weights } else { 0 };
        };
        let copies = if self.stores_sums { STORED_SUM_COPIES } else { 1 };
        let denoised = if sums.guides { BYTES_A_DENOISED_PIXEL } else { 0 };
        let denoiser = if self.is_denoised { BYTES_OF_DENOISER } else { 0 };
        copies * sum_bytes(sums) + denoised + denoiser
    }

    /// Bytes a pixel of the channels of the files, before and after compression.
    fn file_bytes(&self) -> (u128, u128) {
        let stored = |aov: Aov| u128::from(self.exr.stored_bytes_a_pixel(aov));
        let channels: u128 = self.exr.aovs.as_slice().iter().map(|&aov| stored(aov)).sum();
        let color = stored(Aov::Beauty);
        (channels, color + (channels - color) / COMPRESSED_SHARE)
    }
}

/// Bytes of the AOVs of one pixel of a film.
fn aov_bytes(aovs: AovFlags) -> u128 {
    let mut bytes = 0;
    if aovs.light {
        bytes += size_of::<LightPasses>();
    }
    if aovs.noise {
        bytes += size_of::<NoiseSample>();
    }
    if aovs.guides {
        bytes += size_of::<GuideSample>();
    }
    if aovs.centers {
        bytes += size_of::<PixelCenterSample>();
    }
    if aovs.coverage {
        bytes += size_of::<CoverageSample>() + SHARES_A_PIXEL * size_of::<(u32, f32)>();
    }
    bytes as u128
}

/// Bytes of the exact sums of one pixel.
fn sum_bytes(sums: SumFlags) -> u128 {
    let mut bytes = size_of::<PixelSums>() + 1;
    if sums.moments {
        bytes += size_of::<PixelMoments>();
    }
    if sums.light {
        bytes += size_of::<LightSums>();
    }
    if sums.guides {
        bytes += size_of::<GuideSums>();
    }
    if sums.coverage {
        bytes += size_of::<Vec<(u32, ExactSum)>>() + SHARES_A_PIXEL * size_of::<(u32, ExactSum)>();
    }
    bytes as u128
}

/// Bytes a pixel that a frame needs beyond the estimate where its sums take `stored` in a checkpoint: of pixels that show more instances.
pub(super) fn further_sum_bytes(sums: SumFlags, stored: u128) -> u128 {
    STORED_SUM_COPIES * stored.saturating_sub(sum_bytes(sums))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::AovSet;

    /// Bytes a pixel.
    fn bytes(memory: PixelMemory<'_>) -> [u128; 2] {
        let window = PixelWindow::full(1000, 10);
        [false, true].map(|has_next| PixelMemory { window, ..memory }.bytes(has_next) / 10_000)
    }

    fn plain(exr: &ExrOutput) -> PixelMemory<'_> {
        let window = PixelWindow::full(1, 1);
        let (shutter, filter) = (Shutter::default(), PixelFilter::Box);
        PixelMemory { window, shutter, filter, exr, sums: None, stores_sums: false, is_denoised: false }
    }

    #[test]
    fn colour_takes_a_film_and_two_copies_of_its_halves() {
        // Of a sequence, two films and the channels of two frames.
        assert_eq!(bytes(plain(&ExrOutput::default())), [16 + 8 + 8, 2 * 16 + 2 * 8 + 8]);
    }

    #[test]
    fn other_channels_are_compressed_to_a_quarter() {
        let exr = ExrOutput { aovs: AovSet::new(&[Aov::Position]), ..ExrOutput::default() };
        let film = 16 + size_of::<PixelCenterSample>() as u128;
        // The position has twelve bytes.
        assert_eq!(bytes(plain(&exr)), [film + 20 + 8 + 3, 2 * film + 2 * 20 + 8 + 3]);
    }

    #[test]
    fn sums_are_gone_before_a_still_is_encoded() {
        let exr = ExrOutput::default();
        let paths = PixelMemory { sums: Some(SumFlags::default()), ..plain(&exr) };
        let sums = size_of::<PixelSums>() as u128 + 1;
        assert_eq!(bytes(paths), [16 + sums, 2 * 16 + sums + 2 * 8 + 8]);
        // A checkpoint is encoded while they are there.
        assert_eq!(bytes(PixelMemory { stores_sums: true, ..paths })[0], 16 + 3 * sums);
        assert_eq!(bytes(PixelMemory { is_denoised: true, ..paths })[0], 16 + sums + 790);
    }

    #[test]
    fn shutter_samples_have_a_film_of_their_own() {
        let exr = ExrOutput { aovs: AovSet::new(&[Aov::Position]), ..ExrOutput::default() };
        let shutter = Shutter { time_samples: 2, ..Shutter::default() };
        let blurred = PixelMemory { shutter, ..plain(&exr) };
        assert_eq!(bytes(blurred)[1], bytes(plain(&exr))[1] + 16);
        // Both films have the weights of a filter with negative lobes, four bytes each.
        let mitchell = PixelMemory { filter: PixelFilter::Mitchell, ..blurred };
        assert_eq!(bytes(mitchell)[1], bytes(blurred)[1] + 8);
    }

    #[test]
    fn checkpoints_with_many_instances_need_more_than_the_estimate() {
        let plain = SumFlags::default();
        let crypto = SumFlags { coverage: true, ..plain };
        let all = SumFlags { moments: true, light: true, coverage: true, guides: true };
        // Stored are a weight, a count, four sums, whether the pixel is finished, and each instance with its share.
        let stored = |instances: u128| 4 + 4 + 4 * 16 + 4 + 4 + instances * 20;
        assert_eq!(further_sum_bytes(plain, stored(0) - 4), 0);
        assert_eq!(further_sum_bytes(crypto, stored(SHARES_A_PIXEL as u128)), 0);
        assert_eq!(further_sum_bytes(all, stored(SHARES_A_PIXEL as u128)), 0);
        let further = |instances| further_sum_bytes(crypto, stored(instances));
        assert_eq!(further(151) - further(51), 3 * 100 * 20);
    }
}
