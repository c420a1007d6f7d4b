//! Values of `aovs` and `exr`: lists of words.

use crate::image_file::ExrCompression;
use crate::output::{Aov, AovSet, LightSamples};

use super::nearest::nearest;
use super::synonyms::choice_synonym;

/// Whether an AOV belongs to a group.
type Holds = fn(Aov) -> bool;

/// Groups of AOVs.
const GROUPS: [(&str, Holds); 6] = [
    ("light", |aov| matches!(aov, Aov::Light(_))),
    ("data", |aov| !aov.is_light() && !is_crypto(aov) && !aov.is_of_paths()),
    ("crypto", is_crypto),
    ("noise", Aov::is_noise),
    ("denoising", Aov::is_guide),
    // Those of every integrator.
    ("all", |aov| !aov.is_of_paths()),
];

/// `depth,normal,light`.
pub(crate) fn aovs(text: &str) -> Result<AovSet, String> {
    let mut aovs = Vec::new();
    for word in words(text) {
        let group = GROUPS.iter().find(|(name, _)| *name == word);
        let before = aovs.len();
        aovs.extend(Aov::ALL.into_iter().filter(|&aov| match group {
            Some((_, holds)) => holds(aov),
            None => aov.name() == word,
        }));
        if aovs.len() == before {
            let groups = GROUPS.iter().map(|(name, _)| *name);
            let names: Vec<_> = Aov::ALL.into_iter().map(Aov::name).chain(groups).collect();
            return Err(unknown(word, "an AOV", &names));
        }
    }
    Ok(AovSet::new(&aovs))
}

/// Names of the AOVs in files that a list of names and groups selects.
pub fn aovs_in_files(text: &str, present: &[&str]) -> Result<Vec<String>, String> {
    let mut names: Vec<String> = Vec::new();
    for word in words(text) {
        let group = GROUPS.iter().find(|(name, _)| *name == word);
        let is_selected = |name: &str| match group {
            Some(("all", _)) => true,
            Some((_, holds)) => Aov::ALL.into_iter().any(|aov| aov.name() == name && holds(aov)),
            None => name == word,
        };
        let before = names.len();
        names.extend(present.iter().filter(|name| is_selected(name)).map(|name| (*name).to_owned()));
        if names.len() == before {
            let all: std::collections::BTreeSet<_> = present.iter().copied().collect();
            let all: Vec<_> = all.into_iter().collect();
            return Err(unknown(word, "an AOV of these images", &all));
        }
    }
    Ok(names)
}

/// `half,zip`, either word alone, in any order.
pub(crate) fn encoding(text: &str) -> Result<(LightSamples, ExrCompression), String> {
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

fn is_crypto(aov: Aov) -> bool {
    matches!(aov, Aov::CryptoObject | Aov::CryptoMaterial)
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(',').map(str::trim)
}

/// Suggests the nearest of `names`, and lists them.
pub(super) fn unknown(word: &str, what: &str, names: &[&str]) -> String {
    let nearest = || Some(format!("\"{}\"", nearest(word, names)?));
    let intended = choice_synonym(word, names).or_else(nearest);
    let suggestion = intended.map_or(String::new(), |name| format!("; did you mean {name}?"));
    let there_are = if suggestion.is_empty() { "; there are" } else { " There are" };
    format!("\"{}\" is not {what}{suggestion}{there_are} {}", word.escape_debug(), names.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LightPass;

    #[test]
    fn aovs_and_groups_are_listed() {
        let names = |text| {
            let set = aovs(text).unwrap();
            set.as_slice().iter().map(|aov| aov.name()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(names("beauty"), "beauty");
        assert_eq!(names("normal, depth,depth"), "beauty depth normal");
        assert_eq!(names("crypto"), "beauty crypto_object crypto_material");
        assert_eq!(names("light").split(' ').count(), 1 + LightPass::ALL.len());
        assert_eq!(aovs("data,light,crypto"), aovs("all"));
        let all = aovs("all,noise,denoising").unwrap();
        assert_eq!(all.as_slice(), Aov::ALL);
        assert!(aovs("all").unwrap().as_slice().iter().all(|aov| !aov.is_of_paths()));
    }

    #[test]
    fn unknown_words_come_with_a_suggestion() {
        let error = aovs("depht").unwrap_err();
        assert!(error.contains("did you mean \"depth\"") && error.contains("crypto_material"), "{error}");
        assert!(aovs("Object-Id").unwrap_err().contains("did you mean \"object_id\""));
        let error = aovs("depth,,uv").unwrap_err();
        assert!(error.contains("\"\" is not an AOV; there are"), "{error}");
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
