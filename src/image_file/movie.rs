//! Movies: animated PNG, WebP and GIF, and film formats by `ffmpeg` where it is installed.
//!
//! Frames are sRGB with straight alpha. Animated PNG and WebP are lossless. GIF has 256 colours and one-bit alpha, which is dithered, and
//! at most 50 frames a second. Films have no alpha; frames are composited over black.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, RgbaImage};

use super::atomic::{Replacement, begin_replacing};
use super::ffmpeg::{ffmpeg, has_ffmpeg, over_black};
use super::film_encoder::FilmEncoder;
use super::frame_delays::{png_delay, rounded_delay};
use super::gif_frames::{MAX_RATE, delay_ms, is_too_fast, one_bit_alpha, palette_speed};
use super::movie_mark::{MOVIE_MARK, gif_comment_and_trailer};
use super::webp_animation::{self, WebpAnimation};
use crate::cancel::CancelFlag;
use crate::error::{Error, Result, Warning};

/// Format of a movie file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovieFormat {
    /// Animated PNG: lossless, plays in browsers.
    AnimatedPng,
    /// Animated WebP: lossless, smaller than PNG, plays in browsers.
    WebP,
    /// GIF: plays everywhere.
    Gif,
    /// Film encoded by `ffmpeg`: H.264 in MP4, QuickTime or Matroska, VP9 in `WebM`.
    Film {
        /// Container, as `ffmpeg` names it.
        container: &'static str,
        /// Codec, as `ffmpeg` names it.
        codec: &'static str,
    },
}

/// File name extensions that [`MovieFormat::of_path`] knows, for messages.
pub const MOVIE_ENDINGS: &str = ".apng, .webp, .gif, .mp4, .mov, .webm or .mkv";

impl MovieFormat {
    /// Format of a file name extension.
    pub fn of_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        let film = |container, codec| Some(Self::Film { container, codec });
        match ending.as_str() {
            "apng" | "png" => Some(Self::AnimatedPng),
            "webp" => Some(Self::WebP),
            "gif" => Some(Self::Gif),
            "mp4" | "m4v" => film("mp4", "libx264"),
            "mov" => film("mov", "libx264"),
            "webm" => film("webm", "libvpx-vp9"),
            "mkv" => film("matroska", "libx264"),
            _ => None,
        }
    }

    /// Whether movies of this format can be written here with frames of `size`.
    ///
    /// # Errors
    /// What to do instead, in one line: `ffmpeg` is missing, or a side is too long for the format.
    pub fn check(self, (width, height): (u32, u32)) -> std::result::Result<(), String> {
        let longest = match self {
            Self::WebP => webp_animation::MAX_SIDE,
            Self::Gif => u32::from(u16::MAX),
            Self::Film { .. } if !has_ffmpeg() => {
                return Err("this format needs ffmpeg, which is not installed here; .apng, .webp and .gif need no other \
                            program"
                    .to_owned());
            }
            Self::AnimatedPng | Self::Film { .. } => return Ok(()),
        };
        if width.max(height) > longest {
            return Err(format!(
                "this format holds images of at most {longest} pixels a side, and {width}x{height} are asked for; write .apng"
            ));
        }
        Ok(())
    }
}

/// Writer of a movie, frame by frame. The file appears under its name when it is finished, or not at all.
pub struct MovieWriter {
    path: PathBuf,
    size: (u32, u32),
    /// Frame rate as numerator and denominator.
    rate: (u32, u32),
    added: u64,
    /// Whether a frame had alpha that the format does not hold: partly transparent pixels in GIF, any but opaque ones in films.
    has_lost_alpha: bool,
    replacement: Replacement,
    encoder: Encoder,
}

enum Encoder {
    AnimatedPng(png::Writer<Sink>, Sink),
    WebP(WebpAnimation<Sink>),
    Gif(Box<GifEncoder<Sink>>, Sink),
    Film(FilmEncoder),
}

/// A file that an encoder owns and that can be flushed after it.
#[derive(Clone)]
struct Sink(Arc<Mutex<BufWriter<File>>>);

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}

impl Seek for Sink {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).seek(to)
    }
}

