//! Material variants.
//!
//! Source: the text of `KHR_materials_variants`.

use std::collections::BTreeMap;

use super::context::Context;
use super::document::Document;
use super::extension_names::VARIANTS;
use super::raw::Raw;
use crate::error::Result;
use crate::scene::{MaterialIndex, Primitive, Variant, VariantIndex};

/// Imports the names of all variants.
pub(super) fn import(context: &Context, document: &Document) -> Result<Vec<Variant>> {
    let Some(extension) = Raw::at(&document.value, format!("/extensions/{VARIANTS}")) else {
        return Ok(Vec::new());
    };
    extension.expect_object(context)?;
    let Some(variants) = extension.field("variants") else {
        return Err(context.invalid(format!("{}/variants", extension.pointer), "is missing"));
    };
    let mut imported = Vec::new();
    for variant in variants.elements(context)? {
        variant.expect_object(context)?;
        let Some(name) = variant.string(context, "name")? else {
            return Err(context.invalid(format!("{}/name", variant.pointer), "is missing"));
        };
        imported.push(Variant { name: name.to_owned() });
    }
    Ok(imported)
}

/// The materials of the primitive `raw` in the variants that replace its material.
pub(super) fn of_primitive(
    context: &Context,
    document: &Document,
    raw: &Raw,
) -> Result<Vec<(VariantIndex, MaterialIndex)>> {
    let mut changed: BTreeMap<VariantIndex, MaterialIndex> = BTreeMap::new();
    let Some(extension) = raw.extension(VARIANTS) else {
        return Ok(Vec::new());
    };
    extension.expect_object(context)?;
    let Some(mappings) = extension.field("mappings") else {
        return Err(context.invalid(format!("{}/mappings", extension.pointer), "is missing"));
    };
    let variant_count = variant_count(document);
    for mapping in mappings.elements(context)? {
        mapping.expect_object(context)?;
        let material = index(context, &mapping, "material", document.root.materials.len())?;
        let Some(variants) = mapping.field("variants") else {
            return Err(context.invalid(format!("{}/variants", mapping.pointer), "is missing"));
        };
        for variant in variants.elements(context)? {
            let pointer = &variant.pointer;
            let Some(number) = variant.value.as_u64().and_then(|number| usize::try_from(number).ok()) else {
                return Err(context.invalid(pointer, "must be a non-negative integer"));
            };
            let number = context.check_index(number, variant_count, pointer, "variant")?;
            let variant = VariantIndex::of(number);
            let material = MaterialIndex::of(material);
            if changed.insert(variant, material).is_some() {
                let message = format!("the variant {number} already has a material");
                return Err(context.invalid(pointer, message));
            }
        }
    }
    Ok(changed.into_iter().collect())
}

/// The variants in which a primitive has `material`; `None` stands for its own.
pub(super) fn with_material(
    document: &Document,
    primitive: &Primitive,
    material: MaterialIndex,
) -> Vec<Option<VariantIndex>> {
    let of_variants: BTreeMap<_, _> = primitive.variants.iter().copied().collect();
    let variants = (0..variant_count(document)).map(|number| Some(VariantIndex::of(number)));
    let replaced = |variant: Option<VariantIndex>| variant.and_then(|variant| of_variants.get(&variant));
    let all = std::iter::once(None).chain(variants);
    all.filter(|variant| *replaced(*variant).unwrap_or(&primitive.material) == material).collect()
}

fn variant_count(document: &Document) -> usize {
    let variants = document.value.pointer(&format!("/extensions/{VARIANTS}/variants"));
    variants.and_then(|list| list.as_array()).map_or(0, Vec::len)
}

fn index(context: &Context, owner: &Raw, key: &str, length: usize) -> Result<usize> {
    let pointer = format!("{}/{key}", owner.pointer);
    match owner.index(context, key)? {
        Some(index) => context.check_index(index, length, &pointer, key),
        None => Err(context.invalid(pointer, "is missing")),
    }
}
