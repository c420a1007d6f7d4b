//! Exposure of tone-mapped files: one value for the whole animation, whatever frames are rendered.

use crate::bvh::TriangleFlags;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, Film, PixelWindow};
use crate::frame::Frame;
use crate::geometry::smoothstep_f64;
use crate::integrator::Integrator;
use crate::output::{auto_exposure_ev, covers_enough, emission_ev, measured_light_stops};
use crate::render::{EnvSamples, PathSettings, RenderSettings, render_frame};
use crate::scene::{AnimationTarget, Channel, Environment, Material, MaterialProperty, Scene, Selection};

use super::environment_shares::{closed_share, environment_shares};
use super::measured_scene::MeasuredScene;
use super::measured_times::{MeasuredSpan, TIMES, times_of};
use super::{Exposure, SequenceJob};

/// Pixels of the renders that are measured, which have the shape of the image: 64x36 of 16:9.
const PIXELS: f64 = 64.0 * 36.0;
/// Samples a pixel of Whitted's tree, which has next to no noise.
const WHITTED_SAMPLES: u32 = 1;
/// Fewest and most samples a pixel of paths, whose noise counts as highlights.
const PATH_SAMPLES: [u32; 2] = [4, 64];
/// Samples a pixel that many times of paths share, as far as each has the fewest.
const SHARED_PATH_SAMPLES: usize = 256;
/// Triangles that are posed in all where more than the fewest times are measured.
const POSED_TRIANGLES: usize = 4_000_000;
/// Times of all selections that share an exposure.
const SHARED_TIMES: usize = 16 * TIMES[1];
/// Shares of the light up to which emissive surfaces leave the exposure to an environment that was made for one, and from which on it is measured.
const EMITTED_SHARES: [f64; 2] = [0.4, 0.8];

/// Exposure of tone-mapped files in stops. Automatic exposure renders a few small frames, unless the studio alone lights the
/// scene; [`super::run`] computes it once and hands it on.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub fn exposure_ev(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    match job.exposure {
        Exposure::Ev(ev) => Ok(ev),
        Exposure::Auto => {
            let Some(shared) = &job.shared_exposure else {
                let selections = std::slice::from_ref(&job.selection);
                return auto_exposure(job, Content { selections, resolution: job.render.resolution }, cancel);
            };
            let content = Content { selections: &shared.selections, resolution: shared.resolution };
            shared.find(|| auto_exposure(job, content, cancel))
        }
    }
}

/// What an exposure is that of.
#[derive(Clone, Copy)]
struct Content<'c> {
    selections: &'c [Selection],
    /// Columns and rows of the images.
    resolution: (u32, u32),
}

/// Measures the light on the scene's surfaces; where these cover next to nothing, that of the background. An environment that
/// was made for an exposure decides instead where it lights the scene alone and from everywhere: less the more of the light comes from emissive surfaces, and
/// not in closed spaces, which are darker than what is outside.
fn auto_exposure(job: &SequenceJob, content: Content<'_>, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let Some(built_in_ev) = job.environment.exposure_ev().filter(|_| !has_lamps(job)) else {
        return measured_ev(job, content, cancel);
    };
    let has_emissive_lamps =
        job.render.integrator == Integrator::Path && may_emit(job, |material| !material.unlit);
    let share = if has_emissive_lamps { emitted_share(job, content, cancel)? } else { None };
    let emitted = smoothstep_f64(EMITTED_SHARES, share.unwrap_or(0.0)) as f32;
    let closed = match content.selections.first().filter(|_| job.render.env_samples != EnvSamples::Fixed(0)) {
        Some(selection) => closed_share(job, selection, cancel)?,
        None => 0.0,
    };
    blended(emitted.max(closed), built_in_ev, || measured_ev(job, content, cancel))
}

/// Of two exposures, the first for a share of 0, the second for 1, and between them by the share.
fn blended(
    share: f32,
    first: f32,
    second: impl FnOnce() -> Result<f32, Cancelled>,
) -> Result<f32, Cancelled> {
    if share == 0.0 {
        return Ok(first);
    }
    let ev = first + (second()? - first) * share;
    Ok((ev * 100.0).round() / 100.0 + 0.0)
}

fn measured_ev(job: &SequenceJob, content: Content<'_>, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let measure = |show_background| {
        let measured = Measured { content, most_times: TIMES[1], emits_alone: false };
        small_renders(job, &measured, show_background, cancel)
    };
    let surfaces = measure(false)?;
    let is_background = !covers_enough(&surfaces) && job.render.show_background;
    let measured =
        if is_background { auto_exposure_ev(&measure(true)?) } else { auto_exposure_ev(&surfaces) };
    let lights_nothing = job.render.integrator == Integrator::Whitted && !job.environment.is_lit();
    if !lights_nothing || !may_emit(job, |_| true) {
        return Ok(measured);
    }
    // Mirror images of emitters would be measured as light on dark floors, and a black background as weak light.
    let share = if has_lamps(job) { emitted_share(job, content, cancel)? } else { None };
    let of_emission = emission_ev(&surfaces);
    let emitted = smoothstep_f64(EMITTED_SHARES, share.unwrap_or(1.0)) as f32;
    blended(emitted, measured, || Ok(if is_background { of_emission.min(measured) } else { of_emission }))
}