impl MovieWriter {
    /// Starts a movie of `frames` frames of one size. `cancel` ends the wait for an encoder that is slow.
    ///
    /// # Errors
    /// [`Error::CannotCreate`] where the file cannot be created or `ffmpeg` cannot be started, [`Error::WriteFailed`] where it cannot be
    /// written, [`Error::Temporary`] where the system starts no thread.
    pub fn begin(
        path: &Path,
        format: MovieFormat,
        size: (u32, u32),
        rate: (u32, u32),
        frames: u32,
        cancel: &CancelFlag,
    ) -> Result<Self> {
        let replacement = begin_replacing(path)?;
        let sink =
            || -> Result<Sink> { Ok(Sink(Arc::new(Mutex::new(BufWriter::new(replacement.reopen(path)?))))) };
        let encoder = match format {
            MovieFormat::AnimatedPng => {
                let sink = sink()?;
                let png = animated_png(sink.clone(), size, rate, frames);
                Encoder::AnimatedPng(png.map_err(|error| write_failed(path, error))?, sink)
            }
            MovieFormat::WebP => {
                let webp = WebpAnimation::new(sink()?, size, frames);
                Encoder::WebP(webp.map_err(|error| write_failed(path, error))?)
            }
            MovieFormat::Gif => {
                let sink = sink()?;
                let mut gif = GifEncoder::new_with_speed(sink.clone(), palette_speed(size));
                gif.set_repeat(Repeat::Infinite).map_err(|error| write_failed(path, error))?;
                Encoder::Gif(Box::new(gif), sink)
            }
            MovieFormat::Film { container, codec } => {
                let command = ffmpeg(size, rate, (container, codec), replacement.path());
                Encoder::Film(FilmEncoder::start(command, path, cancel)?)
            }
        };
        Ok(Self { path: path.to_owned(), size, rate, added: 0, has_lost_alpha: false, replacement, encoder })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::WriteFailed`], and [`Error::Internal`] when it has another size than the movie.
    pub fn add(&mut self, pixels: &[[u8; 4]]) -> Result<()> {
        let (width, height) = self.size;
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(Error::Internal { message: "the frames of a movie differ in size".to_owned() });
        }
        let added = self.added;
        self.added += 1;
        match &mut self.encoder {
            Encoder::AnimatedPng(png, _) => {
                png.write_image_data(pixels.as_flattened()).map_err(|error| write_failed(&self.path, error))
            }
            Encoder::WebP(webp) => webp
                .add(pixels, rounded_delay(added, self.rate, 1000).clamp(1, (1 << 24) - 1))
                .map_err(|error| write_failed(&self.path, error)),
            Encoder::Gif(gif, _) => {
                let Some(delay) = delay_ms(added, self.rate) else { return Ok(()) };
                let dithered = one_bit_alpha(pixels, width);
                self.has_lost_alpha |= dithered.is_some();
                let pixels = dithered.unwrap_or_else(|| pixels.to_vec()).into_flattened();
                let image = RgbaImage::from_raw(width, height, pixels).ok_or_else(|| Error::Internal {
                    message: "a frame of a movie cannot be copied".to_owned(),
                })?;
                let frame = image::Frame::from_parts(image, 0, 0, Delay::from_numer_denom_ms(delay, 1));
                gif.encode_frame(frame).map_err(|error| write_failed(&self.path, error))
            }
            Encoder::Film(film) => {
                self.has_lost_alpha |= pixels.iter().any(|pixel| pixel[3] != u8::MAX);
                film.add(pixels.iter().flat_map(|pixel| over_black(*pixel)).collect())
            }
        }
    }

    /// What the format does not keep of the frames that were added.
    pub fn warnings(&self) -> Vec<Warning> {
        let is_fast_gif = matches!(self.encoder, Encoder::Gif(..)) && is_too_fast(self.rate);
        let alpha = match self.encoder {
            Encoder::Film(_) => {
                "films have no alpha: the frames are composited over black; .webp and .apng keep alpha, as do frames in .png and .exr files"
            }
            _ => {
                "GIF has pixels that are opaque or transparent: shadows and edges between are dithered; .webp and .apng keep them"
            }
        };
        let rate = format!(
            "GIF has {MAX_RATE} frames a second at most: some are left out; .webp and .apng keep all"
        );
        let told = [(self.has_lost_alpha, alpha), (is_fast_gif, &rate)];
        let told = told.into_iter().filter(|(is_so, _)| *is_so);
        told.map(|(_, why)| Warning {
            pointer: String::new(),
            message: format!("{}: {why}", self.path.display()),
        })
        .collect()
    }

    /// Completes the file under its final name.
    ///
    /// # Errors
    /// [`Error::WriteFailed`].
    pub fn finish(self) -> Result<()> {
        let Self { path, replacement, encoder, .. } = self;
        match encoder {
            Encoder::AnimatedPng(png, mut sink) => {
                png.finish().map_err(|error| write_failed(&path, error))?;
                sink.flush().map_err(|error| write_failed(&path, error))?;
            }
            Encoder::WebP(webp) => webp.finish().map_err(|error| write_failed(&path, error))?,
            Encoder::Gif(gif, mut sink) => {
                drop(gif);
                // The mark takes the place of the last byte, which ends the file.
                let marked =
                    sink.seek(SeekFrom::End(-1)).and_then(|_| sink.write_all(&gif_comment_and_trailer()));
                marked.map_err(|error| write_failed(&path, error))?;
                sink.flush().map_err(|error| write_failed(&path, error))?;
            }
            Encoder::Film(film) => film.finish(replacement.path())?,
        }
        replacement.commit(&path)
    }
}

fn animated_png(
    sink: Sink,
    (width, height): (u32, u32),
    rate: (u32, u32),
    frames: u32,
) -> std::result::Result<png::Writer<Sink>, png::EncodingError> {
    let mut encoder = png::Encoder::new(sink, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("renderHash".to_owned(), MOVIE_MARK.to_owned())?;
    encoder.set_animated(frames, 0)?;
    let (numerator, denominator) = png_delay(rate);
    encoder.set_frame_delay(numerator, denominator)?;
    encoder.write_header()
}

fn write_failed(path: &Path, error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Error {
    Error::WriteFailed { path: path.to_owned(), source: io::Error::other(error) }
}

#[cfg(test)]
mod tests {
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
    fn films_and_gifs_warn_of_alpha_that_they_lose() {
        let warnings = |name: &str, alphas: [u8; 2]| {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join(name);
            let format = MovieFormat::of_path(&path).unwrap();
            let mut movie =
                MovieWriter::begin(&path, format, (4, 3), (24, 1), 2, &CancelFlag::new()).unwrap();
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
                assert!(said.contains("films have no alpha") && said.contains(".apng"), "{said}");
            }
        }
    }
}
