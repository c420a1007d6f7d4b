//! The render hashes of the frames of a job. What they share depends on every node, and is gathered once.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};

use crate::sha256::hex;

use super::SequenceJob;
use super::render_hash::content_of_all_frames;

/// The hash of `frame`, 64 hexadecimal digits.
pub fn render_hash(job: &SequenceJob, frame: i64) -> String {
    RenderHashes::new(job).of(frame)
}

/// The render hashes of the frames of a job.
#[derive(Debug)]
pub(crate) struct RenderHashes<'a> {
    job: &'a SequenceJob,
    shared: PrintedObject,
}

impl<'a> RenderHashes<'a> {
    pub(crate) fn new(job: &'a SequenceJob) -> Self {
        Self { job, shared: PrintedObject::new(&content_of_all_frames(job)) }
    }

    /// That of `frame`, 64 hexadecimal digits.
    pub(crate) fn of(&self, frame: i64) -> String {
        let mut own = vec![("frame", json!(frame))];
        if let Some(plates) = &self.job.plates {
            let (content_hash, fit) = plates.content_key(frame);
            own.push(("plate", json!([content_hash.map(|hash| hex(&hash)), fit])));
        }
        hex(&Sha256::digest(self.shared.text_with(own).as_bytes()))
    }
}

/// The members of a JSON object, printed.
#[derive(Debug)]
struct PrintedObject(BTreeMap<String, String>);

impl PrintedObject {
    fn new(object: &Value) -> Self {
        let members = object.as_object().into_iter().flatten();
        Self(members.map(|(key, value)| (key.clone(), value.to_string())).collect())
    }

    /// The text of the object with other members in addition, its keys in order, as [`Value`] prints them.
    fn text_with(&self, others: Vec<(&str, Value)>) -> String {
        let others: Vec<_> = others.into_iter().map(|(key, value)| (key, value.to_string())).collect();
        let mut members: BTreeMap<&str, &str> =
            self.0.iter().map(|(key, value)| (key.as_str(), value.as_str())).collect();
        members.extend(others.iter().map(|(key, value)| (*key, value.as_str())));
        let members: Vec<_> =
            members.into_iter().map(|(key, value)| format!("{}:{value}", json!(key))).collect();
        format!("{{{}}}", members.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_printed_in_parts_are_as_printed_at_once() {
        let mut object = json!({"b": [1, "x\"y"], "fps": "24", "roots": [], "z": {"d": null, "c": 0.5}});
        let printed = PrintedObject::new(&object);
        assert_eq!(printed.text_with(Vec::new()), object.to_string());
        object["frame"] = json!(-7);
        object["plate"] = json!(["00ff", "fit"]);
        let own = vec![("plate", object["plate"].clone()), ("frame", json!(-7))];
        assert_eq!(printed.text_with(own), object.to_string());
    }
}
