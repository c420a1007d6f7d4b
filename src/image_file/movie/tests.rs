use super::*;
use image::AnimationDecoder as _;

fn frames() -> Vec<Vec<[u8; 4]>> {
    (0..5_u8).map(|number| (0..12).map(|i| [number * 40, i * 20, 255, 255]).collect()).collect()
}

fn written(name: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let format = MovieFormat::of_path(&path).unwrap();
    let mut movie = MovieWriter::begin(&path, format, (4, 3), (24, 1), 5, &CancelFlag::new()).unwrap();
    for frame in frames() {
        movie.add(&frame).unwrap();
    }
    assert!(!path.exists(), "an unfinished movie must not have its final name");
    movie.finish().unwrap();
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1);
    std::fs::read(path).unwrap()
}

#[test]
fn animated_pngs_hold_every_frame_and_the_rate() {
    let bytes = written("a.apng");
    let decoder = image::codecs::png::PngDecoder::new(io::Cursor::new(&bytes)).unwrap().apng().unwrap();
    let decoded = decoder.into_frames().collect_frames().unwrap();
    assert_eq!(decoded.len(), 5);
    for (frame, expected) in decoded.iter().zip(frames()) {
        assert_eq!(frame.buffer().as_raw().as_slice(), expected.as_flattened());
    }
    assert_eq!(written("a.png"), bytes);
}

#[test]
fn animated_webps_hold_every_frame_and_keep_time() {
    let bytes = written("a.webp");
    let decoder = image::codecs::webp::WebPDecoder::new(io::Cursor::new(&bytes)).unwrap();
    let decoded = decoder.into_frames().collect_frames().unwrap();
    for (frame, expected) in decoded.iter().zip(frames()) {
        assert_eq!(frame.buffer().as_raw().as_slice(), expected.as_flattened());
    }
    // Frames of 24 fps begin at 0, 42, 83, 125, 167 and 208 ms.
    let milliseconds: Vec<_> = decoded.iter().map(|frame| frame.delay().numer_denom_ms().0).collect();
    assert_eq!(milliseconds, [42, 41, 42, 42, 41]);
    assert!(MovieFormat::WebP.check((16384, 1)).is_ok() && MovieFormat::WebP.check((1, 16385)).is_err());
}

#[test]
fn gifs_hold_every_frame() {
    let bytes = written("a.gif");
    let decoder = image::codecs::gif::GifDecoder::new(io::Cursor::new(&bytes)).unwrap();
    assert_eq!(decoder.into_frames().collect_frames().unwrap().len(), 5);
}

#[test]
fn ffmpeg_writes_the_named_containers() {
    if has_ffmpeg() {
        for (name, mark) in [("a.mp4", &b"ftyp"[..]), ("a.webm", b"webm"), ("a.mkv", b"matroska")] {
            let bytes = written(name);
            assert!(bytes.windows(mark.len()).take(64).any(|window| window == mark), "{name}");
        }
    }
    assert_eq!(MovieFormat::of_path(Path::new("a.avi")), None);
}

#[test]
fn films_keep_the_alpha_of_their_first_frame() {
    if !has_ffmpeg() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, alphas: [u8; 2]| {
        let format = MovieFormat::of_path(&path(name)).unwrap();
        let mut movie =
            MovieWriter::begin(&path(name), format, (32, 16), (24, 1), 2, &CancelFlag::new()).unwrap();
        for alpha in alphas {
            movie.add(&[[200, 100, 50, alpha]; 512]).unwrap();
        }
        let warnings: String = movie.warnings().iter().map(ToString::to_string).collect();
        movie.finish().unwrap();
        warnings
    };
    for (name, decoder) in [("a.webm", &["-c:v", "libvpx-vp9"][..]), ("a.mov", &[])] {
        assert_eq!(write(name, [128, 255]), "", "{name}");
        let mut command = std::process::Command::new("ffmpeg");
        command.args(["-loglevel", "error"]).args(decoder).arg("-i").arg(path(name));
        let output = command.args(["-f", "rawvideo", "-pix_fmt", "rgba", "-"]).output().unwrap();
        let (pixels, _) = output.stdout.as_chunks::<4>();
        assert_eq!(pixels.len(), 1024, "{name}: {}", String::from_utf8_lossy(&output.stderr));
        for (pixel, expected) in [(pixels[100], [200, 100, 50, 128]), (pixels[900], [200, 100, 50, 255])] {
            let is_close = pixel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 4);
            assert!(is_close, "{name}: {pixel:?} is not {expected:?}");
        }
        assert!(write(name, [255, 128]).contains("the first frame is opaque"), "{name}");
    }
    assert!(write("a.mp4", [128, 255]).contains("this format has no alpha"));
}

#[test]
fn films_and_gifs_warn_of_alpha_that_they_lose() {
    let warnings = |name: &str, alphas: [u8; 2]| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let format = MovieFormat::of_path(&path).unwrap();
        let mut movie = MovieWriter::begin(&path, format, (4, 3), (24, 1), 2, &CancelFlag::new()).unwrap();
        for alpha in alphas {
            movie.add(&[[80, 80, 80, alpha]; 12]).unwrap();
        }
        movie.warnings().iter().map(ToString::to_string).collect::<String>()
    };
    // GIF holds transparent pixels.
    assert_eq!(warnings("a.gif", [255, 0]), "");
    assert!(warnings("a.gif", [255, 128]).contains("dithered"));
    if has_ffmpeg() {
        assert_eq!(warnings("a.mp4", [255; 2]), "");
        for alpha in [0, 254] {
            let said = warnings("a.mp4", [255, alpha]);
            assert!(said.contains("this format has no alpha") && said.contains(".apng"), "{said}");
        }
    }
}
