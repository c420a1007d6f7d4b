//! Items of an asset, such as nodes and materials, as named lists of properties.

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use super::group_kind::GroupKind;
use super::value::Value;

/// Items of one kind, in the order of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// What they are.
    pub group: GroupKind,
    /// The items.
    pub items: Vec<Item>,
}

/// An item of the file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Item {
    /// Its name, or what stands for it, such as `#2`.
    pub name: String,
    /// Whether the file names it.
    pub is_named: bool,
    /// What else identifies it, such as the name of the node that holds it.
    #[serde(skip)]
    pub alias: Option<String>,
    /// Whether an asset without it has lost content, however it looks.
    #[serde(skip)]
    pub is_content: bool,
    /// What it is like.
    #[serde(serialize_with = "as_map")]
    pub properties: Vec<Property>,
}

/// A property of an item.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name, unique within the item.
    pub name: String,
    /// Its value.
    pub value: Value,
}

impl Item {
    /// An item of this name, or `#index` without one.
    pub(super) fn new(name: Option<&str>, index: usize) -> Self {
        let is_named = name.is_some();
        let name = name.map_or_else(|| format!("#{index}"), ToOwned::to_owned);
        Self { name, is_named, ..Self::default() }
    }

    /// Adds a property.
    pub(super) fn set(&mut self, name: impl Into<String>, value: Value) {
        self.properties.push(Property { name: name.into(), value });
    }

    /// The value of a property.
    pub fn value(&self, name: &str) -> Option<&Value> {
        self.properties.iter().find(|property| property.name == name).map(|property| &property.value)
    }
}

fn as_map<S: Serializer>(properties: &[Property], serializer: S) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(properties.len()))?;
    for property in properties {
        map.serialize_entry(&property.name, &property.value)?;
    }
    map.end()
}
