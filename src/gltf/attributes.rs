//! Named attributes of a primitive: lookup, equal element counts, and reading.

use super::accessor::Data;
use super::context::Context;
use super::extension_names::QUANTIZATION;
use super::formats::{self, AllowedFormats};
use super::raw::Raw;
use crate::error::Result;

/// Reference from an attribute to an accessor.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    /// Attribute name.
    pub(super) name: String,
    /// Accessor index.
    pub(super) accessor: usize,
    /// JSON pointer of the reference.
    pub(super) pointer: String,
}

/// Attributes of a primitive or of one of its morph targets.
#[derive(Clone, Debug, Default)]
pub(super) struct Attributes {
    /// In the order of their names.
    references: Vec<Reference>,
}

/// Prefixes of attribute names that carry a set number. Colours beyond the first set have no meaning.
const NUMBERED: [&str; 4] = ["TEXCOORD_", "JOINTS_", "WEIGHTS_", "COLOR_"];

impl Attributes {
    /// Reads a JSON object that maps attribute names to accessor indices.
    pub(super) fn new(context: &Context, data: &Data, raw: &Raw) -> Result<Self> {
        let mut references = Vec::new();
        for (name, accessor, pointer) in raw.indices(context)? {
            data.accessor(context, accessor, &pointer)?;
            references.push(Reference { name: name.to_owned(), accessor, pointer });
        }
        references.sort_unstable_by(|a, b| a.name.cmp(&b.name));
        Ok(Self { references })
    }

    /// Finds the attribute `name`.
    pub(super) fn find(&self, name: &str) -> Option<&Reference> {
        let found = self.references.binary_search_by(|reference| reference.name.as_str().cmp(name)).ok()?;
        self.references.get(found)
    }

    /// Returns the attributes `prefix0`, `prefix1`, … in order. Errors on a gap in their numbers.
    pub(super) fn sets(&self, context: &Context, prefix: &str) -> Result<Vec<Reference>> {
        let sets: Vec<Reference> = (0..self.references.len())
            .map_while(|set| self.find(&format!("{prefix}{set}")).cloned())
            .collect();
        match self.sets_from(prefix, sets.len()).next() {
            Some((_, stray)) => Err(context.invalid(&stray.pointer, missing_set(prefix, sets.len()))),
            None => Ok(sets),
        }
    }

    /// The attributes that consist of `prefix` and a number of at least `first`, with their numbers.
    pub(super) fn sets_from<'a>(
        &'a self,
        prefix: &'a str,
        first: usize,
    ) -> impl Iterator<Item = (usize, &'a Reference)> {
        let sets = self
            .references
            .iter()
            .filter_map(|reference| Some((set_number(&reference.name, prefix)?, reference)));
        sets.filter(move |(set, _)| *set >= first)
    }

    /// Iterates over all attributes.
    pub(super) fn iter(&self) -> impl Iterator<Item = &Reference> {
        self.references.iter()
    }

    /// The first attribute by name.
    pub(super) fn first(&self) -> Option<&Reference> {
        self.references.first()
    }

    /// Errors unless every attribute has `count` elements, the count of POSITION.
    pub(super) fn check_counts(&self, context: &Context, data: &Data, count: u64) -> Result<()> {
        self.check_counts_against(context, data, count, "POSITION")
    }

    /// Errors unless every attribute has `count` elements, the count of the attribute `base`.
    pub(super) fn check_counts_against(
        &self,
        context: &Context,
        data: &Data,
        count: u64,
        base: &str,
    ) -> Result<()> {
        for reference in &self.references {
            let actual = data.accessor(context, reference.accessor, &reference.pointer)?.count.0;
            if actual != count {
                let message = format!("has {actual} elements, but {base} has {count}");
                return Err(context.invalid(&reference.pointer, message));
            }
        }
        Ok(())
    }

    /// Warns about unsupported attributes. Names that begin with `_` are application-specific and raise no warning.
    pub(super) fn warn_unused(&self, context: &mut Context) {
        for Reference { name, pointer, .. } in &self.references {
            let plain = matches!(name.as_str(), "POSITION" | "NORMAL" | "TANGENT");
            let numbered = NUMBERED.iter().any(|prefix| set_number(name, prefix).is_some());
            let is_after_a_gap = set_number(name, "COLOR_").is_some() && self.find("COLOR_0").is_none();
            if is_after_a_gap {
                let why = missing_set("COLOR_", 0);
                context.warn(pointer, format!("{why}; the attribute {name} is ignored"));
            } else if !(plain || numbered || name.starts_with('_')) {
                context.warn(pointer, format!("the attribute {name} is not supported; it is ignored"));
            }
        }
    }
}

