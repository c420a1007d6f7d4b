//! Names of the sequences of a shot.

use serde::Serialize;

use crate::settings::Placeholder;

/// The names that tell a sequence from the others of its scene: of its clip, camera and variant, as far as the settings ask for
/// each. Reports have them under the keys of the [`Placeholder`]s.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SequenceNames {
    /// Name of its clip, where the settings ask for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<String>,
    /// Name of its camera, where the settings ask for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<String>,
    /// Name of its material variant, where the settings ask for each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub variant: Option<String>,
}

impl SequenceNames {
    /// The names that it has, each with what it names.
    pub fn entries(&self) -> impl Iterator<Item = (Placeholder, &str)> {
        let Self { clip, camera, variant } = self;
        let names =
            [(Placeholder::Clip, clip), (Placeholder::Camera, camera), (Placeholder::Variant, variant)];
        names.into_iter().filter_map(|(what, name)| Some((what, name.as_deref()?)))
    }

    /// `clip "walk"`, `camera "left"`, `variant "red"`, as far as it has them.
    pub fn labels(&self) -> impl Iterator<Item = String> {
        self.entries().map(|(what, name)| format!("{} \"{name}\"", what.key()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_asked_for_are_told() {
        let names = SequenceNames {
            clip: Some("walk".to_owned()),
            variant: Some("red".to_owned()),
            ..SequenceNames::default()
        };
        assert_eq!(names.labels().collect::<Vec<_>>(), ["clip \"walk\"", "variant \"red\""]);
        let json = serde_json::to_string(&names).unwrap();
        assert_eq!(json, r#"{"clip":"walk","variant":"red"}"#);
        // Reports that list the keys one by one have the same.
        let keys = names.entries().map(|(what, _)| format!("\"{}\":", what.key()));
        assert!(keys.into_iter().all(|key| json.contains(&key)), "{json}");
    }
}
