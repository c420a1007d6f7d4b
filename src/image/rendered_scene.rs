//! What an image was rendered from, as its file's attributes tell: the camera, and hashes of the parts of the scene.

use std::fmt::Write as _;

use super::{ContentChange, SceneContent};

/// What an image was rendered from. Other programs' files tell some of it or nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderedScene {
    /// The matrices `worldToCamera` and `worldToNDC`, one after the other.
    pub camera: Option<[[f32; 16]; 2]>,
    /// Hashes of the parts of the scene.
    pub parts: Option<PartHashes>,
    /// Names of the content of the scene.
    pub content: Option<SceneContent>,
}

impl RenderedScene {
    /// What is lost and new since the reference was rendered. Empty unless both files list their content.
    pub fn content_changes(&self, reference: &Self) -> Vec<ContentChange> {
        let both = self.content.as_ref().zip(reference.content.as_ref());
        both.map(|(actual, reference)| actual.changes_since(reference)).unwrap_or_default()
    }
}

/// Where the camera of an image comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraOrigin {
    /// It stands in the file of the scene.
    File,
    /// It frames the scene at all times of clips: the automatic camera, and those of views.
    Framed,
    /// A camera path, a turntable, or a camera that no clip moves.
    Other,
}

impl CameraOrigin {
    const ALL: [Self; 3] = [Self::File, Self::Framed, Self::Other];

    fn name(self) -> &'static str {
        match self {
            Self::File => "file",
            Self::Framed => "framed",
            Self::Other => "other",
        }
    }
}

/// Hashes of the parts of a scene at the time of a frame, 16 hexadecimal digits each. Names and unused content do not count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartHashes {
    /// Vertices with their colours and triangles, with the world matrices, joints and morph weights of the nodes that show them.
    pub geometry: String,
    /// Materials and textures.
    pub materials: String,
    /// Which primitives have which materials. It follows geometry and materials, and tells more where these are equal.
    pub assignments: String,
    /// Lights and the environment.
    pub lights: String,
    /// Geometry without vertex colours; `None` in files of earlier versions.
    pub shape: Option<String>,
    /// The plate behind the scene, and whether the environment shows; `None` in files of earlier versions.
    pub background: Option<String>,
    /// Where the camera comes from; `None` in files of earlier versions.
    pub camera: Option<CameraOrigin>,
    /// Number of the rules by which the hashes were made, [`PartHashes::RULES`] then; `None` in files of earlier versions. Hashes of other
    /// rules may differ where the scene does not.
    pub rules: Option<u32>,
}

impl PartHashes {
    /// Name of the text attribute in EXR files.
    pub const ATTRIBUTE: &'static str = "sceneParts";
    /// Number of the present rules. It grows when the hash of any scene or the checksum of any clip changes.
    pub const RULES: u32 = 1;

    /// The value of the attribute.
    pub fn text(&self) -> String {
        let Self { geometry, materials, assignments, lights, shape, background, camera, rules } = self;
        let camera = camera.map(|camera| camera.name().to_owned());
        let rules = rules.map(|rules| rules.to_string());
        let mut text =
            format!("geometry={geometry} materials={materials} assignments={assignments} lights={lights}");
        for (name, value) in
            [("shape", shape), ("background", background), ("camera", &camera), ("rules", &rules)]
        {
            if let Some(value) = value {
                let _ = write!(text, " {name}={value}");
            }
        }
        text
    }

    /// The hashes of a value of the attribute; `None` for any other text.
    pub fn parse(text: &str) -> Option<Self> {
        let value = |name: &str| {
            let word = text.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
            word.map(str::to_owned)
        };
        Some(Self {
            geometry: value("geometry")?,
            materials: value("materials")?,
            assignments: value("assignments")?,
            lights: value("lights")?,
            shape: value("shape"),
            background: value("background"),
            camera: value("camera")
                .and_then(|name| CameraOrigin::ALL.into_iter().find(|origin| origin.name() == name)),
            rules: value("rules").and_then(|rules| rules.parse().ok()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_read_as_they_are_written() {
        let text =
            "geometry=a1 materials=b2 assignments=d4 lights=c3 shape=f6 background=e5 camera=file rules=7";
        let parts = PartHashes::parse(text).unwrap();
        assert_eq!((parts.background.as_deref(), parts.rules), (Some("e5"), Some(7)));
        assert_eq!(parts.camera, Some(CameraOrigin::File));
        assert_eq!(parts.text(), text);
        // Earlier versions wrote less.
        let earlier = "geometry=a1 materials=b2 assignments=d4 lights=c3";
        let parts = PartHashes::parse(earlier).unwrap();
        assert_eq!((parts.shape.as_deref(), parts.rules, parts.text().as_str()), (None, None, earlier));
        assert_eq!(PartHashes::parse("geometry=a1 lights=c3"), None);
    }
}
