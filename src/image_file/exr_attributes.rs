//! Attributes of the EXR files that this program writes.

use exr::meta::attribute::{AttributeValue, Chromaticities, Text, TimeCode};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use exr::prelude::{IntegerBounds, Vec2};

use super::exr_checksum::{CHECKSUM, ZEROS};
use crate::color::REC709;
use crate::image::{PartHashes, RenderedScene, SceneContent};

/// Name of the attribute of [`FrameAttributes::render_hash`].
pub(super) const RENDER_HASH: &str = "renderHash";
/// Name of the text attribute of the samples that a file holds, where these are not all.
pub const SAMPLE_RANGE: &str = "sampleRange";
/// Names of the attributes of [`FrameAttributes::stamp`].
pub(super) const STAMPS: [&str; 4] = ["capDate", "utcOffset", "renderSeconds", "hostComputer"];

/// Attributes of one frame. All but the stamp, and the `checksum` of the file with it, are the same in every run that renders the same
/// image.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameAttributes {
    /// Program and version (`software`).
    pub software: String,
    /// Hash of the scene, the settings and the version, hexadecimal (`renderHash`).
    pub render_hash: String,
    /// Frame number (`frame`, an int).
    pub frame: i32,
    /// Scene time (`timeSeconds`, a double).
    pub time_seconds: f64,
    /// Frame rate as numerator and denominator (`framesPerSecond`, a rational).
    pub frames_per_second: (i32, u32),
    /// World to camera space; the camera looks along −Z, +Y is up (`worldToCamera`).
    ///
    /// OpenEXR multiplies row vectors from the left and stores rows. Glam multiplies column vectors from the right and
    /// stores columns. The sixteen numbers are the same.
    pub world_to_camera: [f32; 16],
    /// World space to the display window, (0, 0) top left and (1, 1) bottom right (`worldToNDC`), in the same order.
    pub world_to_ndc: [f32; 16],
    /// SMPTE time code: hours, minutes, seconds and frames (`timeCode`); `None` where the frame rate has none.
    pub time_code: Option<[u8; 4]>,
    /// Further text attributes, each a name of up to 31 bytes and a value.
    pub texts: Vec<(String, String)>,
    /// Attributes that differ between runs, if requested.
    pub stamp: Option<RunStamp>,
}

/// When and where a frame was rendered, and how long it took.
#[derive(Clone, Debug, PartialEq)]
pub struct RunStamp {
    /// Date and time in UTC, such as `2026:11:21 18:57:00` (`capDate`, with a `utcOffset` of 0).
    pub capture_date: String,
    /// Name of the machine, if it has one (`hostComputer`).
    pub host: Option<String>,
    /// Seconds to pose, build and trace (`renderSeconds`, a float).
    pub render_seconds: f32,
}

impl FrameAttributes {
    /// What a file with these attributes tells of the scene.
    pub(crate) fn rendered_scene(&self) -> RenderedScene {
        let text =
            |attribute: &str| self.texts.iter().find(|(name, _)| name == attribute).map(|(_, text)| text);
        RenderedScene {
            camera: Some([self.world_to_camera, self.world_to_ndc]),
            parts: text(PartHashes::ATTRIBUTE).and_then(|text| PartHashes::parse(text)),
            content: text(SceneContent::ATTRIBUTE).and_then(|text| SceneContent::parse(text)),
        }
    }

    /// Attributes of an image that is not a rendered frame.
    pub fn unknown() -> Self {
        let identity = glam::Mat4::IDENTITY.to_cols_array();
        Self {
            software: "rayframe".to_owned(),
            render_hash: String::new(),
            frame: 0,
            time_seconds: 0.0,
            frames_per_second: (24, 1),
            world_to_camera: identity,
            world_to_ndc: identity,
            time_code: None,
            texts: Vec::new(),
            stamp: None,
        }
    }

    pub(super) fn of_image(&self, (width, height): (u32, u32)) -> ImageAttributes {
        let mut attributes =
            ImageAttributes::new(IntegerBounds::new((0, 0), (width as usize, height as usize)));
        let xy = |point: glam::Vec2| Vec2(point.x, point.y);
        attributes.chromaticities = Some(Chromaticities {
            red: xy(REC709.red),
            green: xy(REC709.green),
            blue: xy(REC709.blue),
            white: xy(REC709.white),
        });
        attributes.time_code = self.time_code.map(exr_time_code);
        attributes
    }

    pub(super) fn of_layer(&self, position: (i64, i64)) -> LayerAttributes {
        let mut attributes = LayerAttributes {
            layer_position: Vec2(position.0 as i32, position.1 as i32),
            frames_per_second: Some(self.frames_per_second),
            world_to_camera: Some(self.world_to_camera),
            world_to_normalized_device: Some(self.world_to_ndc),
            software_name: Text::new_or_none(&self.software),
            ..LayerAttributes::default()
        };
        let mut own = vec![
            ("frame", AttributeValue::I32(self.frame)),
            ("timeSeconds", AttributeValue::F64(self.time_seconds)),
            (RENDER_HASH, AttributeValue::Text(byte_text(&self.render_hash))),
            (CHECKSUM, AttributeValue::Text(byte_text(ZEROS))),
        ];
        own.extend(
            self.texts.iter().map(|(name, value)| (name.as_str(), AttributeValue::Text(byte_text(value)))),
        );
        if let Some(stamp) = &self.stamp {
            attributes.capture_date = Some(byte_text(&stamp.capture_date));
            attributes.utc_offset = Some(0.0);
            own.push(("renderSeconds", AttributeValue::F32(stamp.render_seconds)));
            let host = stamp.host.as_deref();
            own.extend(host.map(|host| ("hostComputer", AttributeValue::Text(byte_text(host)))));
        }
        attributes.other.extend(own.into_iter().map(|(name, value)| (byte_text(name), value)));
        attributes
    }
}

/// Text of an attribute. OpenEXR's texts are bytes; other programs write UTF-8, too.
pub(super) fn byte_text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

fn exr_time_code([hours, minutes, seconds, frame]: [u8; 4]) -> TimeCode {
    TimeCode {
        hours,
        minutes,
        seconds,
        frame,
        drop_frame: false,
        color_frame: false,
        field_phase: false,
        binary_group_flags: [false; 3],
        binary_groups: [0; 8],
    }
}
