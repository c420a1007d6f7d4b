//! The images of a page, chosen within its budget.

use std::borrow::Cow;
use std::cmp::Reverse;

use serde::Serialize;

use super::page::ReportPage;
use crate::regression::encoded_image::{EncodedImage, base64_bytes, pack_errors};
use crate::regression::result::FrameResult;

/// Why the images of a frame are not on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Omission {
    /// They exceed the budget of a page, so that no other page can show them either.
    TooLarge,
    /// Images of other frames used up the budget.
    NoSpace,
}

/// Indices of a frame's images among those of the page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct FrameImages {
    pub(super) expected: Option<usize>,
    pub(super) actual: Option<usize>,
    pub(super) errors: Option<usize>,
    pub(super) omission: Option<Omission>,
}

/// The packed images of a page, and their indices by shot and frame.
#[derive(Debug, Default)]
pub(super) struct PageImages<'a> {
    pub(super) packed: Vec<Cow<'a, [u8]>>,
    /// One entry for each frame of each shot.
    pub(super) shots: Vec<Vec<FrameImages>>,
}

impl<'a> PageImages<'a> {
    /// Takes images until the budget is used up: first the worst failure of each shot, then the second worst, then frames that changed,
    /// and last identical ones. A frame has all of its images or none.
    pub(super) fn new(page: &'a ReportPage, budget_bytes: usize) -> Self {
        let mut order = Vec::new();
        for (shot_index, shot) in page.shots.iter().enumerate() {
            let mut frames = worst_first(&shot.frames);
            frames.retain(|index| {
                shot.frames[*index].expected.is_some() || shot.frames[*index].actual.is_some()
            });
            let ranked = frames.into_iter().enumerate();
            order.extend(ranked.map(|(rank, frame_index)| {
                (Reverse(shot.frames[frame_index].verdict()), rank, shot_index, frame_index)
            }));
        }
        order.sort_unstable();
        let shots = page.shots.iter().map(|shot| vec![FrameImages::default(); shot.frames.len()]).collect();
        let mut images = Self { packed: Vec::new(), shots };
        let mut free_bytes = budget_bytes;
        for (_, _, shot, index) in order {
            let frame = &page.shots[shot].frames[index];
            images.shots[shot][index] = images.take(frame, budget_bytes, &mut free_bytes);
        }
        images
    }

    /// Bytes of all images as base64 in their elements.
    pub(super) fn text_bytes(&self) -> usize {
        let around = "<script type=\"text/plain\" id=\"image-99999\"></script>\n".len();
        self.packed.iter().map(|image| base64_bytes(image.len()) + around).sum()
    }

    fn take(&mut self, frame: &'a FrameResult, budget_bytes: usize, free_bytes: &mut usize) -> FrameImages {
        let omitted = |bytes| {
            let why = if bytes > budget_bytes { Omission::TooLarge } else { Omission::NoSpace };
            FrameImages { omission: Some(why), ..FrameImages::default() }
        };
        let images = [&frame.expected, &frame.actual].map(Option::as_ref);
        let known_bytes = images.into_iter().flatten().map(EncodedImage::needed_bytes).sum();
        if known_bytes > *free_bytes || images.into_iter().flatten().any(|image| image.colors.is_none()) {
            return omitted(known_bytes);
        }
        let [expected, actual] =
            images.map(|image| image.and_then(|image| image.colors.as_deref()).map(Cow::from));
        let map = frame.comparison.as_ref().and_then(|comparison| comparison.flip_map.as_ref());
        let packed = || frame.actual.as_ref().and_then(|image| image.errors.as_deref()).map(Cow::from);
        let errors = map.map(|map| Cow::from(pack_errors(map))).or_else(packed);
        let parts = [&expected, &actual, &errors].into_iter().flatten();
        let bytes: usize = parts.map(|part| base64_bytes(part.len())).sum();
        if bytes > *free_bytes {
            return omitted(bytes);
        }
        *free_bytes -= bytes;
        let mut push = |part: Option<Cow<'a, [u8]>>| {
            part.map(|part| {
                self.packed.push(part);
                self.packed.len() - 1
            })
        };
        FrameImages { expected: push(expected), actual: push(actual), errors: push(errors), omission: None }
    }
}

/// Indices of `frames`, most relevant first: failures by FLIP of their worst tile, failures without FLIP, changed frames, identical
/// frames.
pub(super) fn worst_first(frames: &[FrameResult]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..frames.len()).collect();
    let tile = |index: &usize| {
        let flip = frames[*index].comparison.as_ref().and_then(|comparison| comparison.flip);
        flip.map_or(0.0, |flip| flip.tile)
    };
    let verdict = |index: &usize| frames[*index].verdict();
    order.sort_by(|a, b| verdict(b).cmp(&verdict(a)).then_with(|| tile(b).total_cmp(&tile(a))));
    order
}
