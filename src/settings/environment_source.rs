//! Sources of environments.

use std::ffi::OsString;
use std::path::PathBuf;

/// Source of an environment.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum EnvironmentSource {
    /// No light.
    None,
    /// The built-in gradient and key light.
    Studio,
    /// Constant radiance, linear Rec.709.
    Constant([f32; 3]),
    /// Equirectangular image, rotated about +Y by degrees.
    File(PathBuf, f32),
}

impl EnvironmentSource {
    /// As the setting is written.
    pub fn to_text(&self) -> OsString {
        match self {
            Self::None => "none".into(),
            Self::Studio => "studio".into(),
            Self::Constant([r, g, b]) => format!("{r},{g},{b}").into(),
            Self::File(path, degrees) => {
                let mut text = path.clone().into_os_string();
                // Also where it is 0 and the name itself could be read as a rotation.
                if *degrees != 0.0 || path.to_string_lossy().contains('@') {
                    text.push(format!("@{degrees}"));
                }
                text
            }
        }
    }
}
