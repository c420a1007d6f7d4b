//! Summary: the first line of a run.

use rayframe::count_text::{grouped, plural};
use rayframe::framing::CameraRule;
use rayframe::scene::{Scene, SelectedCamera, Selection};
use rayframe::sequence::{Plan, SequenceJob, duration_seconds, frames_text, triangle_count};
use rayframe::settings::SettingValues;
use rayframe::shot::SequenceNames;

use super::camera_text::camera_text;

/// The clip, the camera and the variant have the names that tell the sequence from others, where `names` has any.
///
/// `orbit.glb: clip "orbit" 2.5 s → frames 0-60 at 24 fps, camera "cam", 1280x720, 7 936 triangles`.
pub(super) fn summary(
    job: &SequenceJob,
    names: &SequenceNames,
    camera: CameraRule,
    environment: &str,
) -> String {
    let (width, height) = job.render.resolution;
    let window = job.render.window;
    let crop = if (window.width(), window.height()) == (width, height) {
        String::new()
    } else {
        format!(" (pixels {},{} to {},{})", window.x0, window.y0, window.x1, window.y1)
    };
    let variant = job.selection.variant.and_then(|variant| job.scene.variants.get(variant.index()));
    let variant = variant.map_or_else(String::new, |variant| {
        format!(", variant \"{}\"", names.variant.as_deref().unwrap_or(&variant.name))
    });
    let environment = if environment.is_empty() { String::new() } else { format!(", {environment}") };
    format!(
        "{}: {} → {} at {} fps, {}{variant}, {width}x{height}{crop}, {}{environment}",
        file_name(&job.scene),
        clips_text(&job.scene, &job.selection, names.clip.as_deref()),
        frames_text(&job.frames),
        job.rate,
        camera_text(&job.scene, &job.selection, camera, names.camera.as_deref()),
        counted(triangle_count(&job.scene, &job.selection.roots), "triangle"),
    )
}

/// `frames are rendered in bands of 512 rows, as whole ones need more memory than --max-memory`; `None` where they fit or none
/// is rendered.
pub(super) fn rendered_in_bands(plan: &Plan) -> Option<String> {
    let text = |rows| {
        format!(
            "frames are rendered in bands of {rows} rows, as whole ones need more memory than --max-memory"
        )
    };
    plan.band_rows.filter(|_| plan.remaining() > 0).map(text)
}

/// `frames 84-100 lie after the animation's end (82) and show its last pose`; `None` where none do or nothing moves.
pub(super) fn after_the_end(job: &SequenceJob) -> Option<String> {
    let last = job.rate.last_frame(duration_seconds(&job.scene, &job.selection));
    let after: Vec<i64> = job.frames.iter().copied().filter(|&frame| frame > last).collect();
    let is_endless = match &job.selection.camera {
        SelectedCamera::Turntable(_) => true,
        SelectedCamera::Path(path) => path.is_loop,
        _ => false,
    };
    if after.is_empty() || is_endless || job.selection.clips.is_empty() {
        return None;
    }
    let (lie, show) = if after.len() == 1 { ("lies", "shows") } else { ("lie", "show") };
    Some(format!("{} {lie} after the animation's end ({last}) and {show} its last pose", frames_text(&after)))
}

/// `--movie also writes robot.####.exr; -o turn.mp4 writes the movie alone`; `None` where the frames are named or there is no movie.
pub(super) fn frames_beside_the_movie(job: &SequenceJob, args: &SettingValues) -> Option<String> {
    let movie = args.movie.as_deref().filter(|_| args.output.is_none())?;
    let (frames, movie) = (job.output.shown(), movie.display());
    Some(format!("--movie also writes {frames}; -o {movie} in its place writes the movie alone"))
}

fn file_name(scene: &Scene) -> String {
    let name = scene.path.file_name().unwrap_or(scene.path.as_os_str());
    name.display().to_string()
}

/// `clip "orbit" 2.5 s`, `3 clips 1 s to 2.5 s` or `still`. A clip with a name is called `known_as`, if anything.
fn clips_text(scene: &Scene, selection: &Selection, known_as: Option<&str>) -> String {
    let span = span_text(selection.clip_start_seconds(scene), selection.clip_seconds(scene));
    match selection.clips.as_slice() {
        [] => "still".to_owned(),
        [clip] => {
            let name = scene.animations.get(clip.index()).and_then(|clip| clip.name.as_deref());
            format!("clip {} {span}", quoted(name.map(|name| known_as.unwrap_or(name)), clip.index()))
        }
        clips => format!("{} clips {span}", clips.len()),
    }
}

/// Times of the first and the last key, seconds: `1 s to 2.5 s`, or `2.5 s` where the first is 0.
pub(super) fn span_text(start_seconds: f32, end_seconds: f32) -> String {
    let (start, end) = (short(start_seconds), short(end_seconds));
    if start == "0" || start == end { format!("{end} s") } else { format!("{start} s to {end} s") }
}

/// The name in quotes, or `#2` without a name. Options accept both.
pub(super) fn quoted(name: Option<&str>, index: usize) -> String {
    name.map_or_else(|| format!("#{index}"), |name| format!("\"{name}\""))
}

/// Number with at most three decimals.
pub(super) fn short(number: f32) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// `1 part` or `2 000 parts`.
pub(super) fn counted(count: u64, noun: &str) -> String {
    format!("{} {}", grouped(count), plural(count, noun))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_grouped() {
        assert_eq!(
            (short(2.5), short(10.0), short(1.041_666_6)),
            ("2.5".into(), "10".into(), "1.042".into())
        );
        assert_eq!(span_text(0.0, 2.5), "2.5 s");
        assert_eq!(span_text(1.0, 2.5), "1 s to 2.5 s");
        assert_eq!(span_text(1.0, 1.0), "1 s");
        assert_eq!(counted(1, "part"), "1 part");
        assert_eq!(counted(1000, "part"), "1 000 parts");
    }
}
