//! Content that the references of a shot list and its scene has no more, or has anew: every image tells it, and a shot tells it once.

use std::collections::BTreeMap;

use crate::regression::Verdict;
use crate::regression::comparison::{Comparison, Mismatch};

/// Beginning of the line that names the image which told the content.
const TOLD_WITH: &str = "content differs as told with ";

/// Whether the messages of an image only name another one that told its content.
pub fn refers_to_another_image(messages: &[String]) -> bool {
    !messages.is_empty() && messages.iter().all(|message| message.starts_with(TOLD_WITH))
}

/// What images of a shot have told of its content.
#[derive(Debug, Default)]
pub(super) struct ToldContent {
    /// The image that told a line first.
    images: BTreeMap<String, String>,
}

impl ToldContent {
    /// The messages of an image that changed or failed. Lines on content that earlier images told are replaced by the name of such an image.
    pub(super) fn messages(&mut self, image: &str, comparison: &Comparison) -> Vec<String> {
        match comparison.verdict() {
            Verdict::Identical => Vec::new(),
            Verdict::Changed => {
                let lines = self.untold(image, comparison.content_lines());
                comparison.largest_measure_with(&lines).into_iter().collect()
            }
            Verdict::Failed => {
                let (lost, others): (Vec<_>, Vec<_>) = comparison
                    .mismatches
                    .iter()
                    .partition(|mismatch| matches!(mismatch, Mismatch::Lost { .. }));
                let lost = lost.into_iter().map(ToString::to_string);
                let content = self.untold(image, lost.chain(comparison.content_lines()).collect());
                let checks = comparison.checks.iter().filter(|check| !check.passes).map(ToString::to_string);
                content.into_iter().chain(others.into_iter().map(ToString::to_string)).chain(checks).collect()
            }
        }
    }

    /// Keeps the lines that an image has told.
    pub(super) fn keep(&mut self, image: &str, lines: &[String]) {
        for line in lines {
            self.images.entry(line.clone()).or_insert_with(|| image.to_owned());
        }
    }

    /// The lines that no earlier image told, or one line instead if all are told.
    fn untold(&mut self, image: &str, lines: Vec<String>) -> Vec<String> {
        let teller = lines.first().and_then(|line| self.images.get(line)).cloned();
        let untold: Vec<_> = lines.into_iter().filter(|line| !self.images.contains_key(line)).collect();
        self.keep(image, &untold);
        match teller {
            Some(teller) if untold.is_empty() => vec![format!("{TOLD_WITH}{teller}")],
            _ => untold,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lost(name: &str) -> Mismatch {
        Mismatch::Lost { content: "node", name: format!("\"{name}\""), count: 1 }
    }

    #[test]
    fn content_is_told_with_the_first_image_that_misses_it() {
        let mut told = ToldContent::default();
        let failed = |names: &[&str]| Comparison {
            mismatches: names.iter().map(|name| lost(name)).collect(),
            ..Comparison::identical()
        };
        assert_eq!(told.messages("a", &Comparison::identical()), [""; 0]);
        assert_eq!(told.messages("a", &failed(&["hat"])), ["lost: node \"hat\""]);
        assert_eq!(told.messages("b", &failed(&["hat"])), ["content differs as told with a"]);
        assert!(refers_to_another_image(&told.messages("b", &failed(&["hat"]))));
        let others = [vec![], vec!["content differs as told with a".to_owned(), "lost: node".to_owned()]];
        assert!(others.iter().all(|messages| !refers_to_another_image(messages)));
        assert_eq!(told.messages("c", &failed(&["hat", "cap"])), ["lost: node \"cap\""]);
        let changed =
            Comparison { new_content: vec!["new: clip \"run\"".to_owned()], ..Comparison::identical() };
        assert_eq!(told.messages("d", &changed), ["new: clip \"run\""]);
        assert_eq!(told.messages("e", &changed), ["content differs as told with d"]);
        let both = Comparison {
            scene_changes: vec!["motion of clip \"run\" changed".to_owned()],
            ..failed(&["cap", "scarf"])
        };
        assert_eq!(told.messages("f", &both), ["lost: node \"scarf\"", "motion of clip \"run\" changed"]);
        assert_eq!(told.messages("g", &both), ["content differs as told with c"]);
    }
}
