//! A pose that was made before the first frame, which takes it.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::frame::{Frame, VertexParts};
use crate::scene::{Scene, Selection};

/// The scene as the choice of an automatic camera or a measurement has posed it, at any time. The first frame takes it, as it is or for its
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
        self.take_parts(scene, selection, time_seconds, VertexParts::All)
    }

    /// The same for vertices that need only have these parts.
    pub(super) fn take_parts(
        &self,
        scene: &Arc<Scene>,
        selection: &Selection,
        time_seconds: f64,
        parts: VertexParts,
    ) -> Option<Frame> {
        let taken = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Posed { mut frame, scene: posed_scene, selection: posed_selection } = taken?;
        frame.pose_parts(parts);
        let is_same =
            Weak::ptr_eq(&posed_scene, &Arc::downgrade(scene)) && posed_selection.has_surfaces_of(selection);
        if !is_same {
            frame.pose(scene, selection, time_seconds);
        } else if frame.time_seconds.to_bits() == time_seconds.to_bits() && frame.has_parts() {
            frame.pose_camera(scene, selection);
        } else {
            frame.pose_again(scene, selection, time_seconds);
        }
        Some(frame)
    }

    /// Leaves a frame that was posed with `scene` and `selection`, at any time.
    pub(super) fn put(&self, frame: Frame, scene: &Arc<Scene>, selection: &Selection) {
        let posed = Posed { frame, scene: Arc::downgrade(scene), selection: selection.clone() };
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(posed);
    }

    /// Drops the pose before other work needs its memory.
    pub(super) fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framing::SharedFraming;
    use crate::scene::{CameraRequest, SelectionRequest, VariantIndex, ViewRequest};

    fn loaded(path: &str) -> Arc<Scene> {
        Arc::new(crate::gltf::import(path.as_ref(), &crate::gltf::ImportOptions::default()).unwrap())
    }

    fn assert_equal(frame: &Frame, expected: &Frame) {
        assert_eq!((frame.time_seconds, frame.camera), (expected.time_seconds, expected.camera));
        assert_eq!(frame.triangles, expected.triangles);
        assert_eq!(frame.vertices, expected.vertices);
        assert!(frame.flags == expected.flags);
        assert_eq!(frame.instance_of_triangle, expected.instance_of_triangle);
        assert_eq!(frame.instances, expected.instances);
        assert_eq!(frame.materials, expected.materials);
        assert_eq!(frame.lights, expected.lights);
        assert!(frame.image_light == expected.image_light);
    }

    /// The pose of `posed`, taken for `taken`, is what posing anew gives.
    fn check(posed: (&Arc<Scene>, &Selection), taken: (&Arc<Scene>, &Selection, f64)) {
        for parts in [VertexParts::All, VertexParts::Positions] {
            let mut frame = Frame::default();
            frame.pose_parts(parts);
            frame.pose_surfaces(posed.0, posed.1, 0.0);
            let pose = FirstPose::new(frame, posed.0, posed.1.clone());
            let frame = pose.clone().take(taken.0, taken.1, taken.2).unwrap();
            assert_equal(&frame, &Frame::at(taken.0, taken.1, taken.2));
            assert!(pose.take(taken.0, taken.1, taken.2).is_none());
        }
    }

    #[test]
    fn it_is_taken_once_and_equals_a_new_pose() {
        let scene = loaded("scenes/demo/whitted_1980.gltf");
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let request = SelectionRequest { camera: Some(CameraRequest::Auto), ..SelectionRequest::default() };
        let (automatic, _) = Selection::resolve(&request, &scene).unwrap();
        assert_ne!(automatic.camera, selection.camera);
        let other_scene = loaded("scenes/demo/whitted_1980.gltf");
        let still = Selection { clips: Vec::new(), ..selection.clone() };
        for (posed, taken) in [
            (&automatic, (&scene, &selection, 0.0)),
            (&automatic, (&scene, &selection, 0.25)),
            (&automatic, (&scene, &still, 0.0)),
            (&automatic, (&other_scene, &selection, 0.0)),
            // Only the camera depends on the time.
            (&still, (&scene, &still, 0.25)),
        ] {
            check((&scene, posed), taken);
        }
    }

    #[test]
    fn a_measurement_takes_positions_and_leaves_them() {
        let scene = loaded("scenes/demo/whitted_1980.gltf");
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let still = Selection { clips: Vec::new(), ..selection.clone() };
        for (selection, times_seconds) in
            [(&selection, [0.0, 0.25]), (&selection, [0.25; 2]), (&still, [0.0, 0.25])]
        {
            let positions =
                |frame: &Frame| frame.vertices.iter().map(|vertex| vertex.position).collect::<Vec<_>>();
            let pose = FirstPose::default();
            for before in [Frame::of_positions(), Frame::default()] {
                let mut before = before;
                before.pose(&scene, selection, 0.0);
                pose.put(before, &scene, selection);
                let [measured_seconds, time_seconds] = times_seconds;
                let measured =
                    pose.take_parts(&scene, selection, measured_seconds, VertexParts::Positions).unwrap();
                let expected = Frame::at(&scene, selection, measured_seconds);
                assert_eq!((&measured.triangles, measured.camera), (&expected.triangles, expected.camera));
                assert_eq!(positions(&measured), positions(&expected));
                pose.put(measured, &scene, selection);
                let frame = pose.take(&scene, selection, time_seconds).unwrap();
                assert_equal(&frame, &Frame::at(&scene, selection, time_seconds));
            }
        }
    }

    #[test]
    fn other_variants_and_roots_are_posed_anew() {
        let scene = loaded("scenes/material/variants.gltf");
        let (selection, _) = Selection::resolve(&SelectionRequest::default(), &scene).unwrap();
        let variant = Selection { variant: Some(VariantIndex(1)), ..selection.clone() };
        let materials = |selection: &Selection| {
            let frame = Frame::at(&scene, selection, 0.0);
            frame.instances.iter().map(|instance| instance.material).collect::<Vec<_>>()
        };
        assert_ne!(materials(&selection), materials(&variant));
        let no_roots = Selection { roots: Vec::new(), ..selection.clone() };
        for other in [&variant, &no_roots] {
            check((&scene, &selection), (&scene, other, 0.0));
        }
    }

    #[test]
    fn clips_that_are_measured_each_alone_leave_no_pose() {
        let scene = loaded("scenes/animation/hierarchy.gltf");
        let request = SelectionRequest { camera: Some(CameraRequest::Auto), ..SelectionRequest::default() };
        let (selection, _) = Selection::resolve(&request, &scene).unwrap();
        let has_pose = |view: &ViewRequest| {
            let (_, posed) = SharedFraming::of_one(&scene).resolve(selection.clone(), view, 1.5);
            posed.is_some()
        };
        assert!(has_pose(&ViewRequest::default()));
        let measured_clips = selection.clips.clone();
        assert!(!measured_clips.is_empty());
        assert!(!has_pose(&ViewRequest { measured_clips, ..ViewRequest::default() }));
    }
}
