//! A pose that the choice of a camera has made, for the first frame.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::frame::Frame;
use crate::scene::{Scene, Selection};

/// The scene as the choice of an automatic camera has posed it, at the start of the clips. The first frame takes it, as it is or for its
/// memory. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct FirstPose(Arc<Mutex<Option<Posed>>>);

#[derive(Debug)]
struct Posed {
    frame: Frame,
    scene: Weak<Scene>,
    selection: Selection,
}

impl FirstPose {
    /// The surfaces of `scene` as `frame` has posed them with `selection`, whose camera may differ.
    pub(crate) fn new(frame: Frame, scene: &Arc<Scene>, selection: Selection) -> Self {
        let posed = Posed { frame, scene: Arc::downgrade(scene), selection };
        Self(Arc::new(Mutex::new(Some(posed))))
    }

    /// Takes the pose, if nobody has, and poses it with the camera of `selection` at `time_seconds`.
    pub(super) fn take(&self, scene: &Arc<Scene>, selection: &Selection, time_seconds: f64) -> Option<Frame> {
        let taken = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Posed { mut frame, scene: posed_scene, selection: posed_selection } = taken?;
        let is_same = Weak::ptr_eq(&posed_scene, &Arc::downgrade(scene))
            && frame.time_seconds.to_bits() == time_seconds.to_bits()
            && posed_selection.has_surfaces_of(selection);
        if is_same {
            frame.pose_camera(scene, selection);
        } else {
            frame.pose(scene, selection, time_seconds);
        }
        Some(frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{CameraRequest, SelectionRequest};

    fn loaded(path: &str) -> Arc<Scene> {
        Arc::new(crate::gltf::import(path.as_ref(), &crate::gltf::ImportOptions::default()).unwrap())
    }

    #[test]
    fn it_is_taken_once_and_equals_a_new_pose() {
        let scene = loaded("scenes/demo/whitted_1980.gltf");
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let request = SelectionRequest { camera: Some(CameraRequest::Auto), ..SelectionRequest::default() };
        let (automatic, _) = Selection::resolve(&request, &scene).unwrap();
        assert_ne!(automatic.camera, selection.camera);
        let other_scene = loaded("scenes/demo/whitted_1980.gltf");
        let without_clips = Selection { clips: Vec::new(), ..selection.clone() };
        for (scene_taken, taken, time) in [
            (&scene, &selection, 0.0),
            (&scene, &selection, 0.25),
            (&scene, &without_clips, 0.0),
            (&other_scene, &selection, 0.0),
        ] {
            let mut frame = Frame::default();
            frame.pose_surfaces(&scene, &automatic, 0.0);
            let pose = FirstPose::new(frame, &scene, automatic.clone());
            let frame = pose.clone().take(scene_taken, taken, time).unwrap();
            let expected = Frame::at(scene_taken, taken, time);
            assert_eq!((frame.time_seconds, frame.camera), (time, expected.camera));
            assert_eq!((frame.triangles, frame.vertices), (expected.triangles, expected.vertices));
            assert!(pose.take(scene_taken, taken, time).is_none());
        }
    }
}
