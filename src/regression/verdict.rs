//! The verdict on an image: identical to its reference, changed within the limits, or failed.

use serde::{Deserialize, Serialize};

/// The outcome of comparing an image with its reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// No value's bits differ. Of the files' attributes only what they tell of the scene counts.
    Identical,
    /// Values differ, or the scene where no value shows it, and every measure is within its limit.
    Changed,
    /// A measure is beyond its limit, or there is nothing to compare.
    Failed,
}

/// Verdicts that make a command fail.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FailOn {
    /// Only failures.
    #[default]
    Failed,
    /// Changes within the limits as well.
    Changed,
}

/// Numbers of images by verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct VerdictCounts {
    /// Images whose values all equal those of their references.
    pub identical: usize,
    /// Images that differ from their references within the limits.
    pub changed: usize,
    /// Images that fail, and orphaned references.
    pub failed: usize,
}

impl Verdict {
    /// The name in JSON, JUnit and the page.
    pub fn name(self) -> &'static str {
        match self {
            Self::Identical => "identical",
            Self::Changed => "changed",
            Self::Failed => "failed",
        }
    }

    /// The verdict in words, for messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Changed => "changed within limits",
            Self::Identical | Self::Failed => self.name(),
        }
    }
}

impl FailOn {
    /// Whether this verdict makes the command fail.
    pub fn fails(self, verdict: Verdict) -> bool {
        match self {
            Self::Failed => verdict == Verdict::Failed,
            Self::Changed => verdict != Verdict::Identical,
        }
    }
}

impl VerdictCounts {
    /// Counts one image.
    pub fn add(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Identical => self.identical += 1,
            Verdict::Changed => self.changed += 1,
            Verdict::Failed => self.failed += 1,
        }
    }

    /// The number of all images.
    pub fn total(self) -> usize {
        self.identical + self.changed + self.failed
    }

    /// The worst verdict that occurs; `Identical` where there are no images.
    pub fn worst(self) -> Verdict {
        match self {
            Self { failed: 0, changed: 0, .. } => Verdict::Identical,
            Self { failed: 0, .. } => Verdict::Changed,
            _ => Verdict::Failed,
        }
    }
}

impl FromIterator<Verdict> for VerdictCounts {
    fn from_iter<I: IntoIterator<Item = Verdict>>(verdicts: I) -> Self {
        let mut counts = Self::default();
        verdicts.into_iter().for_each(|verdict| counts.add(verdict));
        counts
    }
}

impl std::fmt::Display for VerdictCounts {
    /// `130 identical, 2 changed within limits, 1 failed`.
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { identical, changed, failed } = self;
        write!(formatter, "{identical} identical, {changed} changed within limits, {failed} failed")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_add_up_and_name_the_worst() {
        use Verdict::{Changed, Failed, Identical};
        let counts: VerdictCounts = [Identical, Changed, Identical, Failed].into_iter().collect();
        assert_eq!(counts.to_string(), "2 identical, 1 changed within limits, 1 failed");
        assert_eq!((counts.total(), counts.worst()), (4, Failed));
        assert_eq!(VerdictCounts::from_iter([Identical, Changed]).worst(), Changed);
        assert_eq!(VerdictCounts::default().worst(), Identical);
        let fails = |fail_on: FailOn| [Identical, Changed, Failed].map(|verdict| fail_on.fails(verdict));
        assert_eq!(fails(FailOn::Failed), [false, false, true]);
        assert_eq!(fails(FailOn::Changed), [false, true, true]);
    }
}
