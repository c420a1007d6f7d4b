//! Resolves the clips of a selection request.

use std::collections::BTreeSet;

use super::named_kind::{find, label};
use super::{AnimationIndex, AnimationTarget, NameOrIndex, NamedKind, NodeIndex, Scene};
use crate::error::{Error, Result, Warning};

const CLIP: NamedKind = NamedKind { noun: "animation", setting: "animation", pointer: "/animations" };

/// Clips that a warning names.
const MOST_LABELS: usize = 8;

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
    find(&CLIP, selected, names, warnings).map(AnimationIndex::of)
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
        if clips.contains(&clip) {
            let why = format!("{name} is named twice; name it once", name = name.trim());
            return Err(Error::setting(CLIP.setting, why));
        }
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
    let (mut clips, mut left_out) = (Vec::new(), Vec::new());
    let mut held: BTreeSet<AnimationTarget> = BTreeSet::new();
    for (i, clip) in scene.animations.iter().enumerate() {
        let mut nodes = clip.channels.iter().map(|channel| channel.target.node());
        if nodes.all(|node| node.is_some_and(|node| !posing.contains(&node))) {
            continue;
        }
        if clip.channels.iter().any(|channel| channel.target.clashes(&held)) {
            left_out.push(i);
            continue;
        }
        held.extend(clip.channels.iter().map(|channel| channel.target));
        clips.push(AnimationIndex::of(i));
    }
    warnings.extend(left_out_warning(scene, &left_out));
    clips
}

/// The warning about clips that share targets with earlier ones; `None` without such clips.
fn left_out_warning(scene: &Scene, clips: &[usize]) -> Option<Warning> {
    let labels = |clips: &[usize]| {
        let label = |&clip: &usize| label(clip, scene.animations[clip].name.as_deref());
        clips.iter().map(label).collect::<Vec<_>>().join(", ")
    };
    let (pointer, message) = match *clips {
        [] => return None,
        [clip] => (
            format!("/animations/{clip}"),
            format!(
                "the clip {} animates a target of an earlier clip and is left out; select it with `animation` '#{clip}'",
                labels(clips)
            ),
        ),
        [first, ..] => {
            let named = &clips[..clips.len().min(MOST_LABELS)];
            let rest = if named.len() < clips.len() { ", …" } else { "" };
            let message = format!(
                "{} clips animate targets of earlier clips and are left out ({}{rest}); select some with `animation` '#{first}'",
                clips.len(),
                labels(named)
            );
            ("/animations".to_owned(), message)
        }
    };
    Some(Warning { pointer, message })
}

/// The nodes below `roots`, the joints that deform them, and the ancestors of both.
fn posing_nodes(scene: &Scene, roots: &[NodeIndex]) -> BTreeSet<NodeIndex> {
    let mut pending = scene.nodes_below(roots);
    let (mut nodes, mut skins) = (BTreeSet::new(), BTreeSet::new());
    while let Some(index) = pending.pop() {
        if nodes.insert(index) {
            let node = &scene.nodes[index.index()];
            pending.extend(node.parent);
            // Many nodes may have one skin.
            let skin = node.skin.filter(|skin| skins.insert(*skin)).map(|skin| &scene.skins[skin.index()]);
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
    fn clips_that_are_left_out_have_one_warning() {
        let mut scene = scene();
        let mut warning = |count: usize| {
            let clips = (0..=count).map(|i| clip(&format!("c{i}"), &[AnimationTarget::Scale(NodeIndex(0))]));
            scene.animations = clips.collect();
            let (_, warnings) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert!(warning(0).is_empty());
        let one = "/animations/1: the clip #1 \"c1\" animates a target of an earlier clip and is left out; select it with `animation` '#1'";
        assert_eq!(warning(1), [one]);
        let two = "/animations: 2 clips animate targets of earlier clips and are left out (#1 \"c1\", #2 \"c2\"); select some with `animation` '#1'";
        assert_eq!(warning(2), [two]);
        let many = warning(17);
        assert_eq!(many.len(), 1);
        assert!(many[0].starts_with("/animations: 17 clips animate"), "{}", many[0]);
        assert!(many[0].contains("#7 \"c7\", #8 \"c8\", …); select"), "{}", many[0]);
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
