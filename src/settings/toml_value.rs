//! Values of TOML as texts of settings.

use std::ffi::OsString;

use toml::de::{DeInteger, DeValue};

use super::setting_type::{Single, ValueForm};

/// The texts of a value; `None` where the form does not accept it.
pub(super) fn texts(form: ValueForm, value: &DeValue<'_>) -> Option<Vec<OsString>> {
    match value {
        DeValue::Boolean(value) if matches!(form.single, Single::Flag | Single::FlagOrText) => {
            Some(vec![value.to_string().into()])
        }
        DeValue::Array(elements) => {
            let texts: Option<Vec<String>> =
                elements.iter().map(|element| scalar(element.get_ref())).collect();
            match form.separator {
                Some(separator) => Some(vec![texts?.join(separator).into()]),
                None if form.is_repeated && elements.iter().all(|element| element.get_ref().is_str()) => {
                    Some(texts?.into_iter().map(OsString::from).collect())
                }
                None => None,
            }
        }
        DeValue::String(text) if form.takes_text() => Some(vec![text.as_ref().into()]),
        DeValue::Integer(_) | DeValue::Float(_) if form.takes_number() => Some(vec![scalar(value)?.into()]),
        _ => None,
    }
}

/// Numbers as they are written, and strings.
fn scalar(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.as_ref().to_owned()),
        DeValue::Integer(number) => Some(decimal(number)),
        DeValue::Float(number) => Some(number.as_str().to_owned()),
        _ => None,
    }
}

/// A number as written; `None` for other values.
pub(crate) fn number(value: &DeValue<'_>) -> Option<f64> {
    let is_number = matches!(value, DeValue::Integer(_) | DeValue::Float(_));
    scalar(value).filter(|_| is_number)?.parse().ok()
}

/// In decimal digits. A number that is too long stays as it is; no setting accepts it.
fn decimal(number: &DeInteger<'_>) -> String {
    i64::from_str_radix(number.as_str(), number.radix())
        .map_or_else(|_| number.as_str().to_owned(), |number| number.to_string())
}

/// The kind of a value in words.
pub(super) fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
