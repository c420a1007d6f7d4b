//! A limit on the memory of images that wait for the report page.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::regression::Verdict;
use crate::regression::encoded_image::EncodedImage;
use crate::regression::result::FrameResult;

/// Bytes of packed images, as base64, on one page. Browsers open such a page within seconds.
pub const IMAGE_BUDGET_BYTES: usize = 64 << 20;

/// A budget of bytes for images that wait in memory until the page selects among them. Threads may share it.
///
/// The order in which frames arrive decides which of them keep their images only when all of them exceed four pages. Frames that
/// changed within the limits leave half of the budget to failures, and identical ones three quarters to both.
#[derive(Debug)]
pub struct ImageBudget {
    bytes: usize,
    free_bytes: AtomicUsize,
}

impl Default for ImageBudget {
    fn default() -> Self {
        Self::new()
    }
}

impl ImageBudget {
    /// A budget of four times what a page holds.
    pub fn new() -> Self {
        Self::of_bytes(4 * IMAGE_BUDGET_BYTES)
    }

    fn of_bytes(bytes: usize) -> Self {
        Self { bytes, free_bytes: AtomicUsize::new(bytes) }
    }

    /// Packs the FLIP map of `frame` and reserves memory for its images. Where the budget is exceeded, all of its images lose
    /// their [pixels](EncodedImage::without_pixels).
    pub fn admit(&self, frame: &mut FrameResult) {
        let map = frame.comparison.as_mut().and_then(|comparison| comparison.flip_map.take());
        let colors = size_bytes(frame);
        let kept_free = match frame.verdict() {
            Verdict::Failed => 0,
            Verdict::Changed => self.bytes / 2,
            Verdict::Identical => self.bytes / 4 * 3,
        };
        // Images too large for a page are not kept.
        if colors > IMAGE_BUDGET_BYTES || !self.reserve(colors, kept_free) {
            return drop_pixels(frame);
        }
        if let Some(map) = map {
            frame.actual = frame.actual.take().map(|image| image.with_errors(&map));
        }
        // Maps take a sixth of the bytes of colours, so that this second reservation seldom fails.
        let errors = size_bytes(frame).saturating_sub(colors);
        if !self.reserve(errors, kept_free) {
            self.free_bytes.fetch_add(colors, Ordering::Relaxed);
            drop_pixels(frame);
        }
    }

    /// Takes `bytes` where at least `kept_free` bytes stay free.
    fn reserve(&self, bytes: usize, kept_free: usize) -> bool {
        let less = |free: usize| free.checked_sub(bytes).filter(|left| bytes == 0 || *left >= kept_free);
        self.free_bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less).is_ok()
    }
}

fn size_bytes(frame: &FrameResult) -> usize {
    [&frame.expected, &frame.actual].into_iter().flatten().map(EncodedImage::size_bytes).sum()
}

fn drop_pixels(frame: &mut FrameResult) {
    for image in [&mut frame.expected, &mut frame.actual] {
        *image = image.take().map(EncodedImage::without_pixels);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::regression::{ColorEncoding, FrameStatus, Image, Preset, compare};

    fn frame() -> FrameResult {
        let image = |value: f32| {
            let pixel = |at: u32| [value, (at % 7) as f32 * 0.1, value * 2.0, 1.0];
            Image::from_rgba((24, 16), ColorEncoding::Linear, &(0..384).map(pixel).collect::<Vec<_>>())
        };
        let (actual, expected) = (image(0.5), image(0.25));
        let comparison = compare(&actual, &expected, &Preset::Visual.limits());
        assert!(comparison.flip_map.is_some());
        FrameResult {
            name: "a".to_owned(),
            frame: None,
            status: FrameStatus::Different,
            messages: Vec::new(),
            comparison: Some(comparison),
            expected: EncodedImage::new(&expected),
            actual: EncodedImage::new(&actual),
            actual_hash: None,
            value_hash: None,
            reference_hash: None,
        }
    }

    fn admitted(budget: &ImageBudget) -> FrameResult {
        let mut frame = frame();
        budget.admit(&mut frame);
        assert!(frame.comparison.as_ref().unwrap().flip_map.is_none());
        assert!(frame.expected.is_some() && frame.actual.is_some());
        frame
    }

    #[test]
    fn frames_have_all_their_images_or_none() {
        let whole = admitted(&ImageBudget::new());
        let bytes = size_bytes(&whole);
        assert!(whole.actual.as_ref().unwrap().errors.is_some() && bytes > size_bytes(&frame()));
        let budget = ImageBudget::of_bytes(2 * bytes + bytes - 1);
        let sizes = [(); 3].map(|()| size_bytes(&admitted(&budget)));
        assert_eq!(sizes, [bytes, bytes, 0]);
        // The third reserved its colours, and returned them when its map did not fit.
        assert_eq!(budget.free_bytes.into_inner(), bytes - 1);
    }

    #[test]
    fn changed_frames_leave_half_of_the_budget_to_failures() {
        let bytes = size_bytes(&admitted(&ImageBudget::new()));
        let budget = ImageBudget::of_bytes(4 * bytes);
        let changed = || {
            let mut frame = FrameResult { status: FrameStatus::Passed, ..frame() };
            budget.admit(&mut frame);
            size_bytes(&frame)
        };
        assert_eq!([(); 3].map(|()| changed()), [bytes, bytes, 0]);
        assert_eq!([(); 3].map(|()| size_bytes(&admitted(&budget))), [bytes, bytes, 0]);
    }

    #[test]
    fn threads_do_not_exceed_the_budget() {
        let bytes = size_bytes(&admitted(&ImageBudget::new()));
        let budget = ImageBudget::of_bytes(5 * bytes);
        let count = std::thread::scope(|scope| {
            let taken = [(); 4]
                .map(|()| scope.spawn(|| (0..4).filter(|_| size_bytes(&admitted(&budget)) > 0).count()));
            taken.into_iter().map(|thread| thread.join().unwrap()).sum::<usize>()
        });
        // A thread that is about to return its colours may turn another one away; the budget is never exceeded.
        assert!((1..=5).contains(&count), "{count}");
        assert!(budget.free_bytes.into_inner() <= (5 - count) * bytes);
    }

    #[test]
    fn frames_without_images_need_no_budget() {
        let mut without_images = FrameResult { expected: None, actual: None, ..frame() };
        ImageBudget::of_bytes(0).admit(&mut without_images);
        assert!(without_images.actual.is_none() && without_images.expected.is_none());
    }
}
