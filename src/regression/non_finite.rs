//! Infinite and NaN values, which always fail a comparison.

use serde::Serialize;

use super::{Channel, Samples};

/// Infinite and NaN values of one channel.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NonFinite {
    /// Name of the channel.
    pub channel: String,
    /// Number of NaN values.
    pub not_a_number: usize,
    /// Number of infinite values.
    pub infinite: usize,
    /// Column and row of the first of them.
    pub first_at: (u32, u32),
}

/// Finds infinite and NaN values in a channel of an image `width` pixels wide; `None` without any.
pub fn non_finite(channel: &Channel, width: u32) -> Option<NonFinite> {
    let Samples::Float(values) = &channel.samples else { return None };
    let first = values.iter().position(|value| !value.is_finite())? as u32;
    Some(NonFinite {
        channel: channel.name.clone(),
        not_a_number: values.iter().filter(|value| value.is_nan()).count(),
        infinite: values.iter().filter(|value| value.is_infinite()).count(),
        first_at: (first % width, first / width),
    })
}

impl std::fmt::Display for NonFinite {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { channel, first_at: (column, row), .. } = self;
        let (count, kinds) = match (self.not_a_number, self.infinite) {
            (0, infinite) => (infinite, "infinite".to_owned()),
            (count, 0) => (count, "not a number".to_owned()),
            (count, infinite) => (count, format!("not a number and {infinite} infinite")),
        };
        let (values, are) = if count == 1 { ("value", "is") } else { ("values", "are") };
        write!(
            formatter,
            "{count} {values} of {channel} {are} {kinds}, the first at column {column}, row {row}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_are_counted_with_the_position_of_the_first() {
        let values = vec![0.0, 1.0, f32::NEG_INFINITY, f32::NAN, f32::INFINITY];
        let channel = Channel { name: "Z".to_owned(), samples: Samples::Float(values) };
        let found = non_finite(&channel, 2).unwrap();
        assert_eq!((found.not_a_number, found.infinite, found.first_at), (1, 2, (0, 1)));
        let text = "1 value of Z is not a number and 2 infinite, the first at column 0, row 1";
        assert_eq!(found.to_string(), text);
        let one_kind = |not_a_number, infinite| {
            NonFinite { not_a_number, infinite, ..found.clone() }
                .to_string()
                .replace(", the first at column 0, row 1", "")
        };
        assert_eq!(one_kind(4, 0), "4 values of Z are not a number");
        assert_eq!(one_kind(0, 1), "1 value of Z is infinite");
        let whole = Channel { name: "Z".to_owned(), samples: Samples::Float(vec![f32::MAX]) };
        assert_eq!(non_finite(&whole, 1), None);
    }
}
