//! Cryptomatte: coverage of each pixel by surfaces, identified by hashes of their names; the names are in the header.
//!
//! Source: the Cryptomatte specification 1.2 (Psyop, 2018). A layer has twelve channels for six ranks,
//! each an id and a coverage, the largest first. Coverage beyond the sixth rank is left out. The preview channels that the
//! specification deprecates are not written.

mod hash;
mod names;

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::Warning;
use crate::film::CoverageSample;
use crate::frame::MeshInstance;
use crate::image::{Channel, Samples};
use crate::scene::Scene;

use hash::{layer_key, name_id};

/// Number of surfaces stored for a pixel.
const RANKS: usize = 6;

/// Ids and manifest of one Cryptomatte layer, the same in all frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Matte {
    layer: &'static str,
    /// Ids by instance.
    ids: Vec<u32>,
    manifest: String,
}

/// Warnings about names of `scene` with equal hashes.
pub fn matte_collisions(scene: &Scene) -> Vec<Warning> {
    let nodes = names::collisions(&names::node_names(scene), "nodes");
    [nodes, names::collisions(&names::material_names(scene), "materials")].concat()
}

impl Matte {
    /// Matte by node names.
    pub(super) fn of_objects(layer: &'static str, scene: &Scene, instances: &[MeshInstance]) -> Self {
        Self::new(layer, &names::node_names(scene), instances.iter().map(|instance| instance.node.index()))
    }

    /// Matte by material names.
    pub(super) fn of_materials(layer: &'static str, scene: &Scene, instances: &[MeshInstance]) -> Self {
        Self::new(
            layer,
            &names::material_names(scene),
            instances.iter().map(|instance| instance.material.index()),
        )
    }

    /// Matte by `names`; `indices` give the name of each instance.
    fn new(layer: &'static str, names: &[String], indices: impl Iterator<Item = usize>) -> Self {
        let mut manifest = BTreeMap::new();
        let name_of = |index: usize| names.get(index).map_or("", String::as_str);
        let ids = indices.map(|index| {
            let name = name_of(index);
            let id = name_id(name);
            manifest.insert(name.to_owned(), format!("{id:08x}"));
            id
        });
        let ids = ids.collect();
        let manifest = serde_json::json!(manifest).to_string();
        Self { layer, ids, manifest }
    }

    /// Attributes that the specification requires.
    pub(super) fn attributes(&self) -> Vec<(String, String)> {
        let key = layer_key(self.layer);
        [
            ("name", self.layer),
            ("hash", "MurmurHash3_32"),
            ("conversion", "uint32_to_float32"),
            ("manifest", &self.manifest),
        ]
        .map(|(what, value)| (format!("cryptomatte/{key}/{what}"), value.to_owned()))
        .into()
    }

    /// Channels of an image with this coverage.
    pub(super) fn channels(&self, coverage: &[CoverageSample]) -> Vec<Channel> {
        let ranked: Vec<_> = coverage.par_iter().map(|shares| ranks(shares, &self.ids)).collect();
        let channel = |index: usize| Channel {
            name: format!("{}{:02}.{}", self.layer, index / 4, ["R", "G", "B", "A"][index % 4]),
            samples: Samples::Float(ranked.par_iter().map(|pixel| pixel[index]).collect()),
        };
        (0..2 * RANKS).map(channel).collect()
    }
}

/// Ids and coverages in alternation, by decreasing coverage, then by id; zeros after the last.
fn ranks(shares: &[(u32, f32)], ids: &[u32]) -> [f32; 2 * RANKS] {
    // Sum shares of equal names. Filters with negative lobes may leave negative shares.
    let mut mattes: Vec<(u32, f32)> = Vec::with_capacity(shares.len());
    for &(instance, share) in shares {
        let Some(&id) = ids.get(instance as usize) else { continue };
        match mattes.iter_mut().find(|(other, _)| *other == id) {
            Some((_, sum)) => *sum += share,
            None => mattes.push((id, share)),
        }
    }
    mattes.retain(|&(_, share)| share > 0.0);
    mattes.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));

    let mut ranked = [0.0; 2 * RANKS];
    for (rank, &(id, share)) in ranked.chunks_exact_mut(2).zip(&mattes) {
        rank[0] = f32::from_bits(id);
        rank[1] = if share < 1.0 { share } else { 1.0 };
    }
    ranked
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matte(names: &[&str]) -> Matte {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        Matte::new("crypto_object", &names, 0..names.len())
    }

    #[test]
    fn ranks_are_sorted_by_share() {
        let ids = [7, 3, 7, 9].map(|bits: u32| bits << 24);
        let float = |bits: u32| f32::from_bits(bits << 24);
        // The first and the third instance have the same name: 0.125 + 0.5; two equal shares go by id.
        let ranked = ranks(&[(0, 0.125), (1, 0.1875), (2, 0.5), (3, 0.1875)], &ids);
        assert_eq!(ranked[..6], [float(7), 0.625, float(3), 0.1875, float(9), 0.1875]);
        assert_eq!(ranked[6..], [0.0; 6]);
    }

    #[test]
    fn shares_beyond_the_sixth_and_negative_ones_are_left_out() {
        let ids: Vec<u32> = (1..=8).map(|bits| bits << 24).collect();
        let shares: Vec<_> = (0..8).map(|instance| (instance, instance as f32 * 0.1 - 0.05)).collect();
        let ranked = ranks(&shares, &ids);
        assert_eq!(ranked[10].to_bits(), 3 << 24);
        assert_eq!(ranks(&[(0, -0.1), (1, 1.1)], &ids)[..4], [f32::from_bits(2 << 24), 1.0, 0.0, 0.0]);
        // An index out of range has no name.
        assert_eq!(ranks(&[(99, 1.0)], &ids), [0.0; 12]);
    }

    #[test]
    fn names_of_channels_and_attributes_follow_the_specification() {
        let matte = matte(&["bunny", "default"]);
        let names: Vec<_> = matte.channels(&[]).into_iter().map(|channel| channel.name).collect();
        assert_eq!(names[..3], ["crypto_object00.R", "crypto_object00.G", "crypto_object00.B"]);
        assert_eq!(names[3..5], ["crypto_object00.A", "crypto_object01.R"]);
        assert_eq!(names[11], "crypto_object02.A");
        // The hash of "crypto_object" is 0xf834d0a6; those of the names are 0x13851a76 and 0x42c9679f.
        let expected = [
            ("cryptomatte/f834d0a/name", "crypto_object"),
            ("cryptomatte/f834d0a/hash", "MurmurHash3_32"),
            ("cryptomatte/f834d0a/conversion", "uint32_to_float32"),
            ("cryptomatte/f834d0a/manifest", r#"{"bunny":"13851a76","default":"42c9679f"}"#),
        ];
        assert_eq!(matte.attributes(), expected.map(|(name, value)| (name.to_owned(), value.to_owned())));
    }
}
