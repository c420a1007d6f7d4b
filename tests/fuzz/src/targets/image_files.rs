//! Reading of OpenEXR and Radiance files, and merging of tiles.

use std::ffi::OsStr;
use std::io::Cursor;
use std::path::Path;

use rayframe::cancel::CancelFlag;
use rayframe::image_file::{ExrHeader, decode_exr, inspect_exr, read_environment, read_plate};
use rayframe::merge::{MergePlan, join_frame, write_joined_frame};
use rayframe::settings::OutputPattern;

use crate::input::Input;
use crate::scratch;
use crate::verdict::{LIBRARY_LIMIT, accepted, must};

/// A Radiance file as environment and as plate.
pub(crate) fn hdr(input: &[u8]) {
    let path = Path::new("a.hdr");
    if let Some(environment) = accepted(read_environment(path, input, LIBRARY_LIMIT)) {
        assert_eq!(environment.pixels.len(), environment.width as usize * environment.height as usize);
        assert!(environment.pixels.iter().flatten().all(|value| value.is_finite()), "a value is not finite");
    }
    accepted(read_plate(path, input, LIBRARY_LIMIT));
}

/// An OpenEXR file as image, environment, plate and finished frame.
pub(crate) fn exr(input: &[u8]) {
    let path = Path::new("a.exr");
    if let Some(image) = accepted(decode_exr(path, input, LIBRARY_LIMIT)) {
        let pixels = image.data_window.pixel_count();
        assert!(
            image.channels.iter().all(|channel| channel.samples.len() == pixels),
            "a channel has other pixels"
        );
    }
    accepted(read_environment(path, input, LIBRARY_LIMIT));
    accepted(read_plate(path, input, LIBRARY_LIMIT));
    drop(ExrHeader::parse(&mut Cursor::new(input)));
    drop(inspect_exr(&scratch::file("a.exr", input)));
}

/// Two tiles, merged.
pub(crate) fn merge(input: &[u8]) {
    let mut input = Input::new(input);
    let first = scratch::file("first.exr", input.part());
    let second = scratch::file("second.exr", input.part());
    let pattern = scratch::path("merged.exr");
    let pattern = must(OutputPattern::parse(OsStr::new(&pattern)));
    if let Some(plan) = accepted(MergePlan::new(&[first, second], &pattern, true, LIBRARY_LIMIT)) {
        for frame in &plan.frames {
            if let Some(joined) = accepted(join_frame(frame)) {
                accepted(write_joined_frame(frame, &joined, &CancelFlag::new()));
            }
        }
    }
}
