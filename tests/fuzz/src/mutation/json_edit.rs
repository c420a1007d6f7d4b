//! One edit of a JSON document.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Number, Value, json};

use super::json::Pool;
use super::words::WORDS;
use super::{MutateBytes, Random};

/// Numbers at the limits of types and of checks.
const NUMBERS: [f64; 24] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    3.0,
    4.0,
    0.5,
    255.0,
    256.0,
    65535.0,
    65536.0,
    16777216.0,
    2147483647.0,
    4294967295.0,
    4294967296.0,
    9007199254740992.0,
    1e-45,
    1e-30,
    1e30,
    3.4e38,
    1e39,
    1e308,
    5126.0,
];
/// Prefix of buffers and images inside the document.
const BASE64: &str = ";base64,";

/// The value at a random place, with the name of the member that it is or is inside of.
pub(crate) fn member_at<'a>(document: &'a mut Value, random: &mut Random) -> (String, &'a mut Value) {
    let (name, pointer) = place(document, random);
    if document.pointer(&pointer).is_none() {
        return (name, document);
    }
    let Some(value) = document.pointer_mut(&pointer) else { unreachable!("the pointer was resolved above") };
    (name, value)
}

/// The name of the last member on the way to a random value, and the value's JSON pointer.
fn place(document: &Value, random: &mut Random) -> (String, String) {
    let (mut name, mut pointer) = (String::new(), String::new());
    let mut value = document;
    while name.is_empty() || !random.one_of(7) {
        let step = match value {
            Value::Array(items) => {
                let index = random.below(items.len());
                items.get(index).map(|item| (index.to_string(), item))
            }
            Value::Object(members) => {
                let member = members.iter().nth(random.below(members.len()));
                member.map(|(key, member)| {
                    name.clone_from(key);
                    (key.replace('~', "~0").replace('/', "~1"), member)
                })
            }
            _ => None,
        };
        let Some((token, inner)) = step else { break };
        pointer = format!("{pointer}/{token}");
        value = inner;
    }
    (name, pointer)
}

/// Changes one value, or the members of one object or array.
pub(crate) fn edit(document: &mut Value, pool: &Pool, random: &mut Random, mutate_bytes: MutateBytes<'_>) {
    let (name, value) = member_at(document, random);
    if random.one_of(6)
        && let Some((_, other)) = pool.member(&name, random)
    {
        *value = other.clone();
        return;
    }
    if random.one_of(24) {
        *value = of_another_type(random);
        return;
    }
    match value {
        Value::Array(items) => edit_array(items, random),
        Value::Object(members) => edit_object(members, pool, random),
        Value::String(text) => edit_text(text, random, mutate_bytes),
        Value::Number(number) => {
            let changed = changed_number(number, random);
            *value = changed;
        }
        Value::Bool(flag) => *flag = !*flag,
        Value::Null => *value = of_another_type(random),
    }
}

fn of_another_type(random: &mut Random) -> Value {
    let values = [
        json!(null),
        json!(true),
        json!(0),
        json!(-1.5),
        json!(""),
        json!([]),
        json!({}),
        json!([0]),
        json!([1, 1, 1]),
    ];
    random.choose(&values).cloned().unwrap_or_default()
}

fn edit_array(items: &mut Vec<Value>, random: &mut Random) {
    let (a, b) = (random.below(items.len()), random.below(items.len()));
    match random.below(4) {
        _ if items.is_empty() => items.push(of_another_type(random)),
        0 => drop(items.remove(a)),
        1 => items.push(items[a].clone()),
        2 => items.swap(a, b),
        _ => items[a] = items[b].clone(),
    }
}

fn edit_object(members: &mut Map<String, Value>, pool: &Pool, random: &mut Random) {
    let key = members.keys().nth(random.below(members.len())).cloned().unwrap_or_default();
    match random.below(4) {
        0 => drop(members.remove(&key)),
        1 => {
            if let (Some(word), Some(value)) = (random.choose(&WORDS), members.get(&key).cloned()) {
                members.insert((*word).to_owned(), value);
            }
        }
        2 => {
            if let Some((name, value)) = pool.member("", random) {
                members.insert(name.clone(), value.clone());
            }
        }
        _ => {
            if let Some(word) = random.choose(&WORDS) {
                members.insert((*word).to_owned(), of_another_type(random));
            }
        }
    }
}

fn edit_text(text: &mut String, random: &mut Random, mutate_bytes: MutateBytes<'_>) {
    // Mutate the data of a data URI, not its text.
    if let Some((prefix, data)) = text.split_once(BASE64)
        && !random.one_of(8)
        && let Ok(mut bytes) = STANDARD.decode(data)
    {
        mutate_bytes(&mut bytes);
        *text = format!("{prefix}{BASE64}{}", STANDARD.encode(bytes));
    } else if let Some(word) = random.choose(&WORDS).filter(|_| !random.one_of(4)) {
        (*word).clone_into(text);
    } else {
        let mut bytes = std::mem::take(text).into_bytes();
        mutate_bytes(&mut bytes);
        *text = String::from_utf8_lossy(&bytes).into_owned();
    }
}

fn changed_number(number: &Number, random: &mut Random) -> Value {
    let value = number.as_f64().unwrap_or_default();
    let changed = match random.below(5) {
        0 => value + 1.0,
        1 => value - 1.0,
        2 => value * 2.0,
        3 => random.below(12) as f64,
        _ => random.choose(&NUMBERS).copied().unwrap_or_default(),
    };
    // Indices and counts are integers in the text.
    if changed.fract() == 0.0 && changed.abs() < 9.0e15 { json!(changed as i64) } else { json!(changed) }
}
