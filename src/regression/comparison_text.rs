//! Verdicts in words: what was measured and what was allowed, and what fails whatever is allowed.

use super::{Check, Mismatch};

impl std::fmt::Display for Check {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.passes { "<=" } else { ">" };
        write!(formatter, "{}: {} {sign} {}", self.measure, short(self.measured), short(self.limit))?;
        match self.at {
            Some((x, y)) => write!(formatter, ", worst at column {x}, row {y}"),
            None => Ok(()),
        }
    }
}

/// Four digits, without zeros that say nothing.
pub(super) fn short(value: f64) -> String {
    // Counts as they are.
    if value == libm::trunc(value) && value.abs() < 1e9 {
        return format!("{value:.0}");
    }
    let digits = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    if !digits.is_finite() || !(-4.0..4.0).contains(&digits) {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.0$}", (3.0 - digits) as usize);
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

impl std::fmt::Display for Mismatch {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Size { actual, reference } if actual[0] != reference[0] => {
                let [(w, h), (rw, rh)] = [actual[0], reference[0]];
                write!(formatter, "the size is {w}x{h}, the reference's {rw}x{rh}")
            }
            Self::Size { actual, reference } => {
                let [[(x, y), (w, h)], [(rx, ry), (rw, rh)]] =
                    [actual, reference].map(|[_, origin, size]| [*origin, *size]);
                write!(
                    formatter,
                    "holds {w}x{h} pixels from column {x}, row {y}, the reference {rw}x{rh} from column {rx}, row {ry}"
                )
            }
            Self::Channel { channel, missing_in_reference: true } => {
                write!(formatter, "has the channel {channel}, which the reference lacks")
            }
            Self::Channel { channel, .. } => {
                write!(formatter, "lacks the channel {channel} of the reference")
            }
            Self::NotFinite { in_reference: false, values } => write!(formatter, "{values}"),
            Self::NotFinite { values, .. } => write!(formatter, "in the reference {values}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in
            [(0.031_04, "0.03104"), (0.02, "0.02"), (12.0, "12"), (0.0, "0"), (3e-7, "3.0e-7")]
        {
            assert_eq!(short(value), text);
        }
    }
}
