//! What goes into which EXR file of a frame, and how it is stored.

use crate::film::LayerRequest;
use crate::image_file::ExrCompression;

use super::{Layer, LayerSet};

/// Type of the samples of the picture and of the parts of its light; data is always 32 bits wide.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightSamples {
    /// 16 bits; values beyond ±65504 become ±65504.
    #[default]
    Half,
    /// 32 bits.
    Float,
}

impl LightSamples {
    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Half => "half",
            Self::Float => "float",
        }
    }
}

/// The EXR files of a frame. By default one file of R, G, B and A as halves, in ZIP.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExrOutput {
    /// What is stored.
    pub layers: LayerSet,
    /// Type of what is light.
    pub samples: LightSamples,
    /// How it is packed.
    pub compression: ExrCompression,
    /// Whether each layer besides the picture has a file of its own.
    pub is_split: bool,
    /// Whether files tell when and where they were made.
    pub is_stamped: bool,
}

impl ExrOutput {
    /// Why these layers cannot be stored like this; `None` when they can.
    pub fn contradiction(&self) -> Option<String> {
        let data = self.layers.layers().iter().find(|layer| !layer.is_light())?;
        (self.compression.is_lossy() && !self.is_split).then(|| {
            format!(
                "{} loses precision, which would spoil the layer {}; add --split-aovs for files of their own, or choose \
                 zip, piz or another that loses nothing",
                self.compression.name(),
                data.name()
            )
        })
    }

    /// What the film has to record.
    pub fn request(&self) -> LayerRequest {
        self.layers.request()
    }

    /// The layers of the frame's first file.
    pub fn main_layers(&self) -> &[Layer] {
        if self.is_split { &[Layer::Beauty] } else { self.layers.layers() }
    }

    /// The layers with files of their own, in the order of the files.
    pub fn split_layers(&self) -> &[Layer] {
        match (self.is_split, self.layers.layers()) {
            (true, [_, others @ ..]) => others,
            _ => &[],
        }
    }

    /// How a file of these layers is packed: data is in ZIP where the chosen way loses something.
    pub fn compression_of(&self, layers: &[Layer]) -> ExrCompression {
        let may_lose = layers.iter().all(|layer| layer.is_light());
        if self.compression.is_lossy() && !may_lose { ExrCompression::Zip } else { self.compression }
    }

    /// Whether names or numbers of surfaces are stored.
    pub fn needs_shapes(&self) -> bool {
        self.layers.layers().iter().any(|layer| layer.needs_shapes())
    }

    /// Most bytes that the channels of a pixel take while they are encoded.
    pub fn bytes_a_pixel(&self) -> u64 {
        self.layers.layers().iter().map(|layer| layer.bytes_a_pixel()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LightPart;

    #[test]
    fn data_is_never_packed_with_loss() {
        let light = Layer::Light(LightPart::Direct);
        let output = |layers: &[Layer], compression, is_split| ExrOutput {
            layers: LayerSet::new(layers),
            compression,
            is_split,
            ..ExrOutput::default()
        };
        for layer in Layer::ALL.into_iter().filter(|layer| !layer.is_light()) {
            for compression in ExrCompression::ALL {
                let together = output(&[layer], compression, false);
                assert_eq!(together.contradiction().is_some(), compression.is_lossy());
                let split = output(&[light, layer], compression, true);
                assert_eq!(split.contradiction(), None);
                assert_eq!(split.split_layers(), &LayerSet::new(&[light, layer]).layers()[1..]);
                assert!(!split.compression_of(&[layer]).is_lossy());
                assert_eq!(split.compression_of(&[light]), compression);
                assert_eq!(split.compression_of(split.main_layers()), compression);
            }
        }
        let text = output(&[light, Layer::NodeId], ExrCompression::Dwab, false).contradiction().unwrap();
        assert!(text.contains("--split-aovs") && text.contains("node_id") && text.contains("dwab"), "{text}");
        assert_eq!(output(&[light], ExrCompression::Dwaa, false).contradiction(), None);
    }
}
