//! Settings with names of files that are not Unicode.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt as _;

use crate::scene::NameOrIndex;
use crate::settings::{BackgroundSource, CameraPathSource, EnvironmentSource};

#[test]
fn rotations_follow_names_that_are_not_unicode() {
    let text = OsStr::from_bytes(b"\xff.hdr@-30");
    let source = EnvironmentSource::parse(text).unwrap();
    assert_eq!(source, EnvironmentSource::File(OsStr::from_bytes(b"\xff.hdr").into(), -30.0));
    assert_eq!(source.to_text(), text);
    let none = EnvironmentSource::parse(OsStr::from_bytes(b"a.hdr@\xff")).unwrap();
    assert_eq!(none, EnvironmentSource::File(OsStr::from_bytes(b"a.hdr@\xff").into(), 0.0));
}

#[test]
fn the_prefix_of_plates_precedes_names_that_are_not_unicode() {
    let text = OsStr::from_bytes(b"plate:\xff.exr");
    let BackgroundSource::Plate(plate) = BackgroundSource::parse(text).unwrap() else {
        panic!("no plate");
    };
    assert_eq!(plate.path(0).as_os_str().as_bytes(), b"\xff.exr");
    assert_eq!(plate.to_text(), text);
}

#[test]
fn cameras_follow_names_that_are_not_unicode() {
    let text = OsStr::from_bytes(b"\xff.glb#Hero");
    let source = CameraPathSource::parse(text).unwrap();
    assert_eq!(source.file.as_os_str().as_bytes(), b"\xff.glb");
    assert_eq!(source.camera, Some(NameOrIndex::Name("Hero".to_owned())));
    assert_eq!(source.to_text(), text);
    assert!(CameraPathSource::parse(OsStr::from_bytes(b"a.glb#\xff")).is_err());
}
