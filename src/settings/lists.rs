//! `--layers` and `--exr`: lists of words to what they stand for.

use crate::image_file::ExrCompression;
use crate::output::{Aov, AovSet, LightSamples};

use super::nearest::nearest;

/// Whether a word stands for a layer.
type Holds = fn(Aov) -> bool;

/// Words that stand for several layers.
const GROUPS: [(&str, Holds); 4] = [
    ("light", |layer| matches!(layer, Aov::Light(_))),
    ("data", |layer| !layer.is_light() && !is_crypto(layer)),
    ("crypto", is_crypto),
    ("all", |_| true),
];

/// `depth,normal,light`.
pub fn aovs(text: &str) -> Result<AovSet, String> {
    let mut layers = Vec::new();
    for word in words(text) {
        let group = GROUPS.iter().find(|(name, _)| *name == word);
        let before = layers.len();
        layers.extend(Aov::ALL.into_iter().filter(|&layer| match group {
            Some((_, holds)) => holds(layer),
            None => layer.name() == word,
        }));
        if layers.len() == before {
            let groups = GROUPS.iter().map(|(name, _)| *name);
            let names: Vec<_> = Aov::ALL.into_iter().map(Aov::name).chain(groups).collect();
            return Err(unknown(word, "a layer", &names));
        }
    }
    Ok(AovSet::new(&layers))
}

/// The names of the layers that the words stand for, of those that are in files, whoever wrote them.
pub fn aovs_in_files(text: &str, present: &[&str]) -> Result<Vec<String>, String> {
    let mut names: Vec<String> = Vec::new();
    for word in words(text) {
        let group = GROUPS.iter().find(|(name, _)| *name == word);
        let is_meant = |name: &str| match group {
            Some(("all", _)) => true,
            Some((_, holds)) => Aov::ALL.into_iter().any(|layer| layer.name() == name && holds(layer)),
            None => name == word,
        };
        let before = names.len();
        names.extend(present.iter().filter(|name| is_meant(name)).map(|name| (*name).to_owned()));
        if names.len() == before {
            let all: std::collections::BTreeSet<_> = present.iter().copied().collect();
            let all: Vec<_> = all.into_iter().collect();
            return Err(unknown(word, "a layer of these pictures", &all));
        }
    }
    Ok(names)
}

/// `half,zip`, either word alone, in any order.
pub fn encoding(text: &str) -> Result<(LightSamples, ExrCompression), String> {
    const SAMPLES: [LightSamples; 2] = [LightSamples::Half, LightSamples::Float];
    let (mut samples, mut compression) = (None, None);
    for word in words(text) {
        let is_second = if let Some(found) = SAMPLES.into_iter().find(|samples| samples.name() == word) {
            samples.replace(found).is_some()
        } else if let Some(found) = ExrCompression::ALL.into_iter().find(|kind| kind.name() == word) {
            compression.replace(found).is_some()
        } else {
            let kinds = ExrCompression::ALL.into_iter().map(ExrCompression::name);
            let names: Vec<_> = SAMPLES.into_iter().map(LightSamples::name).chain(kinds).collect();
            return Err(unknown(word, "a type or a compression", &names));
        };
        if is_second {
            return Err(
                "write one type (half or float) and one compression at most, such as float,piz".to_owned()
            );
        }
    }
    Ok((samples.unwrap_or_default(), compression.unwrap_or_default()))
}

fn is_crypto(layer: Aov) -> bool {
    matches!(layer, Aov::CryptoObject | Aov::CryptoMaterial)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim)
}

/// Says what was meant, if one of `names` is near, and lists them.
pub(super) fn unknown(word: &str, what: &str, names: &[&str]) -> String {
    let meant = nearest(word, names).map_or(String::new(), |name| format!("; did you mean \"{name}\"?"));
    let there_are = if meant.is_empty() { "; there are" } else { " There are" };
    format!("\"{}\" is not {what}{meant}{there_are} {}", word.escape_debug(), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LightPass;

    #[test]
    fn layers_and_groups_are_listed() {
        let names = |text| {
            let set = aovs(text).unwrap();
            set.as_slice().iter().map(|layer| layer.name()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(names("beauty"), "beauty");
        assert_eq!(names("normal, depth,depth"), "beauty depth normal");
        assert_eq!(names("crypto"), "beauty crypto_object crypto_material");
        assert_eq!(names("light").split(' ').count(), 1 + LightPass::ALL.len());
        assert_eq!(aovs("data,light,crypto"), aovs("all"));
        assert_eq!(aovs("all").unwrap().as_slice(), Aov::ALL);
    }

    #[test]
    fn unknown_words_are_told_with_what_is_near() {
        let error = aovs("depht").unwrap_err();
        assert!(error.contains("did you mean \"depth\"") && error.contains("crypto_material"), "{error}");
        assert!(aovs("Object-Id").unwrap_err().contains("did you mean \"object_id\""));
        let error = aovs("depth,,uv").unwrap_err();
        assert!(error.contains("\"\" is not a layer; there are"), "{error}");
        assert!(encoding("flaot").unwrap_err().contains("did you mean \"float\""));
    }

    #[test]
    fn types_and_compressions_come_in_any_order() {
        use {ExrCompression as C, LightSamples as S};
        assert_eq!(encoding("float,piz"), Ok((S::Float, C::Piz)));
        assert_eq!(encoding("dwab, half"), Ok((S::Half, C::Dwab)));
        assert_eq!(encoding("float"), Ok((S::Float, C::Zip)));
        assert_eq!(encoding("none"), Ok((S::Half, C::None)));
        for text in ["", "half,float", "zip,zips", "pxr24", "half,half"] {
            assert!(encoding(text).is_err(), "{text}");
        }
    }
}
