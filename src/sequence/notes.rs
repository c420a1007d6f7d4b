//! What people should hear about frames that came out, but perhaps not as they were meant.

use crate::bvh::BuildStatistics;
use crate::error::{Error, Result, Warning};
use crate::integrator::TRANSPARENCY_LIMIT;
use crate::render::RenderStatistics;

use super::{PlannedFrame, SequenceJob, Summary};

/// What was said already; nothing is said twice.
#[derive(Debug, Default)]
pub(super) struct Notes {
    said: Vec<Warning>,
    /// Whether it was said that the camera sees nothing.
    has_seen_nothing: bool,
}

impl Notes {
    /// What a frame's statistics say that was not said before.
    ///
    /// # Errors
    /// [`Error::Internal`] for pixels that are no numbers where `job.strict`.
    pub(super) fn of_frame(
        &mut self,
        job: &SequenceJob,
        planned: &PlannedFrame,
        tree: &BuildStatistics,
        rays: &RenderStatistics,
    ) -> Result<Vec<Warning>> {
        let frame = planned.frame;
        let mut notes = Vec::new();
        match rays.non_finite_pixels {
            0 => {}
            count if job.strict => {
                let message = format!("frame {frame}: {count} pixels are infinite or not a number");
                return Err(Error::Internal { message });
            }
            count => notes.push(format!(
                "frame {frame}: {count} pixels were infinite or not a number and are black; this is a bug worth reporting"
            )),
        }
        let window = job.render.window;
        let is_whole = (window.width(), window.height()) == job.render.resolution;
        if rays.integrator.camera_hits == 0 && tree.triangles > 0 && is_whole && !self.has_seen_nothing {
            self.has_seen_nothing = true;
            notes.push(format!(
                "{} sees nothing in frame {frame}: the scene lies behind it, beside it, or shows it its back",
                job.selection.camera_label(&job.scene)
            ));
        }
        if rays.integrator.transparency_limit_reached > 0 {
            notes.push(format!(
                "some samples met more than {TRANSPARENCY_LIMIT} see-through surfaces; what lies behind them is missing"
            ));
        }
        if tree.budget_reached {
            notes.push(format!(
                "--split: the area would make more than {} references a triangle and was raised",
                job.build.reference_budget
            ));
        }
        let mut notes: Vec<_> = notes.into_iter().map(noted).collect();
        notes.retain(|note| !self.said.contains(note));
        self.said.extend_from_slice(&notes);
        Ok(notes)
    }
}

/// What is said when the depth limit took more than a hundredth of the light.
pub(super) fn depth_note(summary: &Summary, max_depth: u32) -> Option<Warning> {
    let (dropped, samples) = summary.written.iter().fold((0.0, 0), |(dropped, samples), frame| {
        (dropped + frame.rays.dropped_weight, samples + frame.rays.camera)
    });
    let share = dropped / samples as f64;
    (share > 0.01).then(|| {
        let percent = share * 100.0;
        noted(format!("{percent:.0} % of the light was cut off at depth {max_depth}: raise --depth"))
    })
}

fn noted(message: String) -> Warning {
    Warning { pointer: String::new(), message }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence::{FrameReport, Phases, RayReport, TreeReport};

    fn frame(camera: u64, dropped_weight: f64) -> FrameReport {
        FrameReport {
            frame: 0,
            time_seconds: 0.0,
            path: "a.exr".into(),
            sha256: String::new(),
            bytes: 0,
            layers: Vec::new(),
            seconds: Phases::default(),
            tree: TreeReport::default(),
            rays: RayReport { camera, dropped_weight, ..RayReport::default() },
            peak_memory_bytes: None,
        }
    }

    #[test]
    fn light_that_the_depth_limit_takes_is_named_beyond_a_hundredth() {
        let told = |written: Vec<FrameReport>| {
            depth_note(&Summary { written, ..Summary::default() }, 8).map(|note| note.message)
        };
        // 8 of 200 samples over both frames.
        let note = told(vec![frame(100, 0.5), frame(100, 7.5)]).unwrap();
        assert_eq!(note, "4 % of the light was cut off at depth 8: raise --depth");
        assert_eq!(told(vec![frame(100, 1.0)]), None);
        assert_eq!(told(Vec::new()), None);
    }
}
