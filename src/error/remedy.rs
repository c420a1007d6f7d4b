//! Remedies of refused requests.

use std::fmt;

/// What to do about a request beyond a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitRemedy {
    /// What helps besides a higher limit, such as `render a smaller image`.
    pub instead: Option<&'static str>,
    /// What sets the limit: a setting in backquotes, or an option.
    pub raise: &'static str,
}

impl fmt::Display for LimitRemedy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(instead) = self.instead {
            write!(formatter, "{instead} or ")?;
        }
        write!(formatter, "raise {}", self.raise)
    }
}

/// The remedy as the end of a message.
pub(super) fn suffix(remedy: Option<LimitRemedy>) -> String {
    remedy.map_or_else(String::new, |remedy| format!("; {remedy}"))
}
