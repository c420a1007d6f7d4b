//! The sequence that progress output is about, and its position in a run of several.

use std::path::PathBuf;

use serde_json::{Value, json};

use rayframe::cancel::CancelFlag;
use rayframe::error::Error;
use rayframe::sequence::PlannedFrame;
use rayframe::shot::SequenceNames;

use super::option_names::option_names;
use super::percent_path::add_percent_path;

/// What follows from the interruption of a run.
pub(super) const RESUMABLE: &str = "stopped before the end, the same command with --resume goes on from here";

/// A sequence, for progress output.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReportedSequence {
    /// Names of the frames, with `####` for the frame number.
    pub(crate) output: String,
    /// The scene file.
    pub(crate) scene: PathBuf,
    /// The names that tell it from the others of the scene.
    pub(crate) names: SequenceNames,
    /// What runs it.
    pub(crate) run: RunKind,
}

/// What a sequence is rendered by.
#[derive(Clone, Debug, Default)]
pub(crate) enum RunKind {
    /// A run of this sequence alone.
    #[default]
    Alone,
    /// A run of several sequences.
    Part(Part),
    /// `rayframe watch`, which the flag ends. Other interruptions are changes of its inputs.
    Watch(CancelFlag),
}

/// Position of a sequence in a run of several, in frames.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Part {
    /// Frames of the sequences before it.
    pub(crate) before: usize,
    /// Frames of all sequences.
    pub(crate) total: usize,
}

impl ReportedSequence {
    /// Its position, where it is one of several.
    pub(super) fn part(&self) -> Option<Part> {
        match self.run {
            RunKind::Part(part) => Some(part),
            RunKind::Alone | RunKind::Watch(_) => None,
        }
    }

    /// What follows from an interruption.
    pub(super) fn interruption_text(&self) -> &'static str {
        match &self.run {
            RunKind::Alone | RunKind::Part(_) => RESUMABLE,
            RunKind::Watch(end) if end.is_raised() => "stopped before the end",
            RunKind::Watch(_) => "an input has changed, rendering begins again",
        }
    }

    /// `frame 7`, after the scene and the names where the sequence is one of several.
    pub(super) fn frame_text(&self, frame: i64) -> String {
        if self.part().is_none() {
            return format!("frame {frame}");
        }
        let mut words = vec![format!("{}:", self.scene.display())];
        words.extend(self.names.labels());
        words.push(format!("frame {frame}"));
        words.join(" ")
    }

    /// Why a frame failed, in a line that names it, with the options of the command line.
    pub(super) fn failure_text(&self, planned: &PlannedFrame, error: &Error) -> String {
        format!("{}: {}", self.frame_text(planned.frame), option_names(&error.to_string()))
    }

    /// Frames that are done before the sequence begins, and all frames, where it has `to_render` and `kept` ones.
    pub(super) fn done_and_total(&self, to_render: usize, kept: usize) -> (usize, usize) {
        self.part().map_or((0, to_render), |part| (part.before + kept, part.total))
    }

    /// Adds the scene and the names to a JSON line.
    pub(super) fn add_to(&self, line: &mut Value) {
        line["scene"] = json!(self.scene.to_string_lossy());
        for (what, name) in self.names.entries() {
            line[what.key()] = json!(name);
        }
        add_percent_path(line, "scene_percent", &self.scene);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_one_of_several_sequences_have_its_names() {
        let names = SequenceNames {
            clip: Some("walk".to_owned()),
            variant: Some("red".to_owned()),
            ..SequenceNames::default()
        };
        let alone = ReportedSequence { scene: "a.glb".into(), names, ..ReportedSequence::default() };
        assert_eq!(alone.frame_text(7), "frame 7");
        let run = RunKind::Part(Part { before: 0, total: 2 });
        let one = ReportedSequence { run, ..alone };
        assert_eq!(one.frame_text(7), "a.glb: clip \"walk\" variant \"red\" frame 7");
        let scene = ReportedSequence { names: SequenceNames::default(), ..one };
        assert_eq!(scene.frame_text(7), "a.glb: frame 7");
    }
}
