//! Typed access to JSON values that the `gltf` crate does not model. Each value keeps its JSON pointer for messages.

use std::borrow::Cow;

use serde_json::Value;

use super::context::Context;
use crate::error::Result;

pub(super) use crate::scene::ranges::{ANY, AT_LEAST_ONE, NOT_NEGATIVE, POSITIVE, UNIT};

/// JSON value with its JSON pointer.
#[derive(Clone, Debug)]
pub(super) struct Raw<'a> {
    /// The value.
    pub(super) value: &'a Value,
    /// Its JSON pointer.
    pub(super) pointer: String,
}

impl<'a> Raw<'a> {
    /// Returns the value at `pointer` of the document.
    pub(super) fn at(document: &'a Value, pointer: impl Into<String>) -> Option<Self> {
        let pointer = pointer.into();
        Some(Self { value: document.pointer(&pointer)?, pointer })
    }

    /// Returns the member `key` of an object.
    pub(super) fn field(&self, key: &str) -> Option<Self> {
        Some(Self { value: self.value.get(key)?, pointer: format!("{}/{}", self.pointer, escape(key)) })
    }

    /// Returns the extension `name` of this object.
    pub(super) fn extension(&self, name: &str) -> Option<Self> {
        self.field("extensions")?.field(name)
    }

    /// Returns the extension `name` of this object. Errors unless it is an object.
    pub(super) fn extension_object(&self, context: &Context, name: &str) -> Result<Option<Self>> {
        let extension = self.extension(name);
        extension.map(|extension| extension.expect_object(context).map(|()| extension)).transpose()
    }

    /// Returns the index `light` of the extension `name` of this object into a list of `count` values.
    pub(super) fn extension_light(
        &self,
        context: &Context,
        name: &str,
        count: usize,
        noun: &str,
    ) -> Result<Option<usize>> {
        let Some(extension) = self.extension_object(context, name)? else {
            return Ok(None);
        };
        let pointer = format!("{}/light", extension.pointer);
        let Some(index) = extension.index(context, "light")? else {
            return Err(context.invalid(pointer, "is missing"));
        };
        context.check_index(index, count, &pointer, noun).map(Some)
    }

    /// Errors unless the value is an object.
    pub(super) fn expect_object(&self, context: &Context) -> Result<()> {
        if self.value.is_object() {
            return Ok(());
        }
        Err(context.invalid(&self.pointer, "must be an object"))
    }

    /// Returns the elements of an array.
    pub(super) fn elements(&self, context: &Context) -> Result<Vec<Self>> {
        let Some(array) = self.value.as_array() else {
            return Err(context.invalid(&self.pointer, "must be an array"));
        };
        Ok(array
            .iter()
            .enumerate()
            .map(|(i, value)| Self { value, pointer: format!("{}/{i}", self.pointer) })
            .collect())
    }

    /// Returns the members of an object whose values are indices: key, index and JSON pointer.
    pub(super) fn indices(&self, context: &Context) -> Result<Vec<(&'a str, usize, String)>> {
        self.expect_object(context)?;
        let members = self.value.as_object().into_iter().flatten();
        members
            .map(|(key, _)| {
                let index = self.index(context, key)?.unwrap_or_default();
                Ok((key.as_str(), index, format!("{}/{}", self.pointer, escape(key))))
            })
            .collect()
    }

