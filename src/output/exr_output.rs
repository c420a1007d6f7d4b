//! Selection of AOVs, sample type and compression of a frame's EXR files.

use crate::film::AovFlags;
use crate::image_file::ExrCompression;

use super::{Aov, AovSet};

/// Sample type of colour and light passes; data AOVs always have 32 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSamples {
    /// 16 bits; values beyond ±65504 become ±65504.
    #[default]
    Half,
    /// 32 bits.
    Float,
}

impl LightSamples {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Half => "half",
            Self::Float => "float",
        }
    }
}

/// Content and format of a frame's EXR files. The default is one file of R, G, B and A as halves with ZIP compression.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExrOutput {
    /// AOVs.
    pub aovs: AovSet,
    /// Sample type of light.
    pub samples: LightSamples,
    /// Compression.
    pub compression: ExrCompression,
    /// Whether each AOV besides [`Aov::Beauty`] has a file of its own.
    pub is_split: bool,
    /// Whether files store when and where they were rendered.
    pub is_stamped: bool,
    /// Whether files list the content of the scene, as references do ([`SceneContent`](crate::image::SceneContent)).
    pub lists_content: bool,
}

impl ExrOutput {
    /// Why these AOVs cannot be stored in this format; `None` when they can.
    pub fn contradiction(&self) -> Option<String> {
        let data = self.aovs.as_slice().iter().find(|aov| !aov.is_light())?;
        (self.compression.is_lossy() && !self.is_split).then(|| {
            format!(
                "{} loses precision, which would corrupt the AOV {}; add `split_aovs` for files of their own, or choose \
                 a lossless compression such as zip or piz",
                self.compression.name(),
                data.name()
            )
        })
    }

    /// AOVs that the film records.
    pub fn aov_flags(&self) -> AovFlags {
        self.aovs.flags()
    }

    /// AOVs of the frame's main file.
    pub fn main_aovs(&self) -> &[Aov] {
        if self.is_split { &[Aov::Beauty] } else { self.aovs.as_slice() }
    }

    /// The AOVs with files of their own, in the order of the files.
    pub fn split_aovs(&self) -> &[Aov] {
        match (self.is_split, self.aovs.as_slice()) {
            (true, [_, others @ ..]) => others,
            _ => &[],
        }
    }

    /// Compression of a file of these AOVs: ZIP for data where the chosen compression is lossy.
    pub fn compression_of(&self, aovs: &[Aov]) -> ExrCompression {
        let may_lose = aovs.iter().all(|aov| aov.is_light());
        if self.compression.is_lossy() && !may_lose { ExrCompression::Zip } else { self.compression }
    }

    /// Whether an AOV identifies surfaces by name or number.
    pub fn needs_instances(&self) -> bool {
        self.aovs.as_slice().iter().any(|aov| aov.needs_instances())
    }

    /// Most bytes a pixel over all channels.
    pub fn bytes_a_pixel(&self) -> u64 {
        self.aovs.as_slice().iter().map(|aov| aov.bytes_a_pixel()).sum()
    }

    /// Bytes a pixel over the channels of `aov` as they are stored, before compression.
    pub fn stored_bytes_a_pixel(&self, aov: Aov) -> u64 {
        let halves = aov.is_light() && self.samples == LightSamples::Half;
        aov.bytes_a_pixel() / if halves { 2 } else { 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LightPass;

    #[test]
    fn data_is_never_compressed_lossily() {
        let light = Aov::Light(LightPass::Direct);
        let output = |aovs: &[Aov], compression, is_split| ExrOutput {
            aovs: AovSet::new(aovs),
            compression,
            is_split,
            ..ExrOutput::default()
        };
        for aov in Aov::ALL.into_iter().filter(|aov| !aov.is_light()) {
            for compression in ExrCompression::ALL {
                let together = output(&[aov], compression, false);
                assert_eq!(together.contradiction().is_some(), compression.is_lossy());
                let split = output(&[light, aov], compression, true);
                assert_eq!(split.contradiction(), None);
                assert_eq!(split.split_aovs(), &AovSet::new(&[light, aov]).as_slice()[1..]);
                assert!(!split.compression_of(&[aov]).is_lossy());
                assert_eq!(split.compression_of(&[light]), compression);
                assert_eq!(split.compression_of(split.main_aovs()), compression);
            }
        }
        let text = output(&[light, Aov::NodeId], ExrCompression::Dwab, false).contradiction().unwrap();
        assert!(text.contains("`split_aovs`") && text.contains("node_id") && text.contains("dwab"), "{text}");
        assert_eq!(output(&[light], ExrCompression::Dwaa, false).contradiction(), None);
    }
}
