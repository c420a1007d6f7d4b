//! The scene of a job at times at which it is measured.

use std::sync::Arc;

use crate::bvh::{BuildSettings, Builder, BuilderKind, Bvh, Split};
use crate::cancel::{CancelFlag, Cancelled};
use crate::frame::{Frame, VertexParts};
use crate::render::SceneView;
use crate::scene::{Environment, Scene, Selection};

use super::{FirstPose, SequenceJob};

/// Rays of a measured time, about: few, which pay for no better tree.
const EXPECTED_RAYS: u64 = 1 << 16;

/// A scene that is posed at one time after the other. Its BVH serves all times between which no triangle moves.
pub(super) struct MeasuredScene<'j> {
    scene: &'j Arc<Scene>,
    selection: &'j Selection,
    build: BuildSettings,
    frame: Frame,
    builder: Builder,
    bvh: Option<Bvh>,
}

impl<'j> MeasuredScene<'j> {
    /// The scene of `job` with `selection` at time 0. Takes the pose that the job was left with, if any.
    pub(super) fn new(job: &'j SequenceJob, selection: &'j Selection) -> Self {
        Self::of_parts(job, selection, VertexParts::All)
    }

    /// The same for what needs no shading: its vertices have only positions.
    pub(super) fn of_positions(job: &'j SequenceJob, selection: &'j Selection) -> Self {
        Self::of_parts(job, selection, VertexParts::Positions)
    }

    fn of_parts(job: &'j SequenceJob, selection: &'j Selection, parts: VertexParts) -> Self {
        let scene = &job.scene;
        let frame = job.first_pose.take_parts(scene, selection, 0.0, parts).unwrap_or_else(|| {
            let mut frame = Frame::default();
            frame.pose_parts(parts);
            frame.pose(scene, selection, 0.0);
            frame
        });
        Self {
            scene,
            selection,
            // Splits would need memory for which nobody asked, and change no answer.
            build: BuildSettings {
                builder: BuilderKind::Auto,
                split: Split::Off,
                expected_rays: EXPECTED_RAYS,
                ..job.build
            },
            frame,
            builder: Builder::default(),
            bvh: None,
        }
    }

    /// Poses the scene at `time_seconds`.
    pub(super) fn pose(&mut self, time_seconds: f64) {
        if self.frame.pose_again(self.scene, self.selection, time_seconds) {
            self.bvh = None;
        }
    }

    /// The posed scene.
    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The posed scene, whose flags alone may change: to the same at every time, and before its first view.
    pub(super) fn frame_mut(&mut self) -> &mut Frame {
        &mut self.frame
    }

    /// The posed scene and its BVH in an environment.
    ///
    /// # Errors
    /// [`Cancelled`] when `cancel` is raised.
    pub(super) fn view<'v>(
        &'v mut self,
        environment: &'v Environment,
        cancel: &CancelFlag,
    ) -> Result<SceneView<'v>, Cancelled> {
        let bvh = if let Some(bvh) = self.bvh.take() {
            bvh
        } else {
            let Frame { triangles, flags, .. } = &self.frame;
            self.builder.build(triangles, flags, &self.build, cancel, None)?
        };
        Ok(SceneView { scene: self.scene, frame: &self.frame, bvh: self.bvh.insert(bvh), environment })
    }

    /// Leaves the posed scene for the first frame.
    pub(super) fn leave_in(self, first_pose: &FirstPose) {
        first_pose.put(self.frame, self.scene, self.selection);
    }
}
