use super::*;
use crate::image::{ColorEncoding, RenderedScene};
use crate::image_file::{ExrIntegrity, RunStamp, encode_exr, verify_exr};

/// An image of three types of samples, a part of whose rows is `window`.
fn image(whole: PixelWindow, window: PixelWindow) -> Image {
    let values = || {
        (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| x * 7 + y * 31 + (x ^ y) % 5))
    };
    let channel = |name: &str, samples| Channel { name: name.to_owned(), samples };
    let halves = values().map(|value| half::f16::from_f32(value as f32 * 0.01));
    Image {
        display_window: PixelWindow::full(whole.x1 + 3, whole.y1 + 2),
        data_window: window,
        encoding: ColorEncoding::Linear,
        channels: vec![
            channel("R", Samples::Half(halves.collect())),
            channel("Z", Samples::Float(values().map(|value| value as f32).collect())),
            channel("id", Samples::Uint(values().collect())),
        ],
        scene: RenderedScene::default(),
    }
}

fn bands(window: PixelWindow, rows: u32) -> impl Iterator<Item = PixelWindow> {
    (window.y0..window.y1).step_by(rows as usize).map(move |y0| PixelWindow {
        y0,
        y1: (y0 + rows).min(window.y1),
        ..window
    })
}

#[test]
fn files_of_bands_have_the_bytes_of_the_whole_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let attributes = FrameAttributes::unknown();
    // A crop whose rows are no multiple of any chunk's, and an image of one row.
    for whole in [PixelWindow { x0: 5, y0: 7, x1: 42, y1: 610 }, PixelWindow::full(9, 1)] {
        for compression in ExrCompression::ALL {
            let expected = encode_exr(image(whole, whole), compression, &attributes).unwrap();
            let rows = ExrBands::rows_of_chunks(compression);
            for rows in [rows, 2 * rows, 100 * rows] {
                let mut parts = bands(whole, rows).map(|window| image(whole, window)).peekable();
                let first = parts.peek().unwrap();
                let mut file = ExrBands::begin(&path, whole, first, compression, &attributes).unwrap();
                for band in parts {
                    file.write(band).unwrap();
                }
                let written = file.finish(&attributes, &CancelFlag::new()).unwrap();
                let bytes = std::fs::read(&path).unwrap();
                assert!(bytes == expected, "{} in bands of {rows} rows", compression.name());
                assert_eq!(written, WrittenExr { sha256: hex(&Sha256::digest(&bytes)), bytes: bytes.len() });
                assert_eq!(verify_exr(&mut Cursor::new(&bytes)).unwrap(), ExrIntegrity::Whole);
            }
        }
    }
}

#[test]
fn a_stamp_is_taken_at_the_end() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let whole = PixelWindow::full(20, 40);
    let stamped = |render_seconds| FrameAttributes {
        stamp: Some(RunStamp {
            capture_date: "2026:11:21 18:57:00".to_owned(),
            host: Some("farm7".to_owned()),
            render_seconds,
        }),
        ..FrameAttributes::unknown()
    };
    let band = image(whole, whole);
    let mut file = ExrBands::begin(&path, whole, &band, ExrCompression::Zip, &stamped(0.0)).unwrap();
    file.write(band.clone()).unwrap();
    file.finish(&stamped(2.5), &CancelFlag::new()).unwrap();
    assert!(std::fs::read(&path).unwrap() == encode_exr(band, ExrCompression::Zip, &stamped(2.5)).unwrap());
}

#[test]
fn incomplete_and_cancelled_files_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let (whole, attributes) = (PixelWindow::full(20, 40), FrameAttributes::unknown());
    let part = |y0, y1| image(whole, PixelWindow { y0, y1, ..whole });
    let begin = || ExrBands::begin(&path, whole, &part(0, 16), ExrCompression::Zip, &attributes).unwrap();
    let is_internal = |error: Error| matches!(error, Error::Internal { .. });

    // Bands of other rows, other columns and other channels.
    let mut file = begin();
    file.write(part(0, 16)).unwrap();
    assert!(is_internal(file.write(part(0, 16)).unwrap_err()));
    assert!(is_internal(file.write(part(16, 20)).unwrap_err()));
    assert!(is_internal(file.write(image(whole, PixelWindow { x0: 1, y0: 16, ..whole })).unwrap_err()));
    let mut other = part(16, 40);
    other.channels.pop();
    assert!(is_internal(file.write(other).unwrap_err()));
    assert!(is_internal(file.finish(&attributes, &CancelFlag::new()).unwrap_err()));

    let mut file = begin();
    file.write(part(0, 40)).unwrap();
    let cancel = CancelFlag::new();
    cancel.raise();
    assert!(matches!(file.finish(&attributes, &cancel).unwrap_err(), Error::Interrupted(_)));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
