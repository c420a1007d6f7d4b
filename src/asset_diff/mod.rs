//! Comparison of two versions of an asset: what changed in the file, and how it looks.
//!
//! [`AssetFacts`] are the contents of an imported scene as [groups](Group) of named items with properties.
//! [`AssetDifference::new`] compares the facts of two scenes: it pairs their items by name and lists what was added, removed and
//! changed. [`AssetPair`] renders both scenes with the same cameras and the same light, at the same times, in [`View`]s.
//!
//! Of the two, the *reference* is the version before, the *actual* one the version after. Texel values, vertex positions and keyframe
//! values are not compared as data: the rendered images show them.

mod change_table;
mod difference;
mod facts;
mod group_kind;
mod item;
mod matching;
mod pair;
mod same_ids;
mod value;
mod views;

pub use difference::{AssetDifference, Change, ChangeKind, PropertyChange};
pub use facts::AssetFacts;
pub use group_kind::GroupKind;
pub use item::{Group, Item, Property};
pub use pair::{AssetPair, MaterialNames};
pub use value::Value;
pub use views::View;
