//! Which pictures a page has room for.

use std::borrow::Cow;

use super::data::{FrameImages, LeftOut};
use super::encoded_image::{pack_errors, text_bytes};
use super::{EncodedImage, FrameStatus, ReportPage, ReportedFrame};

/// Bytes of pictures, packed and as text, that a page holds. Browsers open such a page within seconds.
pub const IMAGE_BUDGET_BYTES: usize = 64 << 20;

/// The packed pictures of a page, and where those of each frame are among them.
#[derive(Debug, Default)]
pub(super) struct PageImages<'a> {
    pub(super) pictures: Vec<Cow<'a, [u8]>>,
    /// One a frame of each shot.
    pub(super) shots: Vec<Vec<FrameImages>>,
}

impl<'a> PageImages<'a> {
    /// Takes pictures as long as there is room: first the worst frame of each shot, then the next worst. A frame has all its pictures
    /// or none.
    pub(super) fn new(page: &'a ReportPage, budget_bytes: usize) -> Self {
        let mut order = Vec::new();
        for (shot_index, shot) in page.shots.iter().enumerate() {
            let mut frames = worst_first(&shot.frames);
            frames.retain(|index| {
                shot.frames[*index].expected.is_some() || shot.frames[*index].actual.is_some()
            });
            let ranked = frames.into_iter().enumerate();
            order.extend(ranked.map(|(rank, frame_index)| (rank, shot_index, frame_index)));
        }
        order.sort_unstable();
        let shots = page.shots.iter().map(|shot| vec![FrameImages::default(); shot.frames.len()]).collect();
        let mut places = Self { pictures: Vec::new(), shots };
        let mut room = budget_bytes;
        for (_, shot, index) in order {
            let frame = &page.shots[shot].frames[index];
            places.shots[shot][index] = places.take(frame, budget_bytes, &mut room);
        }
        places
    }

    /// What the pictures take as text.
    pub(super) fn text_bytes(&self) -> usize {
        let around = "<script type=\"text/plain\" id=\"picture-99999\"></script>\n".len();
        self.pictures.iter().map(|part| text_bytes(part.len()) + around).sum()
    }

    fn take(&mut self, frame: &'a ReportedFrame, budget_bytes: usize, room: &mut usize) -> FrameImages {
        let left_out = |bytes| {
            let why = if bytes > budget_bytes { LeftOut::TooLarge } else { LeftOut::NoRoom };
            FrameImages { left_out: Some(why), ..FrameImages::default() }
        };
        let pictures = [&frame.expected, &frame.actual].map(Option::as_ref);
        let known_bytes = pictures.into_iter().flatten().map(EncodedImage::needed_bytes).sum();
        if known_bytes > *room || pictures.into_iter().flatten().any(|picture| picture.colors.is_none()) {
            return left_out(known_bytes);
        }
        let [expected, actual] =
            pictures.map(|picture| picture.and_then(|picture| picture.colors.as_deref()).map(Cow::from));
        let map = frame.comparison.as_ref().and_then(|comparison| comparison.flip_map.as_ref());
        let packed = || frame.actual.as_ref().and_then(|picture| picture.errors.as_deref()).map(Cow::from);
        let errors = map.map(|map| Cow::from(pack_errors(map))).or_else(packed);
        let parts = [&expected, &actual, &errors].into_iter().flatten();
        let bytes: usize = parts.map(|part| text_bytes(part.len())).sum();
        if bytes > *room {
            return left_out(bytes);
        }
        *room -= bytes;
        let mut place = |part: Option<Cow<'a, [u8]>>| {
            part.map(|part| {
                self.pictures.push(part);
                self.pictures.len() - 1
            })
        };
        FrameImages {
            expected: place(expected),
            actual: place(actual),
            errors: place(errors),
            left_out: None,
        }
    }
}

/// The indices of `frames` by what to show first: failures by their worst tiles, then those without a number, then what passes.
pub(super) fn worst_first(frames: &[ReportedFrame]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..frames.len()).collect();
    order.sort_by(|a, b| badness(&frames[*b]).total_cmp(&badness(&frames[*a])));
    order
}

fn badness(frame: &ReportedFrame) -> f64 {
    let tile = frame.comparison.as_ref().and_then(|comparison| comparison.flip).map(|flip| flip.tile);
    match frame.status {
        FrameStatus::Passed => -1.0,
        _ => tile.unwrap_or(0.0),
    }
}
