//! Words that other programs use, and the settings that do what they mean.
//!
//! A word whose value is written as that of a setting is one of its hidden aliases instead.

/// Words, without dashes, and what to write for them. Settings stand in backquotes.
const SYNONYMS: &[(&[&str], &str)] = &[
    (
        &["angle", "angles", "rotate", "rotation", "azimuth", "yaw", "pitch", "camera_rotation"],
        "`orbit` AZ,EL sees the scene from another side, by degrees",
    ),
    (
        &["zoom", "distance", "dist", "camera_distance"],
        "`orbit` AZ,EL,DIST moves the camera by a multiple of the distance, `fov` DEG narrows its view",
    ),
    (&["lens"], "`focal_length` MM or `fov` DEG"),
    (&["quality", "subsamples", "antialias", "antialiasing"], "`samples` N takes more of a pixel"),
    (&["dof", "depth_of_field", "bokeh"], "`aperture` METRES or f/N, and `focus`"),
    (&["motion_blur", "blur"], "`shutter` 180deg blurs what moves"),
    (&["brightness", "ev"], "`exposure` EV in stops"),
    (
        &["gamma", "tonemap", "tonemapping", "tone_mapping", "view_transform"],
        "`tone` NAME selects the tone curve",
    ),
    (&["transparent", "transparency", "alpha", "no_background"], "`background` none is transparent"),
    (&["light", "lights", "lighting", "ibl"], "`env` FILE.hdr, R,G,B or studio lights the scene"),
    (
        &["floor", "shadow", "shadows"],
        "`ground` catches shadows below the scene, `shadow_catcher` NODE those on a node",
    ),
    (
        &["count", "num_frames", "frame_count", "nframes", "duration", "length", "seconds"],
        "`frames` 0-47 selects frames, `turntable` N makes a turn of N frames",
    ),
    (
        &["gif", "mp4", "webp", "video", "film", "format", "type"],
        "the name of `output` decides the format, such as turn.mp4, turn.gif or shot.####.png",
    ),
    (&["force", "yes", "clobber"], "`overwrite` replaces existing files"),
    (&["jobs", "cores", "cpus", "workers"], "`threads` N"),
    (&["clip", "action"], "`animation` NAME plays one clip"),
    (&["bounces", "max_depth", "max_bounces"], "`depth` N"),
    (&["path", "camera_animation", "flythrough"], "`camera_path` FILE moves the camera along keys"),
    (
        &["loop", "loops", "repeat"],
        "a `movie` such as turn.gif plays in a loop; a file of `camera_path` has loop = true",
    ),
    (
        &["interpolation", "key", "keys", "keyframes"],
        "a file of camera keys is a value of `camera_path`, not a shot",
    ),
    (&["input", "model", "file"], "the scene stands without an option: rayframe render robot.glb"),
];

/// What to write for the option or key `word` of another program.
pub fn synonym(word: &str) -> Option<&'static str> {
    let word = word.trim_start_matches('-').to_ascii_lowercase().replace('-', "_");
    SYNONYMS.iter().find(|(words, _)| words.contains(&word.as_str())).map(|(_, hint)| *hint)
}

/// Words of other programs for choices, and the choices.
const CHOICES: &[(&[&str], &[&str])] = &[
    (&["side", "profile"], &["left", "right"]),
    (&["iso", "isometric", "3/4", "quarter", "persp", "perspective"], &["three-quarter"]),
    (&["above", "up", "birdseye"], &["top"]),
    (&["below", "down"], &["bottom"]),
    (&["rear", "behind"], &["back"]),
    (&["mirror", "reflective", "glossy"], &["reflection"]),
    (&["contain"], &["fit"]),
    (&["cover"], &["fill"]),
    (&["filmic"], &["agx"]),
];

/// What of `choices` to write for a `word` of another program: `left or right`.
pub(super) fn choice_synonym(word: &str, choices: &[&str]) -> Option<String> {
    let word = word.to_ascii_lowercase();
    let offered = |names: &&[&str]| names.iter().all(|name| choices.contains(name));
    let matching =
        CHOICES.iter().filter(|(words, _)| words.contains(&word.as_str())).map(|(_, names)| *names);
    matching.into_iter().find(offered).map(|names| names.join(" or "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{DEFINITIONS, Definition};

    #[test]
    fn synonyms_are_no_settings_and_name_settings() {
        let mut seen = std::collections::BTreeSet::new();
        for (words, hint) in SYNONYMS {
            for word in *words {
                assert!(seen.insert(word), "{word} stands twice");
                assert!(Definition::of(word).is_none(), "{word} is a setting");
                assert!(DEFINITIONS.iter().all(|definition| !definition.aliases.contains(word)), "{word}");
            }
            for name in hint.split('`').skip(1).step_by(2) {
                assert!(DEFINITIONS.iter().any(|definition| definition.name == name), "{name} is no setting");
            }
        }
    }

    #[test]
    fn words_are_found_however_they_are_typed() {
        for word in ["--zoom", "zoom", "--Motion-Blur", "motion_blur"] {
            assert!(synonym(word).is_some(), "{word}");
        }
        assert_eq!(synonym("--sampels"), None);
    }

    #[test]
    fn choices_have_synonyms_where_they_exist() {
        let view = Definition::of("view").unwrap();
        let views: Vec<_> = view.choices().into_iter().map(|(name, _)| name).collect();
        assert_eq!(choice_synonym("Side", &views).as_deref(), Some("left or right"));
        assert_eq!(choice_synonym("3/4", &views).as_deref(), Some("three-quarter"));
        assert_eq!(choice_synonym("filmic", &views), None);
        let is_choice = |name: &str| {
            DEFINITIONS
                .iter()
                .any(|definition| definition.choices().iter().any(|(choice, _)| *choice == name))
        };
        assert!(CHOICES.iter().flat_map(|(_, names)| *names).all(|name| is_choice(name)));
    }

    #[test]
    fn words_of_the_same_form_are_aliases() {
        for (word, name) in [
            ("spin", "turntable"),
            ("position", "camera_position"),
            ("target", "look_at"),
            ("size", "resolution"),
            ("out", "output"),
            ("hdri", "env"),
            ("bg", "background"),
            ("framerate", "fps"),
        ] {
            assert_eq!(Definition::of(word).map(|definition| definition.name), Some(name), "{word}");
        }
    }
}