fn has_lamps(job: &SequenceJob) -> bool {
    job.render.light_scale > 0.0 && job.selection.has_lights(&job.scene)
}

/// The share of emissive surfaces in the light on the others, by the first selection at few times; `None` where there is none.
fn emitted_share(
    job: &SequenceJob,
    content: Content<'_>,
    cancel: &CancelFlag,
) -> Result<Option<f64>, Cancelled> {
    let content = Content { selections: content.selections.get(..1).unwrap_or_default(), ..content };
    let measure = |emits_alone| {
        let measured = Measured { content, most_times: TIMES[0], emits_alone };
        Ok(measured_light_stops(&small_renders(job, &measured, false, cancel)?))
    };
    let [all, emitted] = [measure(false)?, measure(true)?];
    Ok(all.map(|all| emitted.map_or(0.0, |emitted| libm::exp2(emitted - all))))
}

/// Whether there may be surfaces that emit light, of a material for which `counts` holds. What unlit ones show is emission.
fn may_emit(job: &SequenceJob, counts: impl Fn(&Material) -> bool) -> bool {
    let emits =
        |material: &Material| counts(material) && (material.unlit || material.emissive.max_element() > 0.0);
    let animated = |channel: &Channel| {
        matches!(
            channel.target,
            AnimationTarget::Material(
                _,
                MaterialProperty::EmissiveFactor | MaterialProperty::EmissiveStrength
            )
        )
    };
    let Scene { materials, animations, .. } = &*job.scene;
    materials.iter().any(emits) || animations.iter().flat_map(|animation| &animation.channels).any(animated)
}

/// What small renders show.
struct Measured<'m> {
    content: Content<'m>,
    /// Most times of an animation.
    most_times: usize,
    /// Whether emissive surfaces are the only lamps.
    emits_alone: bool,
}

fn small_renders(
    job: &SequenceJob,
    &Measured { content: Content { selections, resolution }, most_times, emits_alone }: &Measured<'_>,
    show_background: bool,
    cancel: &CancelFlag,
) -> Result<Vec<Film>, Cancelled> {
    let size = measured_size(resolution);
    let environment = if emits_alone { &Environment::None } else { &job.environment };
    let settings = RenderSettings {
        resolution: size,
        window: PixelWindow::full(size.0, size.1),
        samples: WHITTED_SAMPLES,
        adaptive: None,
        // Base colours and emission, which a background does not have.
        aovs: AovFlags { centers: !show_background, light: !show_background, ..AovFlags::NONE },
        show_background,
        light_scale: if emits_alone { 0.0 } else { job.render.light_scale },
        // Shadows alone tell nothing about the light.
        ground: None,
        path: PathSettings { sample_range: None, ..job.render.path },
        ..job.render.clone()
    };
    let mut films = Vec::new();
    for selection in selections {
        let environment_shares = environment_shares(job, selection, &job.render, cancel)?;
        let mut scene = MeasuredScene::new(job, selection);
        let span = MeasuredSpan::of(&job.scene, selection);
        let most = SHARED_TIMES / selections.len();
        let most = times_of(scene.frame().triangles.len(), POSED_TRIANGLES, most).min(most_times);
        let count = if span.moves() { most } else { 1 };
        let samples = samples(job, count * selections.len());
        let settings = RenderSettings { samples, environment_shares, ..settings.clone() };
        // A lamp may have any period. Few times may still miss one.
        for time_seconds in span.times(count) {
            scene.pose(time_seconds);
            hide_shadow_catchers(scene.frame_mut());
            let view = scene.view(environment, cancel)?;
            films.push(render_frame(&view, &settings, cancel, &|_| ())?.0);
        }
    }
    Ok(films)
}

/// Columns and rows that show what an image of this resolution shows.
fn measured_size((width, height): (u32, u32)) -> (u32, u32) {
    let columns = (PIXELS * f64::from(width) / f64::from(height)).sqrt().round().clamp(1.0, PIXELS);
    (columns as u32, (PIXELS / columns).round().max(1.0) as u32)
}

/// Samples a pixel where `times` are measured in all.
fn samples(job: &SequenceJob, times: usize) -> u32 {
    match job.render.integrator {
        Integrator::Whitted => WHITTED_SAMPLES,
        Integrator::Path => {
            let [fewest, most] = PATH_SAMPLES;
            ((SHARED_PATH_SAMPLES / times.max(1)) as u32).clamp(fewest, most)
        }
    }
}

/// Hides shadow catchers, which reflect no light of their own to measure and would block the view of what does.
fn hide_shadow_catchers(frame: &mut Frame) {
    for (flags, &instance) in frame.flags.iter_mut().zip(&frame.instance_of_triangle) {
        let material = frame.instances[instance as usize].material;
        if frame.materials[material.index()].is_shadow_catcher {
            *flags = flags.with(TriangleFlags::HIDDEN);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn renders_have_the_shape_of_the_image() {
        assert_eq!(measured_size((1920, 1080)), (64, 36));
        assert_eq!(measured_size((1080, 1920)), (36, 64));
        assert_eq!(measured_size((7, 7)), (48, 48));
        assert_eq!(measured_size((1, 65_535)), (1, 2304));
        assert_eq!(measured_size((65_535, 1)), (2304, 1));
    }
}
