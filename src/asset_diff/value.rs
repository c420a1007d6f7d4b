//! Values of properties: equality within rounding, text, and JSON.

use std::fmt;

use serde::{Serialize, Serializer};

use super::group_kind::GroupKind;
use crate::count_text::grouped;
use crate::error::readable_bytes;

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// A name or a choice.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// A number of things.
    Count(u64),
    /// A size in bytes.
    Bytes(u64),
    /// A number, with its unit in text.
    Number(f32, &'static str),
    /// Components of a vector or a colour.
    Vector(Vec<f32>),
    /// Unit quaternion x y z w; its negative is the same rotation.
    Rotation([f32; 4]),
    /// Names without an order, sorted.
    List(Vec<String>),
    /// Another item of the file, by its group, its index in it and its label: its name, or `#index` without one.
    Item(GroupKind, usize, String),
}

impl Value {
    /// An item of this name.
    pub(super) fn item(group: GroupKind, index: usize, name: Option<&str>) -> Self {
        Self::Item(group, index, name.map_or_else(|| format!("#{index}"), ToOwned::to_owned))
    }

    /// A number of things.
    pub(super) fn count(count: usize) -> Self {
        Self::Count(count as u64)
    }

    /// A number without a unit.
    pub(super) fn number(number: f32) -> Self {
        Self::Number(number, "")
    }

    /// An angle.
    pub(super) fn degrees(radians: f32) -> Self {
        Self::Number(radians.to_degrees(), "°")
    }

    /// Whether two values are equal. Items are equal where their labels are. Numbers may differ by the rounding of another program: a millionth, or ten millionths of
    /// themselves.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Number(a, _), Self::Number(b, _)) => is_close(*a, *b),
            (Self::Item(.., a), Self::Item(.., b)) => a == b,
            (Self::Vector(a), Self::Vector(b)) => are_close(a, b),
            (Self::Rotation(a), Self::Rotation(b)) => are_close(a, b) || are_close(a, &b.map(|part| -part)),
            _ => self == other,
        }
    }
}

fn is_close(a: f32, b: f32) -> bool {
    // Infinite values are equal to themselves only.
    let difference = (a - b).abs();
    a == b || difference.is_finite() && difference <= 1e-6_f32.max(a.abs().max(b.abs()) * 1e-5)
}

fn are_close(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_close(*a, *b))
}

impl fmt::Display for Value {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) | Self::Item(.., text) => formatter.write_str(text),
            Self::Flag(is) => formatter.write_str(if *is { "yes" } else { "no" }),
            Self::Count(count) => formatter.write_str(&grouped(*count)),
            Self::Bytes(bytes) => formatter.write_str(&readable_bytes((*bytes).into())),
            Self::Number(number, "") => formatter.write_str(&short(*number)),
            Self::Number(number, "°") => write!(formatter, "{}°", short(*number)),
            Self::Number(number, unit) => write!(formatter, "{} {unit}", short(*number)),
            Self::Vector(parts) => formatter.write_str(&joined(parts)),
            Self::Rotation(parts) => formatter.write_str(&joined(parts)),
            Self::List(names) if names.is_empty() => formatter.write_str("none"),
            Self::List(names) => formatter.write_str(&names.join(", ")),
        }
    }
}

/// Components with spaces between them.
fn joined(parts: &[f32]) -> String {
    parts.iter().map(|part| short(*part)).collect::<Vec<_>>().join(" ")
}

/// A number with at most five significant digits, without trailing zeros.
fn short(number: f32) -> String {
    if !number.is_finite() {
        return number.to_string();
    }
    let magnitude = libm::floorf(libm::log10f(number.abs().max(1e-9))) as i32;
    let text = format!("{number:.*}", (4 - magnitude).clamp(0, 6) as usize);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Text(text) | Self::Item(.., text) => text.serialize(serializer),
            Self::Flag(is) => is.serialize(serializer),
            Self::Count(count) | Self::Bytes(count) => count.serialize(serializer),
            Self::Number(number, _) => number.serialize(serializer),
            Self::Vector(parts) => parts.serialize(serializer),
            Self::Rotation(parts) => parts.serialize(serializer),
            Self::List(names) => names.serialize(serializer),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_no_difference() {
        let number = |value| Value::Number(value, "");
        assert!(number(0.1).is_same(&number(0.100_000_1)) && !number(0.1).is_same(&number(0.1001)));
        assert!(number(f32::INFINITY).is_same(&number(f32::INFINITY)));
        assert!(!number(f32::INFINITY).is_same(&number(1.0)));
        let turned = Value::Rotation([0.0, 0.6, 0.0, 0.8]);
        assert!(turned.is_same(&Value::Rotation([0.0, -0.6, 0.0, -0.8])));
        assert!(!turned.is_same(&Value::Rotation([0.0, -0.6, 0.0, 0.8])));
        assert!(!Value::Vector(vec![1.0]).is_same(&Value::Vector(vec![1.0, 2.0])));
        assert!(!Value::Text("1".to_owned()).is_same(&Value::Count(1)));
    }

    #[test]
    fn values_have_short_texts() {
        let text = |value: &Value| value.to_string();
        assert_eq!(text(&Value::Vector(vec![0.0, -0.0, 1.5, 0.123_456])), "0 0 1.5 0.12346");
        assert_eq!(text(&Value::Number(123_456.7, "lux")), "123457 lux");
        assert_eq!(text(&Value::Number(2.0, "")), "2");
        assert_eq!(text(&Value::Count(1_234_567)), "1 234 567");
        assert_eq!(text(&Value::Bytes(1_300_000)), "1.3 MB");
        assert_eq!(text(&Value::List(vec!["a".to_owned(), "b".to_owned()])), "a, b");
    }
}