/// Says that the attribute of number `set` is missing though others follow.
pub(super) fn missing_set(prefix: &str, set: usize) -> String {
    format!("{prefix}{set} is missing; sets are numbered from 0 without gaps")
}

/// The number that follows `prefix` in `name`.
fn set_number(name: &str, prefix: &str) -> Option<usize> {
    let digits = name.strip_prefix(prefix)?;
    let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| plain)
}

impl Data<'_> {
    /// Reads the accessor of `reference` as floats, after checking its format against `allowed`.
    pub(super) fn floats_as<const N: usize>(
        &self,
        context: &mut Context,
        reference: &Reference,
        allowed: &AllowedFormats,
    ) -> Result<Vec<[f32; N]>> {
        self.check_format(context, reference, allowed)?;
        self.floats(context, reference.accessor, &reference.pointer)
    }

    /// As [`Self::floats_as`], but elements with infinities or NaNs are zero, with a warning.
    pub(super) fn floats_or_zeros_as<const N: usize>(
        &self,
        context: &mut Context,
        reference: &Reference,
        allowed: &AllowedFormats,
    ) -> Result<Vec<[f32; N]>> {
        self.check_format(context, reference, allowed)?;
        self.floats_or_zeros(context, reference.accessor, &reference.pointer)
    }

    /// Reads the accessor of `reference` as unsigned integers, after checking its format against `allowed`.
    pub(super) fn integers_as<const N: usize>(
        &self,
        context: &mut Context,
        reference: &Reference,
        allowed: &AllowedFormats,
    ) -> Result<Vec<[u32; N]>> {
        self.check_format(context, reference, allowed)?;
        self.integers(context, reference.accessor, &reference.pointer)
    }

    /// Reads the accessor of `reference` as RGBA colours. RGB colours get the alpha `alpha`.
    pub(super) fn colors_as(
        &self,
        context: &mut Context,
        reference: &Reference,
        allowed: &AllowedFormats,
        alpha: f32,
    ) -> Result<Vec<[f32; 4]>> {
        let accessor = self.accessor(context, reference.accessor, &reference.pointer)?;
        let has_alpha = formats::Format::of(accessor)
            .is_some_and(|format| format.shape == gltf::json::accessor::Type::Vec4);
        if has_alpha {
            return self.floats_as(context, reference, allowed);
        }
        let opaque: Vec<[f32; 3]> = self.floats_as(context, reference, allowed)?;
        let mut colors = context.allocate(opaque.len() as u64, &reference.pointer)?;
        colors.extend(opaque.into_iter().map(|[r, g, b]| [r, g, b, alpha]));
        Ok(colors)
    }

    fn check_format(&self, context: &Context, reference: &Reference, allowed: &AllowedFormats) -> Result<()> {
        let accessor = self.accessor(context, reference.accessor, &reference.pointer)?;
        let quantization = self.document.uses(QUANTIZATION);
        formats::check(context, accessor, allowed, quantization, &reference.pointer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_found_by_their_whole_names() {
        let reference = |(name, accessor): (&str, usize)| Reference {
            name: name.to_owned(),
            accessor,
            pointer: String::new(),
        };
        // As JSON objects are sorted, 10 comes before 2.
        let names = ["NORMAL", "POSITION", "TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_10", "TEXCOORD_2"];
        let attributes = Attributes { references: names.into_iter().zip(0..).map(reference).collect() };
        for (index, name) in names.iter().enumerate() {
            assert_eq!(attributes.find(name).map(|found| found.accessor), Some(index));
        }
        for missing in ["", "A", "NORMALS", "TEXCOORD_", "TEXCOORD_11", "Z"] {
            assert!(attributes.find(missing).is_none(), "{missing}");
        }
        assert_eq!(attributes.first().map(|first| first.name.as_str()), Some("NORMAL"));
    }
}
