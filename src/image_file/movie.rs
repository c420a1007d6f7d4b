//! Movies: animated PNG, WebP and GIF, and film formats by `ffmpeg` where it is installed.
//!
//! Frames are sRGB with straight alpha. Animated PNG and WebP are lossless. GIF has 256 colours and one-bit alpha, which is dithered, and
//! at most 50 frames a second. Films have alpha in WebM and QuickTime, where their first frame has; others are composited over black.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, RgbaImage};

use super::atomic::{Replacement, begin_replacing};
use super::display::over;
use super::ffmpeg::{FilmFormat, ffmpeg, has_ffmpeg};
use super::film_encoder::FilmEncoder;
use super::frame_delays::{
    GIF_DURATIONS, PNG_DURATIONS, WEBP_DURATIONS, lost_rate, png_delay, rounded_delay,
};
use super::gif_frames::{
    MAX_RATE, delay_ms, is_too_fast, one_bit_alpha, palette_speed, reserve_transparent_color,
};
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
    /// Film encoded by `ffmpeg`: H.264 in MP4, QuickTime or Matroska, VP9 in `WebM`; with alpha `ProRes` 4444 in QuickTime.
    Film {
        /// Container, as `ffmpeg` names it.
        container: &'static str,
        /// Codec of opaque films, as `ffmpeg` names it.
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
    /// Whether a frame had alpha that the movie does not hold: partly transparent pixels in GIF, any but opaque ones in films without alpha.
    has_lost_alpha: bool,
    replacement: Replacement,
    encoder: Encoder,
}

enum Encoder {
    AnimatedPng(png::Writer<Sink>, Sink),
    WebP(WebpAnimation<Sink>),
    Gif(Box<GifEncoder<Sink>>, Sink),
    /// A film before its first frame, which decides about alpha.
    FutureFilm {
        container: &'static str,
        codec: &'static str,
        cancel: CancelFlag,
    },
    Film {
        encoder: FilmEncoder,
        format: FilmFormat,
    },
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
    /// [`Error::CannotCreate`] where the file cannot be created, [`Error::WriteFailed`] where it cannot be written.
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
                let mut gif = GifEncoder::new_with_speed(
                    sink.clone(),
                    palette_speed(u64::from(size.0) * u64::from(size.1)),
                );
                gif.set_repeat(Repeat::Infinite).map_err(|error| write_failed(path, error))?;
                Encoder::Gif(Box::new(gif), sink)
            }
            MovieFormat::Film { container, codec } => {
                Encoder::FutureFilm { container, codec, cancel: cancel.clone() }
            }
        };
        Ok(Self { path: path.to_owned(), size, rate, added: 0, has_lost_alpha: false, replacement, encoder })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::WriteFailed`], and [`Error::Internal`] when it has another size than the movie. With the first frame of a film,
    /// [`Error::CannotCreate`] where `ffmpeg` cannot be started and [`Error::Temporary`] where the system starts no thread.
    pub fn add(&mut self, pixels: &[[u8; 4]]) -> Result<()> {
        let (width, height) = self.size;
        if pixels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(Error::Internal { message: "the frames of a movie differ in size".to_owned() });
        }
        if let Encoder::FutureFilm { container, codec, cancel } = &self.encoder {
            let has_alpha = FilmFormat::may_have_alpha(container) && !is_opaque(pixels);
            let format = FilmFormat { container, codec, has_alpha };
            let command = ffmpeg(self.size, self.rate, format, self.replacement.path());
            let encoder = FilmEncoder::start(command, &self.path, cancel)?;
            self.encoder = Encoder::Film { encoder, format };
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
                let mut pixels = dithered.unwrap_or_else(|| pixels.to_vec());
                reserve_transparent_color(&mut pixels);
                let image = RgbaImage::from_raw(width, height, pixels.into_flattened()).ok_or_else(|| {
                    Error::Internal { message: "a frame of a movie cannot be copied".to_owned() }
                })?;
                let frame = image::Frame::from_parts(image, 0, 0, Delay::from_numer_denom_ms(delay, 1));
                gif.encode_frame(frame).map_err(|error| write_failed(&self.path, error))
            }
            Encoder::Film { encoder, format } if format.has_alpha => {
                encoder.add(pixels.as_flattened().to_vec())
            }
            Encoder::Film { encoder, .. } => {
                self.has_lost_alpha |= !is_opaque(pixels);
                encoder.add(pixels.iter().flat_map(|pixel| over(*pixel, [0; 3])).collect())
            }
            Encoder::FutureFilm { .. } => Ok(()),
        }
    }

    /// What the format does not keep of the frames that were added.
    pub fn warnings(&self) -> Vec<Warning> {
        let is_fast_gif = matches!(self.encoder, Encoder::Gif(..)) && is_too_fast(self.rate);
        let alpha = match &self.encoder {
            Encoder::Film { format, .. } if FilmFormat::may_have_alpha(format.container) => {
                "the first frame is opaque and so is the film: the other frames are composited over black; .webp and .apng keep their alpha"
            }
            Encoder::Film { .. } => {
                "this format has no alpha: the frames are composited over black; .webm, .mov, .webp and .apng keep alpha"
            }
            _ => {
                "GIF has pixels that are opaque or transparent: shadows and edges between are dithered; .webp and .apng keep them"
            }
        };
        let rate = format!(
            "GIF has {MAX_RATE} frames a second at most: some are left out; .webp and .apng keep all"
        );
        let durations = match self.encoder {
            Encoder::AnimatedPng(..) => Some(PNG_DURATIONS),
            Encoder::WebP(_) => Some(WEBP_DURATIONS),
            Encoder::Gif(..) => Some(GIF_DURATIONS),
            Encoder::FutureFilm { .. } | Encoder::Film { .. } => None,
        };
        let is_timed = self.added > 1;
        let lost_rate = durations.filter(|_| is_timed).and_then(|durations| lost_rate(self.rate, durations));
        let lost_rate = lost_rate.unwrap_or_default();
        let told = [(self.has_lost_alpha, alpha), (is_fast_gif, &rate), (!lost_rate.is_empty(), &lost_rate)];
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
            Encoder::Film { encoder, .. } => encoder.finish(replacement.path())?,
            Encoder::FutureFilm { .. } => {
                return Err(Error::Internal { message: "a film has no frames".to_owned() });
            }
        }
        replacement.commit(&path)
    }
}

fn is_opaque(pixels: &[[u8; 4]]) -> bool {
    pixels.iter().all(|pixel| pixel[3] == u8::MAX)
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
mod tests;
