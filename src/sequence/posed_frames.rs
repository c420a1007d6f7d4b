//! The scene at one time with a hierarchy that fits it, made from what the last frame left.

use std::time::Instant;

use crate::bvh::{Builder, Bvh};
use crate::cancel::CancelFlag;
use crate::error::Result;
use crate::frame::Frame;
use crate::geometry::Triangle;

use super::{Phases, SequenceJob};

/// The frame at hand, the one before, and the hierarchy over the one before.
#[derive(Default)]
pub(super) struct PosedFrames {
    pub(super) current: Frame,
    previous: Frame,
    builder: Builder,
    pub(super) bvh: Option<Bvh>,
}

impl PosedFrames {
    /// Poses the scene and makes `bvh` fit it; tells whether the last hierarchy still did.
    pub(super) fn advance(
        &mut self,
        job: &SequenceJob,
        time_seconds: f64,
        cancel: &CancelFlag,
        seconds: &mut Phases,
    ) -> Result<bool> {
        let posing = Instant::now();
        std::mem::swap(&mut self.current, &mut self.previous);
        self.current.pose(&job.scene, &job.selection, time_seconds);
        seconds.pose = posing.elapsed().as_secs_f64();

        if self.bvh.is_some() && has_same_triangles(&self.current, &self.previous) {
            return Ok(true);
        }
        let recycled = self.bvh.take();
        let Frame { triangles, flags, .. } = &self.current;
        let bvh = self.builder.build(triangles, flags, &job.build, cancel, recycled)?;
        let phases = bvh.statistics();
        seconds.split = phases.bounds_seconds + phases.split_seconds;
        seconds.sort = phases.sort_seconds;
        seconds.link = phases.tree_seconds;
        seconds.widen = phases.widen_seconds;
        self.bvh = Some(bvh);
        Ok(false)
    }
}

/// Whether both frames have the same triangles to the last bit.
fn has_same_triangles(a: &Frame, b: &Frame) -> bool {
    let bits = |triangle: &Triangle| triangle.vertices.map(|v| v.to_array().map(f32::to_bits));
    a.flags == b.flags
        && a.triangles.len() == b.triangles.len()
        && a.triangles.iter().zip(&b.triangles).all(|(a, b)| bits(a) == bits(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn a_zero_of_the_other_sign_is_another_triangle() {
        let frame = |x: f32| {
            let mut frame = Frame::default();
            frame.triangles.push(Triangle { vertices: [Vec3::new(x, 0.0, 0.0), Vec3::X, Vec3::Y] });
            frame
        };
        assert!(has_same_triangles(&frame(0.0), &frame(0.0)));
        assert!(!has_same_triangles(&frame(0.0), &frame(-0.0)));
        assert!(!has_same_triangles(&frame(0.0), &Frame::default()));
    }
}
