//! JSON writer that keeps the order of keys and has one layout, so that files differ only where their content does.

/// A JSON value.
#[derive(Clone, Debug)]
pub enum Json {
    Bool(bool),
    Integer(usize),
    Number(f32),
    Text(String),
    List(Vec<Json>),
    Object(Vec<(String, Json)>),
}

/// Longest value that is written on one line, characters.
const LINE_LENGTH: usize = 100;

/// An object of `entries`, in their order.
pub fn object<const N: usize>(entries: [(&str, Json); N]) -> Json {
    Json::Object(entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect())
}

/// A list of values.
pub fn list<T: Into<Json>>(items: impl IntoIterator<Item = T>) -> Json {
    Json::List(items.into_iter().map(Into::into).collect())
}

impl Json {
    /// Appends `key` to an object; other values stay as they are.
    pub fn set(&mut self, key: &str, value: impl Into<Json>) {
        if let Self::Object(entries) = self {
            entries.push((key.to_owned(), value.into()));
        }
    }

    /// Whether this is an empty object or list.
    pub fn is_empty(&self) -> bool {
        match self {
            Self::Object(entries) => entries.is_empty(),
            Self::List(items) => items.is_empty(),
            _ => false,
        }
    }

    /// The text of a file: two spaces of indentation a level, short values on one line, a line feed at the end.
    pub fn to_file_text(&self) -> String {
        let mut text = String::new();
        self.write(&mut text, 0);
        text.push('\n');
        text
    }

    /// The text on one line.
    pub fn to_line(&self) -> String {
        let mut line = String::new();
        self.write_inline(&mut line);
        line
    }

    fn write(&self, out: &mut String, level: usize) {
        // Short values and long strings stay on one line.
        let line = self.to_line();
        if line.len() + 2 * level <= LINE_LENGTH {
            out.push_str(&line);
            return;
        }
        match self {
            Self::List(items) => write_block(out, level, ['[', ']'], items, |out, item| {
                item.write(out, level + 1);
            }),
            Self::Object(entries) => write_block(out, level, ['{', '}'], entries, |out, (key, value)| {
                write_text(out, key);
                out.push_str(": ");
                value.write(out, level + 1);
            }),
            _ => out.push_str(&line),
        }
    }

    fn write_inline(&self, out: &mut String) {
        match self {
            Self::Bool(value) => out.push_str(if *value { "true" } else { "false" }),
            Self::Integer(value) => out.push_str(&value.to_string()),
            // Adding zero turns −0 into 0; Display prints the shortest decimal that reads back the same.
            Self::Number(value) => out.push_str(&(value + 0.0).to_string()),
            Self::Text(value) => write_text(out, value),
            Self::List(items) => {
                out.push('[');
                for (index, item) in items.iter().enumerate() {
                    out.push_str(if index == 0 { "" } else { ", " });
                    item.write_inline(out);
                }
                out.push(']');
            }
            Self::Object(entries) => {
                out.push_str("{ ");
                for (index, (key, value)) in entries.iter().enumerate() {
                    out.push_str(if index == 0 { "" } else { ", " });
                    write_text(out, key);
                    out.push_str(": ");
                    value.write_inline(out);
                }
                out.push_str(" }");
            }
        }
    }
}

fn write_block<T>(
    out: &mut String,
    level: usize,
    brackets: [char; 2],
    items: &[T],
    mut write_item: impl FnMut(&mut String, &T),
) {
    out.push(brackets[0]);
    for (index, item) in items.iter().enumerate() {
        out.push_str(if index == 0 { "\n" } else { ",\n" });
        out.push_str(&"  ".repeat(level + 1));
        write_item(out, item);
    }
    out.push('\n');
    out.push_str(&"  ".repeat(level));
    out.push(brackets[1]);
}

fn write_text(out: &mut String, text: &str) {
    out.push('"');
    for character in text.chars() {
        match character {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            _ => out.push(character),
        }
    }
    out.push('"');
}

macro_rules! from {
    ($($source:ty => |$value:ident| $json:expr;)*) => {
        $(impl From<$source> for Json {
            fn from($value: $source) -> Self {
                $json
            }
        })*
    };
}

from! {
    bool => |value| Json::Bool(value);
    usize => |value| Json::Integer(value);
    f32 => |value| Json::Number(value);
    &str => |value| Json::Text(value.to_owned());
    String => |value| Json::Text(value);
    Vec<Json> => |value| Json::List(value);
    &serde_json::Value => |value| from_value(value);
    serde_json::Value => |value| from_value(&value);
    glam::Vec2 => |value| list(value.to_array());
    glam::Vec3 => |value| list(value.to_array());
    glam::Vec4 => |value| list(value.to_array());
    glam::Quat => |value| list(value.to_array());
    glam::Mat4 => |value| list(value.to_cols_array());
}

/// Numbers become integers where they are, else the nearest `f32`; `null` is not supported and becomes an empty string.
fn from_value(value: &serde_json::Value) -> Json {
    use serde_json::Value;
    match value {
        Value::Null => Json::Text(String::new()),
        Value::Bool(value) => Json::Bool(*value),
        Value::Number(number) => match number.as_u64() {
            Some(integer) => Json::Integer(integer as usize),
            None => Json::Number(number.as_f64().unwrap_or_default() as f32),
        },
        Value::String(text) => Json::Text(text.clone()),
        Value::Array(items) => Json::List(items.iter().map(from_value).collect()),
        Value::Object(entries) => {
            Json::Object(entries.iter().map(|(key, value)| (key.clone(), from_value(value))).collect())
        }
    }
}