    /// Returns a string member.
    pub(super) fn string(&self, context: &Context, key: &str) -> Result<Option<&'a str>> {
        let Some(field) = self.field(key) else {
            return Ok(None);
        };
        match field.value.as_str() {
            Some(text) => Ok(Some(text)),
            None => Err(context.invalid(field.pointer, "must be a string")),
        }
    }

    /// Returns a member that is a non-negative integer.
    pub(super) fn index(&self, context: &Context, key: &str) -> Result<Option<usize>> {
        let Some(field) = self.field(key) else {
            return Ok(None);
        };
        match field.value.as_u64().and_then(|value| usize::try_from(value).ok()) {
            Some(index) => Ok(Some(index)),
            None => Err(context.invalid(field.pointer, "must be a non-negative integer")),
        }
    }

    /// Returns a member that is a finite number in `range`.
    pub(super) fn number(
        &self,
        context: &Context,
        key: &str,
        default: f32,
        range: std::ops::RangeInclusive<f32>,
    ) -> Result<f32> {
        let Some(field) = self.field(key) else {
            return Ok(default);
        };
        let Some(value) = field.value.as_f64() else {
            return Err(context.invalid(field.pointer, "must be a number"));
        };
        check_range(context, value as f32, &range, &field.pointer)
    }

    /// Returns a member that is a distance in `range`. Finite ones beyond 32-bit floats are infinite: some programs write the
    /// largest 64-bit float for none.
    pub(super) fn distance(
        &self,
        context: &Context,
        key: &str,
        range: std::ops::RangeInclusive<f32>,
    ) -> Result<Option<f32>> {
        let Some(field) = self.field(key) else {
            return Ok(None);
        };
        match field.value.as_f64() {
            Some(distance) if distance as f32 == f32::INFINITY => Ok(Some(f32::INFINITY)),
            _ => self.number(context, key, 0.0, range).map(Some),
        }
    }

    /// Returns a member that is an array of `N` finite numbers in `range`.
    pub(super) fn numbers<const N: usize>(
        &self,
        context: &Context,
        key: &str,
        default: [f32; N],
        range: std::ops::RangeInclusive<f32>,
    ) -> Result<[f32; N]> {
        match self.field(key) {
            Some(field) => field.array(context, range),
            None => Ok(default),
        }
    }

    /// Returns a member that is a number from 0 to 1. Factors outside are clamped, with a warning.
    pub(super) fn unit(&self, context: &mut Context, key: &str, default: f32) -> Result<f32> {
        let value = self.number(context, key, default, ANY)?;
        let [value] = clamp_to_unit(context, [value], || format!("{}/{key}", self.pointer));
        Ok(value)
    }

    /// As [`Self::unit`], a member that is an array of `N` numbers.
    pub(super) fn units<const N: usize>(
        &self,
        context: &mut Context,
        key: &str,
        default: [f32; N],
    ) -> Result<[f32; N]> {
        let values = self.numbers(context, key, default, ANY)?;
        Ok(clamp_to_unit(context, values, || format!("{}/{key}", self.pointer)))
    }

    /// Returns the value as an array of `N` finite numbers in `range`.
    pub(super) fn array<const N: usize>(
        &self,
        context: &Context,
        range: std::ops::RangeInclusive<f32>,
    ) -> Result<[f32; N]> {
        let wrong = || context.invalid(&self.pointer, format!("must be an array of {N} numbers"));
        let array = self.value.as_array().filter(|array| array.len() == N);
        let mut values = [0.0; N];
        for (value, element) in values.iter_mut().zip(array.ok_or_else(wrong)?) {
            let number = element.as_f64().ok_or_else(wrong)? as f32;
            *value = check_range(context, number, &range, &self.pointer)?;
        }
        Ok(values)
    }
}

/// Rounding errors of exporters beyond the limits of a range.
pub(super) const TOLERANCE: f32 = 1e-4;

/// The value, or `low` where it is below by a rounding error.
pub(super) fn without_rounding_below(value: f32, low: f32) -> f32 {
    if value < low && value >= low - TOLERANCE { low } else { value }
}

/// Checks that `value` is finite and in `range`. A rounding error beyond a limit is clamped to it, but zero is not [`POSITIVE`].
pub(super) fn check_range(
    context: &Context,
    value: f32,
    range: &std::ops::RangeInclusive<f32>,
    pointer: &str,
) -> Result<f32> {
    let (low, high) = (*range.start(), *range.end());
    let value = if low == f32::MIN_POSITIVE { value } else { without_rounding_below(value, low) };
    if value.is_finite() && range.contains(&value) {
        return Ok(value);
    }
    if value > high && value <= high + TOLERANCE {
        return Ok(high);
    }
    if value.is_infinite() {
        return Err(context.invalid(pointer, "must be a number that 32-bit floats can hold"));
    }
    let message = match (low == f32::MIN, high == f32::MAX) {
        (true, _) => format!("is {value}, but must be a finite number"),
        (false, true) if low == f32::MIN_POSITIVE => {
            format!("is {value}, but must be a finite number above 0")
        }
        (false, true) => format!("is {value}, but must be a finite number of at least {low}"),
        (false, false) if low == f32::MIN_POSITIVE => {
            format!("is {value}, but must lie above 0 and be at most {high}")
        }
        (false, false) => format!("is {value}, but must lie between {low} and {high}"),
    };
    Err(context.invalid(pointer, message))
}

/// Clamps the finite `values` at `pointer` to the range from 0 to 1. Warns unless they are beyond it by rounding errors alone.
fn clamp_to_unit<const N: usize>(
    context: &mut Context,
    values: [f32; N],
    pointer: impl Fn() -> String,
) -> [f32; N] {
    values.map(|value| {
        let clamped = value.clamp(0.0, 1.0);
        if (value - clamped).abs() > TOLERANCE {
            let message = format!("is {value}, but must lie between 0 and 1; it is taken for {clamped}");
            context.warn(pointer(), message);
        }
        clamped
    })
}

/// A token of a pointer that is only shown. The pointers of all objects below a long key would have it.
pub(super) fn shortened(token: &str) -> Cow<'_, str> {
    const MOST_BYTES: usize = 256;
    if token.len() <= MOST_BYTES {
        return Cow::Borrowed(token);
    }
    let ends = token.char_indices().map(|(start, _)| start);
    let kept = ends.take_while(|end| *end <= MOST_BYTES).last().unwrap_or_default();
    Cow::Owned(format!("{}…", token.get(..kept).unwrap_or_default()))
}

/// Escapes `key` as a JSON pointer token (RFC 6901, section 3).
pub(super) fn escape(key: &str) -> String {
    key.replace('~', "~0").replace('/', "~1")
}
