//! Coarse image: few pixels, scaled up, shown until the full image is finished.

use std::path::Path;
use std::sync::Arc;

use rayframe::cancel::CancelFlag;
use rayframe::error::Result;
use rayframe::film::{AovFlags, Film, PixelWindow};
use rayframe::frame::Frame;
use rayframe::image_file::{inspect_exr, inspect_png, write_atomically};
use rayframe::output::{exr_file, frame_attributes, png_file};
use rayframe::render::{PathSettings, PixelFilter, RenderSettings};
use rayframe::sequence::{OutputFormat, PlannedFrame, SequenceJob, exposure_ev, render_single_frame};

/// Side of a coarse pixel, in pixels of the full image.
const COARSENESS: u32 = 8;
/// Smaller images are rendered without a coarse one.
const LEAST_PIXELS: u64 = 64 * 64;

/// Prefix of the hash of a coarse image.
const MARK: &str = "coarse ";

/// Whether the file `path` is a coarse image.
pub(super) fn is_coarse(format: OutputFormat, path: &Path) -> bool {
    stored_hash(format, path).is_some_and(|hash| hash.starts_with(MARK))
}

/// Whether a stored hash belongs to the frame, or to a coarse image of any frame.
pub(super) fn is_of(stored: &str, render_hash: &str) -> bool {
    stored == render_hash || stored.starts_with(MARK)
}

fn stored_hash(format: OutputFormat, path: &Path) -> Option<String> {
    let stored = match format {
        OutputFormat::Exr => inspect_exr(path),
        OutputFormat::Png | OutputFormat::Movie(_) => inspect_png(path),
    };
    stored.ok()?.render_hash
}

/// Writes a coarse image under the frame's name: one sample per coarse pixel, without motion blur and depth of field.
pub(super) fn write(job: &SequenceJob, planned: &PlannedFrame, cancel: &CancelFlag) -> Result<()> {
    let window = job.render.window;
    if u64::from(window.width()) * u64::from(window.height()) < LEAST_PIXELS {
        return Ok(());
    }
    // The file is already better.
    if stored_hash(job.output.format(), &planned.path).as_ref() == Some(&planned.render_hash) {
        return Ok(());
    }
    let frame = Frame::at(&job.scene, &job.selection, planned.time_seconds);
    let mut film = scaled_up(&few_pixels(job, &frame, cancel)?, job.render.resolution, window);
    if let Some(plates) = &job.plates {
        film.plate = Some(Arc::new(plates.plate(planned.frame, job.render.resolution, window)?));
    }
    // The hash marks it as coarse.
    let hash = format!("{MARK}{}", planned.render_hash);
    let file = match job.output.format() {
        OutputFormat::Exr => {
            let attributes = frame_attributes(
                planned.frame,
                planned.time_seconds,
                job.rate.as_exr_rational(),
                &hash,
                (&frame.camera, film.resolution),
            );
            exr_file(&film, &attributes)?
        }
        OutputFormat::Png | OutputFormat::Movie(_) => {
            let look = job.look(exposure_ev(job, cancel)?);
            png_file(&film, look, &hash)?
        }
    };
    cancel.check()?;
    write_atomically(&planned.path, &file)
}

/// Film of the coarse image at full size.
fn few_pixels(job: &SequenceJob, frame: &Frame, cancel: &CancelFlag) -> Result<Film> {
    let (width, height) = job.render.resolution;
    let resolution = (width.div_ceil(COARSENESS), height.div_ceil(COARSENESS));
    let settings = RenderSettings {
        resolution,
        window: PixelWindow::full(resolution.0, resolution.1),
        samples: 1,
        adaptive: None,
        filter: PixelFilter::Box,
        lens: None,
        aovs: AovFlags::NONE,
        // The one sample is of no range.
        path: PathSettings { sample_range: None, ..job.render.path },
        ..job.render.clone()
    };
    Ok(render_single_frame(job, frame, &settings, cancel)?.0)
}

/// Enlarges a coarse film: each pixel gets the colour of the coarse pixel that covers it.
fn scaled_up(coarse: &Film, resolution: (u32, u32), window: PixelWindow) -> Film {
    let mut film = Film::new(resolution, window);
    let (width, height) = coarse.resolution;
    // The pixel of `few` that covers the centre of pixel `at` of `many`.
    let over = |at: u32, few: u32, many: u32| {
        (u64::from(2 * at + 1) * u64::from(few) / (2 * u64::from(many))) as usize
    };
    let places = (window.y0..window.y1).flat_map(|y| (window.x0..window.x1).map(move |x| (x, y)));
    for (pixel, (x, y)) in film.pixels.iter_mut().zip(places) {
        let row = over(y, height, resolution.1) * width as usize;
        *pixel = coarse.pixels[row + over(x, width, resolution.0)];
    }
    film
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;

    use rayframe::error::Provenance;
    use rayframe::gltf::ImageLoading;
    use rayframe::settings::Settings;
    use rayframe::shot::{ShotSettings, resolve};

    use super::*;

    #[test]
    fn every_pixel_shows_what_lies_over_it() {
        // Three columns over 20 pixels: 6 2/3 pixels each. The centre of pixel 6 lies at 6.5, that of pixel 7 beyond.
        let mut coarse = Film::new((3, 1), PixelWindow::full(3, 1));
        coarse.pixels = vec![[1.0; 4], [2.0; 4], [3.0; 4]];
        let film = scaled_up(&coarse, (20, 8), PixelWindow { x0: 5, y0: 1, x1: 20, y1: 3 });
        assert_eq!(film.pixels.len(), 30);
        for row in film.pixels.chunks(15) {
            let values: Vec<f32> = row.iter().map(|pixel| pixel[0]).collect();
            assert_eq!(values, [[1.0; 2].as_slice(), &[2.0; 6], &[3.0; 7]].concat());
        }
    }

    #[test]
    fn ranges_of_later_samples_have_a_coarse_image() {
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/light/point.gltf");
        let mut settings = Settings::default();
        let values =
            [("integrator", "path"), ("samples", "4"), ("sample_range", "2-3"), ("background", "none")];
        for (name, text) in values {
            settings.set(name, OsStr::new(text), &Provenance::CommandLine).unwrap();
        }
        let shot = ShotSettings::read_with(&scene, settings).unwrap();
        let job = resolve(&shot, ImageLoading::Texels).unwrap().sequence;
        let frame = Frame::at(&job.scene, &job.selection, 0.0);
        let film = few_pixels(&job, &frame, &CancelFlag::new()).unwrap();
        assert!(film.pixels.iter().any(|pixel| pixel[3] > 0.0));
    }
}
