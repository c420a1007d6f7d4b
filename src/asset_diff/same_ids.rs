//! Ids of the actual image in terms of the reference: a mesh or a material that both have is one id in both images, and so is a
//! renamed one, which stands on the same pixels.

use std::collections::{BTreeMap, BTreeSet};

use crate::image::{Image, Samples};
use crate::regression::renumbering;

use super::matching::Matching;

/// The first id of things that the reference does not have.
pub(super) const FIRST_NEW_ID: u32 = 1 << 31;

/// Ids of the reference that stand for renamed items, and the new ids of these.
pub(super) type RenamedIds = BTreeMap<u32, u32>;

/// Replaces the ids of the layer `layer` of `actual`, which are indices plus one. An item that the reference lacks has a new id, but where
/// it covers the pixels of one that the actual file lacks: then it has the id of that, and is returned.
pub(super) fn replace_ids(
    actual: &mut Image,
    reference: &Image,
    layer: &str,
    matching: &Matching,
) -> RenamedIds {
    let pairs: BTreeMap<_, _> =
        matching.pairs.iter().map(|&(actual, reference)| (actual as u32, reference as u32)).collect();
    let replaced = |id: u32| match id.checked_sub(1) {
        None => 0,
        Some(index) => pairs.get(&index).map_or(FIRST_NEW_ID + index, |index| index + 1),
    };
    let channel = actual.channels.iter_mut().find(|channel| channel.name == layer);
    let Some(Samples::Uint(ids)) = channel.map(|channel| &mut channel.samples) else {
        return RenamedIds::new();
    };
    for id in &mut *ids {
        *id = replaced(*id);
    }
    let Some(Samples::Uint(theirs)) = reference.channel(layer).map(|channel| &channel.samples) else {
        return RenamedIds::new();
    };
    let renamed = renamed_ids(ids, theirs, matching);
    let of_reference: BTreeMap<_, _> = renamed.iter().map(|(&theirs, &ours)| (ours, theirs)).collect();
    for id in ids {
        *id = of_reference.get(id).copied().unwrap_or(*id);
    }
    renamed
}

fn renamed_ids(ids: &[u32], reference: &[u32], matching: &Matching) -> RenamedIds {
    let removed: BTreeSet<_> = matching.removed.iter().map(|&index| index as u32 + 1).collect();
    let pairs = reference.iter().copied().zip(ids.iter().copied());
    let unmatched = pairs.filter(|(theirs, ours)| removed.contains(theirs) && *ours >= FIRST_NEW_ID);
    let mut renamed: RenamedIds = renumbering(unmatched).into_iter().collect();
    // No id stays so.
    renamed.remove(&0);
    renamed
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
        let reference = image.clone();
        let renamed = replace_ids(&mut image, &reference, "object_id", &matching);
        assert!(renamed.is_empty());
        let ids = &image.channel("object_id").unwrap().samples;
        assert_eq!(*ids, Samples::Uint(vec![0, 2, 1, FIRST_NEW_ID + 2]));
    }

    #[test]
    fn a_renamed_item_has_the_id_of_the_one_on_whose_pixels_it_stands() {
        let image = |ids: &[u32]| {
            let mut image = Image::from_rgba((6, 1), ColorEncoding::Linear, &[[0.0; 4]; 6]);
            let samples = Samples::Uint(ids.to_vec());
            image.channels.push(Channel { name: "material_id".to_owned(), samples });
            image
        };
        let replaced = |actual: &[u32], reference: &[u32], matching: &Matching| {
            let mut actual = image(actual);
            let renamed = replace_ids(&mut actual, &image(reference), "material_id", matching);
            (actual.channel("material_id").unwrap().samples.clone(), Vec::from_iter(renamed))
        };
        // The second and third material have other names, and the file lists them in the other order.
        let matching = Matching { pairs: vec![(0, 0)], added: vec![1, 2], removed: vec![1, 2] };
        let same = replaced(&[0, 1, 3, 3, 2, 2], &[0, 1, 2, 2, 3, 3], &matching);
        let renamed = vec![(2, FIRST_NEW_ID + 2), (3, FIRST_NEW_ID + 1)];
        assert_eq!(same, (Samples::Uint(vec![0, 1, 2, 2, 3, 3]), renamed.clone()));
        // Where edges moved, most pixels tell.
        let moved = replaced(&[0, 3, 3, 3, 2, 2], &[0, 2, 2, 3, 3, 3], &matching);
        assert_eq!(moved, (Samples::Uint(vec![0, 2, 2, 2, 3, 3]), renamed));
        // One that both have, or the background, is no renamed one.
        let other = Matching { pairs: vec![(0, 0)], added: vec![1], removed: vec![1] };
        let new = replaced(&[2, 2, 1, 1, 1, 1], &[0, 0, 1, 1, 2, 2], &other);
        let id = FIRST_NEW_ID + 1;
        assert_eq!(new, (Samples::Uint(vec![id, id, 1, 1, 1, 1]), Vec::new()));
    }
}
