//! Settings that have no effect beside some values of others, or contradict them. Where they come from a weaker level, they give way.
//!
//! What excludes another setting whatever its value is, is in the table of definitions.

use crate::output::Aov;
use crate::render::{Aperture, EnvSamples, Integrator};

use super::choices::DenoiserKind;
use super::definitions::{SettingValues, Settings};
use super::output_pattern::{OutputFormat, OutputPattern};

/// A setting that one integrator has alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfIntegrator {
    /// The setting.
    pub(crate) name: &'static str,
    /// The integrator.
    pub(crate) integrator: Integrator,
    /// Whether it asks for anything.
    pub(crate) is_set: fn(&SettingValues) -> bool,
}

const fn of_paths(name: &'static str, is_set: fn(&SettingValues) -> bool) -> OfIntegrator {
    OfIntegrator { name, integrator: Integrator::Path, is_set }
}

const fn of_whitted(name: &'static str, is_set: fn(&SettingValues) -> bool) -> OfIntegrator {
    OfIntegrator { name, integrator: Integrator::Whitted, is_set }
}

/// The settings that one integrator has alone. `aovs` depends on its value.
pub(crate) const OF_INTEGRATORS: [OfIntegrator; 12] = [
    of_paths("seed", |values| values.seed != 0),
    of_paths("seed_per_frame", |values| values.seed_per_frame),
    of_paths("noise", |values| values.noise.is_some()),
    of_paths("clamp_indirect", |values| values.clamp_indirect.is_some()),
    of_paths("regularize", |values| values.regularize),
    of_paths("sample_range", |values| values.sample_range.is_some()),
    of_paths("time_limit", |values| values.time_limit.is_some()),
    of_paths("denoise", |values| values.denoise != DenoiserKind::None),
    of_paths("checkpoint", |values| values.checkpoint),
    of_whitted("glossy", |values| values.glossy > 0),
    of_whitted("env_samples", |values| values.env_samples != EnvSamples::Auto),
    of_whitted("max_samples", |values| values.max_samples.is_some()),
];

/// The settings that decide about the size of the image.
const SIZE: &[&str] = &["resolution", "width", "height", "scale"];

/// Settings that give way to stronger ones.
struct Conflict {
    weaker: &'static [&'static str],
    stronger: &'static [&'static str],
    /// Whether these values conflict.
    applies: fn(&SettingValues) -> bool,
}

const fn range_beside(stronger: &'static [&'static str], applies: fn(&SettingValues) -> bool) -> Conflict {
    Conflict { weaker: &["sample_range"], stronger, applies }
}

/// What decides about the image and its file, `integrator`, `output` and `background`, gives way to no setting without a place there.
const CONFLICTS: &[Conflict] = &[
    // Files.
    Conflict {
        weaker: &["aovs", "exr", "split_aovs", "stamp", "preview"],
        stronger: &["output"],
        applies: |values| format(values) != OutputFormat::Exr,
    },
    Conflict {
        weaker: &["movie", "manifest", "checkpoint", "resume"],
        stronger: &["output"],
        applies: |values| matches!(format(values), OutputFormat::Movie(_)),
    },
    Conflict {
        weaker: &["aovs"],
        stronger: &["integrator"],
        applies: |values| values.integrator == Integrator::Whitted && values.has_aov(Aov::is_of_paths),
    },
    Conflict { weaker: &["exr"], stronger: &["aovs", "split_aovs"], applies: corrupts_data },
    Conflict { weaker: &["aovs"], stronger: &["exr"], applies: corrupts_data },
    // Frames.
    Conflict { weaker: &["start"], stronger: &["end"], applies: ends_before_its_start },
    Conflict { weaker: &["end"], stronger: &["start"], applies: ends_before_its_start },
    Conflict { weaker: &["start", "end", "step"], stronger: &["all"], applies: |values| values.all },
    // Images.
    Conflict { weaker: &["max_samples"], stronger: &["samples"], applies: has_fewer_on_edges },
    Conflict { weaker: &["samples"], stronger: &["max_samples"], applies: has_fewer_on_edges },
    Conflict { weaker: &["crop"], stronger: SIZE, applies: reaches_beyond_the_image },
    Conflict { weaker: &["aperture"], stronger: &["ortho"], applies: lacks_focal_length },
    Conflict { weaker: &["ortho"], stronger: &["aperture"], applies: lacks_focal_length },
    // Ranges of samples. Each gives way to what it cannot be beside, and to nothing else.
    range_beside(&["samples"], SettingValues::lacks_samples_of_range),
    range_beside(&["samples", "shutter", "time_samples"], SettingValues::has_uneven_times),
    range_beside(&["noise"], |values| values.noise.is_some()),
    range_beside(&["time_limit"], |values| values.time_limit.is_some()),
    range_beside(&["denoise"], |values| values.denoise != DenoiserKind::None),
    range_beside(&["output"], SettingValues::has_no_exr_files),
    range_beside(&["background"], SettingValues::has_plate),
    range_beside(&["split_aovs"], |values| values.split_aovs),
    range_beside(&["aovs"], SettingValues::has_mattes),
    range_beside(&["exr"], SettingValues::is_lossy),
    Conflict {
        weaker: &["noise", "time_limit", "denoise", "split_aovs"],
        stronger: &["sample_range"],
        applies: |_| true,
    },
    Conflict { weaker: &["aovs"], stronger: &["sample_range"], applies: SettingValues::has_mattes },
    Conflict { weaker: &["exr"], stronger: &["sample_range"], applies: SettingValues::is_lossy },
];

