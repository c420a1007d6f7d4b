//! Cameras and grounds of several sequences of a scene, of which each measurement is made once.

use std::cell::RefCell;
use std::rc::Rc;

use super::own_camera::OwnCamera;
use super::subject::Subject;
use crate::scene::{
    AnimationIndex, CameraChanges, Ground, NodeIndex, Scene, SelectedCamera, Selection, ViewRequest,
};

/// Subjects that are kept: of the whole scene, and of a node that is looked at.
const KEPT_SUBJECTS: usize = 2;

/// Frames sequences of a scene, and keeps what they may have in common.
#[derive(Debug)]
pub(crate) struct SharedFraming<'a> {
    scene: &'a Scene,
    /// Whether anything is kept.
    keeps: bool,
    subjects: RefCell<Vec<(SubjectKey, Rc<Subject<'a>>)>>,
    cameras: RefCell<Vec<(Framed, OwnCamera)>>,
    grounds: RefCell<Vec<(Framed, Option<Ground>)>>,
}

/// What decides a subject.
#[derive(Clone, Debug, PartialEq)]
struct SubjectKey {
    selection: Selection,
    node: Option<NodeIndex>,
    clips: Vec<AnimationIndex>,
}

/// What decides a camera or a ground.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Framed {
    selection: Selection,
    view: ViewRequest,
    aspect_ratio: f32,
}

impl<'a> SharedFraming<'a> {
    /// Framing of one sequence, whose measured surfaces are given away.
    pub(crate) fn of_one(scene: &'a Scene) -> Self {
        let (subjects, cameras, grounds) = Default::default();
        Self { scene, keeps: false, subjects, cameras, grounds }
    }

    /// Framing of a ground too, or of several sequences.
    pub(crate) fn of_several(scene: &'a Scene) -> Self {
        Self { keeps: true, ..Self::of_one(scene) }
    }

    pub(super) fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// [`Subject::measure`] of the scene.
    pub(super) fn subject(
        &self,
        selection: &Selection,
        node: Option<NodeIndex>,
        clips: &[AnimationIndex],
    ) -> Rc<Subject<'a>> {
        let selection = measured(selection, clips);
        let key = SubjectKey { selection, node, clips: clips.to_vec() };
        let known =
            self.subjects.borrow().iter().find(|(of, _)| *of == key).map(|(_, found)| Rc::clone(found));
        known.unwrap_or_else(|| {
            self.subjects.borrow_mut().truncate(KEPT_SUBJECTS - 1);
            let subject = Rc::new(Subject::measure(self.scene, &key.selection, node, clips));
            if self.keeps {
                self.subjects.borrow_mut().insert(0, (key, Rc::clone(&subject)));
            }
            subject
        })
    }

    /// The key of a camera that depends on no camera of the file, or of a ground.
    pub(super) fn framed(selection: &Selection, view: &ViewRequest, aspect_ratio: f32) -> Framed {
        Framed { selection: measured(selection, &view.measured_clips), view: view.clone(), aspect_ratio }
    }

    /// The camera of a key, made by `make` unless it is known.
    pub(super) fn camera(&self, key: Framed, make: impl FnOnce() -> OwnCamera) -> OwnCamera {
        self.kept(&self.cameras, key, make)
    }

    /// The ground of a key, made by `make` unless it is known.
    pub(super) fn ground(&self, key: Framed, make: impl FnOnce() -> Option<Ground>) -> Option<Ground> {
        self.kept(&self.grounds, key, make)
    }

    fn kept<T: Clone>(&self, list: &RefCell<Vec<(Framed, T)>>, key: Framed, make: impl FnOnce() -> T) -> T {
        let known = list.borrow().iter().find(|(of, _)| *of == key).map(|(_, known)| known.clone());
        known.unwrap_or_else(|| {
            let made = make();
            if self.keeps {
                list.borrow_mut().push((key, made.clone()));
            }
            made
        })
    }
}

/// The selection without what does not decide its surfaces while `clips` are measured each alone, if there are any.
fn measured(selection: &Selection, clips: &[AnimationIndex]) -> Selection {
    Selection {
        clips: if clips.is_empty() { selection.clips.clone() } else { Vec::new() },
        camera: SelectedCamera::Auto,
        camera_changes: CameraChanges::default(),
        ..selection.clone()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::gltf::{ImportOptions, import};
    use crate::scene::{CameraRequest, SelectionRequest};

    #[test]
    fn what_is_measured_for_all_clips_is_measured_once() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/animation/hierarchy.gltf");
        let scene = import(&path, &ImportOptions::default()).unwrap();
        let request = SelectionRequest { camera: Some(CameraRequest::Auto), ..SelectionRequest::default() };
        let (selection, _) = Selection::resolve(&request, &scene).unwrap();
        let still = Selection { clips: Vec::new(), ..selection.clone() };
        assert_ne!(selection, still);
        let measured_clips = selection.clips.clone();
        let shared = SharedFraming::of_several(&scene);
        let subject = |framing: &SharedFraming<'_>, selection: &Selection, clips: &[AnimationIndex]| {
            Rc::as_ptr(&framing.subject(selection, None, clips)).addr()
        };
        assert_eq!(subject(&shared, &selection, &measured_clips), subject(&shared, &still, &measured_clips));
        // Clips that play together are others.
        assert_ne!(subject(&shared, &selection, &[]), subject(&shared, &still, &[]));

        // Cameras and grounds are those of one sequence each.
        for view in [ViewRequest { measured_clips, ..ViewRequest::default() }, ViewRequest::default()] {
            for selection in [&selection, &still, &selection] {
                let alone = SharedFraming::of_one(&scene);
                assert_eq!(
                    shared.resolve(selection.clone(), &view, 1.5).0,
                    alone.resolve(selection.clone(), &view, 1.5).0
                );
                for is_mirror in [false, true] {
                    let ground = shared.ground_below(selection, &view, is_mirror);
                    assert_eq!(ground, alone.ground_below(selection, &view, is_mirror));
                    assert!(ground.unwrap().is_mirror == is_mirror);
                }
            }
        }
    }
}
