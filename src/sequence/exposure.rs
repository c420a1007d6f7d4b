//! Exposure of tone-mapped files: one value for the whole animation, whatever frames are rendered.

use crate::bvh::TriangleFlags;
use crate::cancel::{CancelFlag, Cancelled};
use crate::film::{AovFlags, Film, PixelWindow};
use crate::frame::Frame;
use crate::integrator::Integrator;
use crate::output::{auto_exposure_ev, covers_enough, reflected_light};
use crate::render::{PathSettings, RenderSettings};
use crate::scene::{AnimationTarget, Channel, Environment, Material, MaterialProperty, Scene, Selection};
use crate::uneven::uneven_shares;

use super::job::duration_seconds;
use super::single_frame::render_single_frame_in;
use super::{Exposure, SequenceJob};

/// Columns and rows of the renders that are measured.
const SIZE: (u32, u32) = (64, 36);
/// Fewest and most measured times of an animation, its first and last among them.
const TIMES: [usize; 2] = [5, 17];
/// Number of posed triangles up to which more than the fewest times are measured.
const POSED_TRIANGLES: usize = 4_000_000;
/// Samples a pixel of Whitted's tree, which has next to no noise.
const WHITTED_SAMPLES: u32 = 1;
/// Fewest and most samples a pixel of paths, whose noise counts as highlights. Between them, many times share [`PATH_SAMPLES_OF_ALL`].
const PATH_SAMPLES: [u32; 2] = [16, 64];
/// Samples of paths at all times, a pixel.
const PATH_SAMPLES_OF_ALL: usize = 512;
/// Share of the light above which emissive surfaces decide instead of an environment that was made for an exposure.
const EMITTED_SHARE: f64 = 0.5;
/// Times of all clips that share an exposure.
const SHARED_TIMES: usize = 16 * TIMES[1];

/// Exposure of tone-mapped files in stops. Automatic exposure renders a few small frames, unless the studio alone lights the
/// scene; [`super::run`] computes it once and hands it on.
///
/// # Errors
/// [`Cancelled`] when `cancel` is raised.
pub fn exposure_ev(job: &SequenceJob, cancel: &CancelFlag) -> Result<f32, Cancelled> {
    match job.exposure {
        Exposure::Ev(ev) => Ok(ev),
        Exposure::Auto => match &job.shared_exposure {
            Some(shared) => shared.find(|| auto_exposure(job, &shared.selections, cancel)),
            None => auto_exposure(job, std::slice::from_ref(&job.selection), cancel),
        },
    }
}

/// Measures the light on the scene's surfaces; where these cover next to nothing, that of the background. An environment that
/// was made for an exposure decides instead where it lights the scene alone, or where what shines besides are emissive surfaces that bring
/// less light.
fn auto_exposure(job: &SequenceJob, selections: &[Selection], cancel: &CancelFlag) -> Result<f32, Cancelled> {
    let has_lamps = job.render.light_scale > 0.0 && job.selection.has_lights(&job.scene);
    let known = job.environment.exposure_ev().filter(|_| !has_lamps);
    if let Some(ev) = known.filter(|_| !may_be_lit_by_surfaces(job)) {
        return Ok(ev);
    }
    let measure = |environment: &Environment, show_background| {
        small_renders(job, (selections, environment), show_background, cancel)
    };
    let surfaces = measure(&job.environment, false)?;
    if let Some(ev) = known {
        let emitted = reflected_light(&measure(&Environment::None, false)?);
        if emitted <= EMITTED_SHARE * reflected_light(&surfaces) {
            return Ok(ev);
        }
    }
    if covers_enough(&surfaces) || !job.render.show_background {
        return Ok(auto_exposure_ev(&surfaces));
    }
    Ok(auto_exposure_ev(&measure(&job.environment, true)?))
}

/// Whether emissive surfaces are lamps and there may be some.
fn may_be_lit_by_surfaces(job: &SequenceJob) -> bool {
    let emits = |material: &Material| !material.unlit && material.emissive.max_element() > 0.0;
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
    job.render.integrator == Integrator::Path
        && (materials.iter().any(emits)
            || animations.iter().flat_map(|animation| &animation.channels).any(animated))
}

fn small_renders(
    job: &SequenceJob,
    (selections, environment): (&[Selection], &Environment),
    show_background: bool,
    cancel: &CancelFlag,
) -> Result<Vec<Film>, Cancelled> {
    let settings = RenderSettings {
        resolution: SIZE,
        window: PixelWindow::full(SIZE.0, SIZE.1),
        samples: WHITTED_SAMPLES,
        adaptive: None,
        // Base colours and emission, which a background does not have.
        aovs: AovFlags { centers: !show_background, light: !show_background, ..AovFlags::NONE },
        show_background,
        // Shadows alone tell nothing about the light.
        ground: None,
        path: PathSettings { sample_range: None, ..job.render.path },
        ..job.render.clone()
    };
    job.first_pose.clear();
    let mut films = Vec::new();
    for selection in selections {
        let duration = f64::from(duration_seconds(&job.scene, selection));
        let first = Frame::at(&job.scene, selection, 0.0);
        let count = if duration > 0.0 { times_of(first.triangles.len(), selections.len()) } else { 1 };
        let settings = RenderSettings { samples: samples(job, count * selections.len()), ..settings.clone() };
        let mut measure = |mut frame: Frame| {
            hide_shadow_catchers(&mut frame);
            films.push(render_single_frame_in(job, environment, (&frame, &settings), cancel)?.0);
            Ok(())
        };
        measure(first)?;
        if count > 1 {
            // A lamp may have any period. Few times may still miss one.
            let shares = uneven_shares(count - 2).chain([1.0]);
            let frames = shares.map(|share| Frame::at(&job.scene, selection, duration * share));
            frames.map(measure).collect::<Result<Vec<_>, _>>()?;
        }
    }
    Ok(films)
}

/// Number of measured times of an animation, by the number of its triangles and that of the selections that share the exposure.
fn times_of(triangles: usize, selections: usize) -> usize {
    let [fewest, most] = TIMES;
    let most = (SHARED_TIMES / selections).clamp(fewest, most);
    (POSED_TRIANGLES / triangles.max(1)).clamp(fewest, most)
}

/// Samples a pixel where `times` are measured in all.
fn samples(job: &SequenceJob, times: usize) -> u32 {
    match job.render.integrator {
        Integrator::Whitted => WHITTED_SAMPLES,
        Integrator::Path => {
            let [fewest, most] = PATH_SAMPLES;
            ((PATH_SAMPLES_OF_ALL / times.max(1)) as u32).next_power_of_two().clamp(fewest, most)
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
