//! Typed indices of the lists of a scene.

macro_rules! typed_index {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// Typed form of `index`. An index beyond 32 bits, which no file has, becomes one that no list has.
            pub fn of(index: usize) -> Self {
                Self(u32::try_from(index).unwrap_or(u32::MAX))
            }

            /// The index as `usize`.
            pub fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

typed_index!(
    /// Index of [`super::Scene::nodes`].
    NodeIndex
);
typed_index!(
    /// Index of [`super::Scene::meshes`].
    MeshIndex
);
typed_index!(
    /// Index of [`super::Scene::skins`].
    SkinIndex
);
typed_index!(
    /// Index of [`super::Scene::materials`].
    MaterialIndex
);
typed_index!(
    /// Index of [`super::Scene::variants`].
    VariantIndex
);
typed_index!(
    /// Index of [`super::Scene::textures`].
    TextureIndex
);
typed_index!(
    /// Index of [`super::Scene::images`].
    ImageIndex
);
typed_index!(
    /// Index of [`super::Scene::lights`].
    LightIndex
);
typed_index!(
    /// Index of [`super::Scene::image_lights`].
    ImageLightIndex
);
typed_index!(
    /// Index of [`super::Scene::cameras`].
    CameraIndex
);
typed_index!(
    /// Index of [`super::Scene::animations`].
    AnimationIndex
);
