//! Ids of the actual image in terms of the reference: a mesh or a material that both have is one id in both images.

use crate::image::{Image, Samples};

use super::matching::Matching;

/// The first id of things that the reference does not have.
pub(super) const FIRST_NEW_ID: u32 = 1 << 31;

/// Replaces the ids of the layer `layer`, which are indices plus one.
pub(super) fn replace_ids(image: &mut Image, layer: &str, matching: &Matching) {
    let pairs: std::collections::BTreeMap<_, _> =
        matching.pairs.iter().map(|&(actual, reference)| (actual as u32, reference as u32)).collect();
    let replaced = |id: u32| match id.checked_sub(1) {
        None => 0,
        Some(index) => pairs.get(&index).map_or(FIRST_NEW_ID + index, |index| index + 1),
    };
    for channel in image.channels.iter_mut().filter(|channel| channel.name == layer) {
        if let Samples::Uint(ids) = &mut channel.samples {
            for id in ids {
                *id = replaced(*id);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Channel, ColorEncoding};

    #[test]
    fn matched_ids_become_those_of_the_reference() {
        let mut image = Image::from_rgba((4, 1), ColorEncoding::Linear, &[[0.0; 4]; 4]);
        let samples = Samples::Uint(vec![0, 1, 2, 3]);
        image.channels.push(Channel { name: "object_id".to_owned(), samples });
        let matching = Matching { pairs: vec![(0, 1), (1, 0)], added: vec![2], removed: Vec::new() };
        replace_ids(&mut image, "object_id", &matching);
        let ids = &image.channel("object_id").unwrap().samples;
        assert_eq!(*ids, Samples::Uint(vec![0, 2, 1, FIRST_NEW_ID + 2]));
    }
}
