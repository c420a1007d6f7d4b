//! Validator for the part of JSON Schema (draft 2020-12) that the schemas of this repository use.
//!
//! An unknown keyword fails the test, so that nothing goes unchecked. So does a property that the schema does not describe.

use serde_json::Value;

/// A schema of the repository.
pub(crate) struct Schema(Value);

impl Schema {
    /// `schema/NAME.schema.json`.
    #[expect(clippy::unwrap_used, reason = "a test that cannot go on may panic")]
    pub(crate) fn read(name: &str) -> Self {
        let path = format!("{}/schema/{name}.schema.json", env!("CARGO_MANIFEST_DIR"));
        Self(serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap())
    }

    /// Panics unless `value` matches the schema.
    pub(crate) fn check(&self, value: &Value) {
        let outcome = check(&self.0, value);
        assert!(outcome.is_ok(), "{outcome:?}: {value:#}");
    }

    /// Whether `value` matches the schema.
    pub(crate) fn accepts(&self, value: &Value) -> bool {
        check(&self.0, value).is_ok()
    }
}

fn check(schema: &Value, value: &Value) -> Result<(), String> {
    let keywords = schema.as_object().ok_or("a schema is an object")?;
    for (keyword, rule) in keywords {
        let holds = match keyword.as_str() {
            "$schema" | "title" | "description" => true,
            "type" => match rule.as_array() {
                Some(types) => types.iter().any(|kind| is_of_type(kind, value)),
                None => is_of_type(rule, value),
            },
            "const" => value == rule,
            "enum" => rule.as_array().is_some_and(|values| values.contains(value)),
            "minimum" => value.as_f64().is_none_or(|number| Some(number) >= rule.as_f64()),
            "maximum" => value.as_f64().is_none_or(|number| Some(number) <= rule.as_f64()),
            "minLength" => {
                value.as_str().is_none_or(|text| Some(text.chars().count() as u64) >= rule.as_u64())
            }
            "maxLength" => {
                value.as_str().is_none_or(|text| Some(text.chars().count() as u64) <= rule.as_u64())
            }
            "minItems" => value.as_array().is_none_or(|list| Some(list.len() as u64) >= rule.as_u64()),
            "maxItems" => value.as_array().is_none_or(|list| Some(list.len() as u64) <= rule.as_u64()),
            "required" => {
                let names = rule.as_array().ok_or("required is a list")?;
                names.iter().all(|name| value.get(name.as_str().unwrap_or_default()).is_some())
            }
            "properties" => {
                for (name, member) in value.as_object().into_iter().flatten() {
                    let rule = rule.get(name).or(keywords.get("additionalProperties"));
                    let rule = rule.ok_or_else(|| format!("{name} is not described"))?;
                    check(rule, member).map_err(|why| format!("{name}: {why}"))?;
                }
                true
            }
            "additionalProperties" => {
                let described = keywords.get("properties");
                for (name, member) in value.as_object().into_iter().flatten() {
                    if described.is_none_or(|described| described.get(name).is_none()) {
                        check(rule, member).map_err(|why| format!("{name}: {why}"))?;
                    }
                }
                true
            }
            "items" => {
                for (index, item) in value.as_array().into_iter().flatten().enumerate() {
                    check(rule, item).map_err(|why| format!("{index}: {why}"))?;
                }
                true
            }
            "oneOf" => {
                let outcomes: Vec<_> =
                    rule.as_array().into_iter().flatten().map(|one| check(one, value)).collect();
                if outcomes.iter().filter(|outcome| outcome.is_ok()).count() != 1 {
                    return Err(format!("not one of {outcomes:?}"));
                }
                true
            }
            unknown => return Err(format!("the keyword {unknown} is not known")),
        };
        if !holds {
            return Err(format!("{keyword} {rule} does not hold for {value}"));
        }
    }
    Ok(())
}

fn is_of_type(kind: &Value, value: &Value) -> bool {
    match kind.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("null") => value.is_null(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        _ => false,
    }
}
