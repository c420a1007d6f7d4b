//! Mutation of a JSON document: a few edits of its parsed tree.

use std::sync::{Mutex, PoisonError};

use serde_json::Value;

use super::json_edit::{edit, member_at};
use super::{MutateBytes, Random};

/// Most edits at a time.
const MAX_EDITS: usize = 4;
/// Number of kept members.
const POOL: usize = 512;
/// Longest text of a kept member.
const MAX_POOLED: usize = 4096;

/// Members of documents seen before, by name: they carry objects from one document to another.
#[derive(Debug, Default)]
pub(crate) struct Pool {
    members: Vec<(String, Value)>,
}

static SEEN: Mutex<Pool> = Mutex::new(Pool { members: Vec::new() });

impl Pool {
    /// Keeps a random member of `document`.
    fn keep(&mut self, document: &mut Value, random: &mut Random) {
        let (name, value) = member_at(document, random);
        if name.is_empty() || value.to_string().len() > MAX_POOLED {
            return;
        }
        let member = (name, value.clone());
        if self.members.len() < POOL {
            self.members.push(member);
        } else {
            let index = random.below(POOL);
            self.members[index] = member;
        }
    }

    /// A member called `name`, or any.
    pub(crate) fn member(&self, name: &str, random: &mut Random) -> Option<&(String, Value)> {
        let start = random.below(self.members.len());
        let mut from_start = self.members[start.min(self.members.len())..].iter().chain(&self.members);
        if random.one_of(4) { from_start.next() } else { from_start.find(|member| member.0 == name) }
    }
}

/// The document with some edits; `None` if `text` is none.
pub(crate) fn mutated(text: &[u8], random: &mut Random, mutate_bytes: MutateBytes<'_>) -> Option<Vec<u8>> {
    let mut document: Value = serde_json::from_slice(text).ok()?;
    let mut pool = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    pool.keep(&mut document, random);
    for _ in 0..=random.below(MAX_EDITS) {
        edit(&mut document, &pool, random, mutate_bytes);
    }
    serde_json::to_vec(&document).ok()
}