/// Whether the setting `name` has no effect beside `stronger` settings, or contradicts them. `values` are those of both.
pub(super) fn conflicts(name: &str, stronger: &Settings, values: &SettingValues) -> bool {
    let is_given = |name: &&str| stronger.origin_of(name).is_some();
    let is_of_another =
        |setting: &OfIntegrator| setting.name == name && setting.integrator != values.integrator;
    let applies = |conflict: &Conflict| {
        conflict.weaker.contains(&name)
            && conflict.stronger.iter().any(is_given)
            && (conflict.applies)(values)
    };
    (is_given(&"integrator") && OF_INTEGRATORS.iter().any(is_of_another)) || CONFLICTS.iter().any(applies)
}

/// Whether it depends on the camera if a crop that is weaker than `stronger` settings reaches beyond the image.
pub(super) fn camera_decides_about_crop(stronger: &Settings, values: &SettingValues) -> bool {
    let is_given = |name: &&str| stronger.origin_of(name).is_some();
    SIZE.iter().any(is_given) && matches!(values.known_image_size(), Ok(None))
}

fn format(values: &SettingValues) -> OutputFormat {
    values.output.as_ref().map_or(OutputFormat::Exr, OutputPattern::format)
}

/// Whether data would be compressed as light is.
fn corrupts_data(values: &SettingValues) -> bool {
    values.is_lossy() && !values.split_aovs && values.has_aov(|aov| !aov.is_light())
}

fn ends_before_its_start(values: &SettingValues) -> bool {
    values.start.zip(values.end).is_some_and(|(start, end)| end < start)
}

fn has_fewer_on_edges(values: &SettingValues) -> bool {
    values.max_samples.is_some_and(|most| most < values.samples)
}

fn reaches_beyond_the_image(values: &SettingValues) -> bool {
    match (values.crop, values.known_image_size()) {
        (Some(crop), Ok(Some((width, height)))) => crop.x1 > width || crop.y1 > height,
        _ => false,
    }
}

/// Whether an f-number is asked for beside a parallel projection.
fn lacks_focal_length(values: &SettingValues) -> bool {
    values.ortho && matches!(values.aperture, Some(Aperture::FNumber(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Definition;

    #[test]
    fn conflicts_are_between_settings() {
        let of_integrators = OF_INTEGRATORS.iter().map(|setting| setting.name);
        let others = CONFLICTS.iter().flat_map(|conflict| [conflict.weaker, conflict.stronger]).flatten();
        for name in of_integrators.chain(others.copied()) {
            assert!(Definition::of(name).is_some(), "{name}");
        }
    }
}
