//! Nodes: transforms of meshes, cameras, lights and child nodes.

use glam::{Mat4, Quat, Vec3};

use crate::json::{Json, list, object};

/// A node. Fields that are not set are not written.
#[derive(Clone, Debug, Default)]
pub struct Node {
    pub name: Option<&'static str>,
    pub matrix: Option<Mat4>,
    pub translation: Option<Vec3>,
    pub rotation: Option<Quat>,
    pub scale: Option<Vec3>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    pub light: Option<usize>,
    pub weights: Vec<f32>,
    pub children: Vec<usize>,
}

impl Node {
    /// A node with a mesh.
    pub fn mesh(mesh: usize) -> Self {
        Self { mesh: Some(mesh), ..Self::default() }
    }

    /// A node with children.
    pub fn group(children: &[usize]) -> Self {
        Self { children: children.to_vec(), ..Self::default() }
    }

    /// The same node with a name.
    #[must_use]
    pub fn named(self, name: &'static str) -> Self {
        Self { name: Some(name), ..self }
    }

    /// The same node with a translation, metres.
    #[must_use]
    pub fn at(self, x: f32, y: f32, z: f32) -> Self {
        Self { translation: Some(Vec3::new(x, y, z)), ..self }
    }

    /// The same node with a rotation.
    #[must_use]
    pub fn turned(self, rotation: Quat) -> Self {
        Self { rotation: Some(rotation), ..self }
    }

    /// The same node with a scale along its axes.
    #[must_use]
    pub fn scaled(self, x: f32, y: f32, z: f32) -> Self {
        Self { scale: Some(Vec3::new(x, y, z)), ..self }
    }

    /// The JSON object of the node.
    pub fn into_json(self) -> Json {
        let mut json = object([]);
        let mut set = |key: &str, value: Option<Json>| {
            if let Some(value) = value {
                json.set(key, value);
            }
        };
        set("name", self.name.map(Json::from));
        set("matrix", self.matrix.map(Json::from));
        set("translation", self.translation.map(Json::from));
        set("rotation", self.rotation.map(Json::from));
        set("scale", self.scale.map(Json::from));
        set("mesh", self.mesh.map(Json::from));
        set("skin", self.skin.map(Json::from));
        set("camera", self.camera.map(Json::from));
        set("weights", Some(list(self.weights.clone())).filter(|weights| !weights.is_empty()));
        set("children", Some(list(self.children.clone())).filter(|children| !children.is_empty()));
        let extensions = self.light.map(|light| object([("light", light.into())]));
        set("extensions", extensions.map(|light| object([("KHR_lights_punctual", light)])));
        json
    }
}
