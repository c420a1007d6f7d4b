//! How many packed pictures may wait for a page.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::page_images::IMAGE_BUDGET_BYTES;
use super::{EncodedImage, ReportedFrame};

/// Bytes for pictures that wait in memory until the page chooses among them. Threads may share it.
///
/// Which frames have their pictures depends on the order in which they come only where all of them take more than four pages.
#[derive(Debug)]
pub struct ImageBudget {
    bytes: AtomicUsize,
}

impl Default for ImageBudget {
    fn default() -> Self {
        Self::new()
    }
}

impl ImageBudget {
    /// Room for four times what a page holds.
    pub fn new() -> Self {
        Self::of_bytes(4 * IMAGE_BUDGET_BYTES)
    }

    fn of_bytes(bytes: usize) -> Self {
        Self { bytes: AtomicUsize::new(bytes) }
    }

    /// Makes `frame` as small as it can wait: its FLIP map is packed, and where there is no room all its pictures are
    /// [left out](EncodedImage::left_out).
    pub fn admit(&self, frame: &mut ReportedFrame) {
        let map = frame.comparison.as_mut().and_then(|comparison| comparison.flip_map.take());
        let colors = size_bytes(frame);
        // What is too large for a page by itself need not wait.
        if colors > IMAGE_BUDGET_BYTES || !self.take(colors) {
            return leave_out(frame);
        }
        if let Some(map) = map {
            frame.actual = frame.actual.take().map(|picture| picture.with_errors(&map));
        }
        // Maps take a sixth of what colours do, so that taking their room afterwards is seldom in vain.
        let errors = size_bytes(frame).saturating_sub(colors);
        if !self.take(errors) {
            self.bytes.fetch_add(colors, Ordering::Relaxed);
            leave_out(frame);
        }
    }

    fn take(&self, bytes: usize) -> bool {
        let less = |room: usize| room.checked_sub(bytes);
        self.bytes.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less).is_ok()
    }
}

fn size_bytes(frame: &ReportedFrame) -> usize {
    [&frame.expected, &frame.actual].into_iter().flatten().map(EncodedImage::size_bytes).sum()
}

fn leave_out(frame: &mut ReportedFrame) {
    for picture in [&mut frame.expected, &mut frame.actual] {
        *picture = picture.take().map(EncodedImage::left_out);
    }
}

#[cfg(test)]
mod tests {
    use super::super::FrameStatus;
    use super::*;
    use crate::regression::{ColorEncoding, Image, Preset, compare};

    fn frame() -> ReportedFrame {
        let picture = |value: f32| {
            let pixel = |at: u32| [value, (at % 7) as f32 * 0.1, value * 2.0, 1.0];
            Image::from_rgba((24, 16), ColorEncoding::Linear, &(0..384).map(pixel).collect::<Vec<_>>())
        };
        let (actual, expected) = (picture(0.5), picture(0.25));
        let comparison = compare(&actual, &expected, &Preset::Visual.limits());
        assert!(comparison.flip_map.is_some());
        ReportedFrame {
            name: "a".to_owned(),
            frame: None,
            status: FrameStatus::Different,
            messages: Vec::new(),
            comparison: Some(comparison),
            expected: EncodedImage::new(&expected),
            actual: EncodedImage::new(&actual),
            actual_hash: None,
        }
    }

    fn admitted(room: &ImageBudget) -> ReportedFrame {
        let mut frame = frame();
        room.admit(&mut frame);
        assert!(frame.comparison.as_ref().unwrap().flip_map.is_none());
        assert!(frame.expected.is_some() && frame.actual.is_some());
        frame
    }

    #[test]
    fn frames_have_all_their_pictures_or_none() {
        let whole = admitted(&ImageBudget::new());
        let bytes = size_bytes(&whole);
        assert!(whole.actual.as_ref().unwrap().errors.is_some() && bytes > size_bytes(&frame()));
        let room = ImageBudget::of_bytes(2 * bytes + bytes - 1);
        let sizes = [(); 3].map(|()| size_bytes(&admitted(&room)));
        assert_eq!(sizes, [bytes, bytes, 0]);
        // What was in vain is given back: colours fit, and the map did not.
        assert_eq!(room.bytes.into_inner(), bytes - 1);
    }

    #[test]
    fn threads_take_no_more_than_there_is() {
        let bytes = size_bytes(&admitted(&ImageBudget::new()));
        let room = ImageBudget::of_bytes(5 * bytes);
        let count = std::thread::scope(|scope| {
            let taken =
                [(); 4].map(|()| scope.spawn(|| (0..4).filter(|_| size_bytes(&admitted(&room)) > 0).count()));
            taken.into_iter().map(|thread| thread.join().unwrap()).sum::<usize>()
        });
        // A thread that waits to give colours back may turn another away, and never lets more in.
        assert!((1..=5).contains(&count), "{count}");
        assert!(room.bytes.into_inner() <= (5 - count) * bytes);
    }

    #[test]
    fn frames_without_pictures_need_no_room() {
        let mut lonely = ReportedFrame { expected: None, actual: None, ..frame() };
        ImageBudget::of_bytes(0).admit(&mut lonely);
        assert!(lonely.actual.is_none() && lonely.expected.is_none());
    }
}
