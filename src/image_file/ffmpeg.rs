//! The encoder `ffmpeg`, a program of its own that takes raw frames from its standard input.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::movie_mark::MOVIE_MARK;
use crate::child_process::OwnedChild;

/// Time in which the program tells its version.
const VERSION_TIME: Duration = Duration::from_secs(30);

/// How a film is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FilmFormat {
    /// Container, as `ffmpeg` names it.
    pub(super) container: &'static str,
    /// Codec of opaque films, as `ffmpeg` names it.
    pub(super) codec: &'static str,
    /// Whether frames have alpha.
    pub(super) has_alpha: bool,
}

impl FilmFormat {
    /// Whether films of a container may have alpha.
    pub(super) fn may_have_alpha(container: &str) -> bool {
        matches!(container, "webm" | "mov")
    }

    /// Options of the codec, and the format of its pixels.
    fn codec_options(self) -> (&'static [&'static str], &'static str) {
        match (self.codec, self.has_alpha) {
            ("libvpx-vp9", true) => (&["-c:v", "libvpx-vp9", "-crf", "18", "-b:v", "0"], "yuva420p"),
            ("libvpx-vp9", false) => (&["-c:v", "libvpx-vp9", "-crf", "18", "-b:v", "0"], "yuv420p"),
            (_, true) => (&["-c:v", "prores_ks", "-profile:v", "4444", "-alpha_bits", "16"], "yuva444p10le"),
            (_, false) => (&["-c:v", "libx264", "-crf", "18"], "yuv420p"),
        }
    }
}

/// Conversion of frames to the film's pixels: an even number of columns and rows, BT.709 in its limited range, and sRGB's transfer.
fn filters(pixel_format: &str) -> String {
    format!(
        "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=black@0,scale=out_color_matrix=bt709:out_range=tv,format={pixel_format},\
         setparams=colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1"
    )
}

/// Whether `ffmpeg` can be started. It is tried once.
pub fn has_ffmpeg() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let mut command = Command::new("ffmpeg");
        command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(process) = command.spawn() else { return false };
        let start = Instant::now();
        let ended = OwnedChild(process).wait_unless(|| start.elapsed() > VERSION_TIME);
        matches!(ended, Ok(Some(status)) if status.success())
    })
}

/// Command that encodes raw frames from its standard input. Films are padded to an even number of columns and rows.
pub(super) fn ffmpeg(
    (width, height): (u32, u32),
    (numerator, denominator): (u32, u32),
    format: FilmFormat,
    path: &Path,
) -> Command {
    let (codec_options, pixel_format) = format.codec_options();
    let mut command = Command::new("ffmpeg");
    command
        .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgba"])
        .args(["-s", &format!("{width}x{height}"), "-r", &format!("{numerator}/{denominator}"), "-i", "-"])
        .args(["-vf", &filters(pixel_format)])
        .args(codec_options)
        // Version 5.1 takes primaries and transfer from these options, version 9.0 from the frames, which the filters tag.
        .args(["-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1"])
        .args(["-fflags", "+bitexact", "-flags:v", "+bitexact"]);
    command.args(["-metadata", &format!("comment={MOVIE_MARK}")]);
    if matches!(format.container, "mp4" | "mov") {
        command.args(["-movflags", "+faststart"]);
    }
    // With the prefix, names with a colon or a leading dash are file names, too.
    let mut output = OsString::from("file:");
    output.push(path);
    command.args(["-f", format.container]).arg(output);
    // A terminal's interrupt must not end the encoder before this program, which would look like an encoder failure.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn film_names_are_always_passed_as_files() {
        for name in ["-y.mp4", "http:a.mp4", "a b/c.mp4"] {
            let format = FilmFormat { container: "mp4", codec: "libx264", has_alpha: false };
            let command = ffmpeg((4, 3), (24, 1), format, Path::new(name));
            assert_eq!(
                command.get_args().last().unwrap(),
                OsString::from(format!("file:{name}")).as_os_str()
            );
        }
    }

    #[test]
    fn films_name_their_primaries_and_transfer() {
        let folder = tempfile::tempdir().unwrap();
        for (container, codec, has_alpha) in [
            ("mp4", "libx264", false),
            ("webm", "libvpx-vp9", false),
            ("webm", "libvpx-vp9", true),
            ("mov", "libx264", true),
        ] {
            let path = folder.path().join(format!("a.{container}"));
            let mut command = ffmpeg((3, 2), (24, 1), FilmFormat { container, codec, has_alpha }, &path);
            let arguments: Vec<_> =
                command.get_args().map(|text| text.to_string_lossy().into_owned()).collect();
            // Version 9.0 ignores the options.
            let filters = arguments.iter().skip_while(|text| *text != "-vf").nth(1).unwrap();
            let tagged = "setparams=colorspace=bt709:color_primaries=bt709:color_trc=iec61966-2-1";
            assert!(filters.ends_with(tagged) && arguments.contains(&"-color_trc".to_owned()));
            if !has_ffmpeg() {
                continue;
            }
            let mut process = command.stdin(Stdio::piped()).spawn().unwrap();
            std::io::Write::write_all(&mut process.stdin.take().unwrap(), &[128; 24]).unwrap();
            assert!(process.wait().unwrap().success());
            let read = Command::new("ffmpeg").arg("-hide_banner").arg("-i").arg(&path).output().unwrap();
            let said = String::from_utf8_lossy(&read.stderr).into_owned();
            assert!(said.contains("bt709/bt709/iec61966-2-1"), "{said}");
        }
    }
}
