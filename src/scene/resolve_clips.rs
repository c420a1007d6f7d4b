//! Resolves the clips of a selection request.

use std::collections::BTreeSet;

use super::resolve_selection::{find, index_u32, label};
use super::{AnimationIndex, AnimationTarget, NameOrIndex, NamedKind, NodeIndex, Scene};
use crate::error::{Error, Result, Warning};

const CLIP: NamedKind = NamedKind { noun: "animation", setting: "animation", pointer: "/animations" };

/// The clip of a name or index.
///
/// # Errors
/// [`Error::Setting`] for a clip that does not exist.
pub(super) fn find_clip(
    selected: &NameOrIndex,
    scene: &Scene,
    warnings: &mut Vec<Warning>,
) -> Result<AnimationIndex> {
    let names = scene.animations.iter().map(|clip| clip.name.as_deref());
    find(&CLIP, selected, names, warnings).map(|clip| AnimationIndex(index_u32(clip)))
}

/// The clips of names and indices separated by commas, or the one that has the whole text as its name.
///
/// # Errors
/// [`Error::Setting`] for a clip that does not exist, and for clips that animate the same target.
pub(super) fn clips_together(
    selected: &str,
    scene: &Scene,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<AnimationIndex>> {
    if scene.animations.iter().any(|clip| clip.name.as_deref() == Some(selected)) {
        return Ok(vec![find_clip(&NameOrIndex::Name(selected.to_owned()), scene, warnings)?]);
    }
    let mut clips = Vec::new();
    let mut held: BTreeSet<AnimationTarget> = BTreeSet::new();
    for name in selected.split(',') {
        let clip = find_clip(&NameOrIndex::parse(name.trim()), scene, warnings)?;
        let targets = || scene.animations[clip.index()].channels.iter().map(|channel| channel.target);
        if targets().any(|target| target.clashes(&held)) {
            let name = scene.animations[clip.index()].name.as_deref();
            let why = format!(
                "{} animates a target of another selected clip; leave one of them out",
                label(clip.index(), name)
            );
            return Err(Error::setting(CLIP.setting, why));
        }
        held.extend(targets());
        clips.push(clip);
    }
    Ok(clips)
}

/// All clips except those that share a target with an earlier selected clip, and those of nodes of other scenes alone.
pub(super) fn disjoint_clips(
    scene: &Scene,
    roots: &[NodeIndex],
    warnings: &mut Vec<Warning>,
) -> Vec<AnimationIndex> {
    let posing = posing_nodes(scene, roots);
    let mut clips = Vec::new();
    let mut held: BTreeSet<AnimationTarget> = BTreeSet::new();
    for (i, clip) in scene.animations.iter().enumerate() {
        let mut nodes = clip.channels.iter().map(|channel| channel.target.node());
        if nodes.all(|node| node.is_some_and(|node| !posing.contains(&node))) {
            continue;
        }
        if clip.channels.iter().any(|channel| channel.target.clashes(&held)) {
            warnings.push(Warning {
                pointer: format!("/animations/{i}"),
                message: format!(
                    "the clip {} animates a target of an earlier clip and is left out; select it with `animation` '#{i}'",
                    label(i, clip.name.as_deref())
                ),
            });
            continue;
        }
        held.extend(clip.channels.iter().map(|channel| channel.target));
        clips.push(AnimationIndex(index_u32(i)));
    }
    clips
}

/// The nodes below `roots`, the joints that deform them, and the ancestors of both.
fn posing_nodes(scene: &Scene, roots: &[NodeIndex]) -> BTreeSet<NodeIndex> {
    let mut pending = scene.nodes_below(roots);
    let mut nodes = BTreeSet::new();
    while let Some(index) = pending.pop() {
        if nodes.insert(index) {
            let node = &scene.nodes[index.index()];
            pending.extend(node.parent);
            let skin = node.skin.map(|skin| &scene.skins[skin.index()]);
            pending.extend(skin.iter().flat_map(|skin| &skin.joints));
        }
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::resolve_selection::tests::{clip, scene};
    use crate::scene::{ClipSelection, Selection, SelectionRequest, Skin, SkinIndex};

    #[test]
    fn clips_of_other_scenes_do_not_play() {
        let mut scene = scene();
        let elsewhere = AnimationTarget::Translation(NodeIndex(2));
        scene.animations[0] = clip("elsewhere", &[elsewhere]);
        let played = |scene: &Scene| Selection::resolve(&SelectionRequest::default(), scene).unwrap().0.clips;
        assert_eq!(played(&scene), [AnimationIndex(1)]);
        // A joint of what is rendered may be anywhere.
        scene.skins = vec![Skin { joints: vec![NodeIndex(2)], ..Skin::default() }];
        scene.nodes[1].skin = Some(SkinIndex(0));
        assert_eq!(played(&scene), [AnimationIndex(0), AnimationIndex(1)]);
    }

    #[test]
    fn clips_play_together() {
        let together = |text: &str, scene: &Scene| {
            let clips = ClipSelection::Together(text.to_owned());
            Selection::resolve(&SelectionRequest { clips, ..SelectionRequest::default() }, scene)
        };
        let clips = |text, scene: &Scene| together(text, scene).unwrap().0.clips;
        let mut scene = scene();
        assert_eq!(clips("c, #0", &scene), [AnimationIndex(2), AnimationIndex(0)]);
        for (refused, why) in
            [("b,c", "\"c\" animates a target"), ("a,d", "no animation \"d\""), ("a,", "no animation")]
        {
            let message = together(refused, &scene).unwrap_err().to_string();
            assert!(message.contains(why), "{message}");
        }
        // A name may have commas.
        scene.animations[1].name = Some("a,c".to_owned());
        assert_eq!(clips("a,c", &scene), [AnimationIndex(1)]);
    }
}
