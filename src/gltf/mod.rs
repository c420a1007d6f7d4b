//! gltf.
