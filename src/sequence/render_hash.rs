//! What a frame was made from, in one number: equal exactly when the picture is meant to be the same.
//!
//! Covers the version, the content of the scene and of the environment, what is shown of it, every setting that reaches
//! a pixel, the layers of the files, their types and how they are packed, and the time. Not covered: threads, lanes, builder, splits, crop, other frames, names, stamps and progress, none of
//! which change a pixel. A tone-mapped file also depends on its look and, having no data window, on the crop.

use serde_json::json;
use sha2::{Digest as _, Sha256};

use crate::output::{ExrOutput, SOFTWARE};
use crate::render::{Aperture, Focus, GlassShadows};
use crate::scene::{Scene, SelectedCamera, VariantIndex};

use super::{Exposure, OutputFormat, SequenceJob};

/// The hash of `frame`, 64 hexadecimal digits.
pub fn render_hash(job: &SequenceJob, frame: i64) -> String {
    let settings = &job.render;
    let camera = match job.selection.camera {
        SelectedCamera::Auto => "auto".to_owned(),
        SelectedCamera::Node(node) => format!("node {}", node.0),
        SelectedCamera::Fixed { world_from_camera, projection } => {
            let bits = world_from_camera.to_cols_array().map(f32::to_bits);
            format!("fixed {bits:x?} {projection:?}")
        }
    };
    let glass_shadows = match settings.glass_shadows {
        GlassShadows::Straight => "straight",
        GlassShadows::Opaque => "opaque",
    };
    let indices = |list: Vec<u32>| json!(list);
    // Keys are sorted when printed and floats are given by their bits: one value has one text.
    let content = json!({
        "software": SOFTWARE,
        "scene": hex(&job.scene.content_hash),
        "roots": indices(job.selection.roots.iter().map(|root| root.0).collect()),
        "clips": indices(job.selection.clips.iter().map(|clip| clip.0).collect()),
        "camera": camera,
        "variant": job.selection.variant.map(|variant| variant.0),
        "environment": job.environment_key,
        "shadow_catchers": shadow_catchers(&job.scene, job.selection.variant),
        "integrator": "whitted",
        "resolution": [settings.resolution.0, settings.resolution.1],
        "samples": settings.samples,
        "max_depth": settings.max_depth,
        "glass_shadows": glass_shadows,
        "light_scale": settings.light_scale.to_bits(),
        "show_background": settings.show_background,
        "sampling": sampling_key(job),
        "fps": job.rate.to_string(),
        "frame": frame,
        "file": file_key(job),
    });
    hex(&Sha256::digest(content.to_string().as_bytes()))
}

/// Nodes, and which primitives of theirs only catch shadows as they look in `variant`.
fn shadow_catchers(scene: &Scene, variant: Option<VariantIndex>) -> Vec<[usize; 2]> {
    let mut catchers = Vec::new();
    for (index, node) in scene.nodes.iter().enumerate() {
        let mesh = node.mesh.and_then(|mesh| scene.meshes.get(mesh.index()));
        let primitives = mesh.into_iter().flat_map(|mesh| &mesh.primitives).enumerate();
        catchers.extend(
            primitives
                .filter(|(_, primitive)| {
                    let material = scene.materials.get(primitive.material_in(variant).index());
                    material.is_some_and(|material| material.is_shadow_catcher)
                })
                .map(|(primitive, _)| [index, primitive]),
        );
    }
    catchers
}

/// Floats are given by their bits.
fn sampling_key(job: &SequenceJob) -> serde_json::Value {
    let settings = &job.render;
    json!({
        "filter": settings.filter.name(),
        "adaptive": settings.adaptive.map(|adaptive| json!([adaptive.max_samples, adaptive.threshold.to_bits()])),
        "lens": settings.lens.map(|lens| {
            let aperture = match lens.aperture {
                Aperture::Radius(radius) => json!({ "radius": radius.to_bits() }),
                Aperture::FNumber(number) => json!({ "f_number": number.to_bits() }),
            };
            let focus = match lens.focus {
                Focus::Metres(distance) => json!(distance.to_bits()),
                Focus::Node(node) => json!({ "node": node.0 }),
                Focus::Center => json!("middle"),
            };
            json!([aperture, focus])
        }),
        "glossy": settings.glossy_samples,
        "light_radius": settings.light_size.radius.to_bits(),
        "sun_angle": settings.light_size.sun_angle_radians.to_bits(),
        "shutter": (job.shutter.open.to_bits(), job.shutter.time_samples),
    })
}

/// A stamp tells of the run, not of the picture: files that differ in nothing else are the same frame.
fn same_but_for_stamp(a: &ExrOutput, b: &ExrOutput) -> bool {
    ExrOutput { is_stamped: b.is_stamped, ..a.clone() } == *b
}

fn file_key(job: &SequenceJob) -> serde_json::Value {
    match job.output.format() {
        // The usual file keeps the name that it had before there were others.
        OutputFormat::Exr if same_but_for_stamp(&job.exr, &ExrOutput::default()) => json!("exr rgba half"),
        OutputFormat::Exr => json!({
            "layers": job.exr.aovs.as_slice().iter().map(|layer| layer.name()).collect::<Vec<_>>(),
            "samples": job.exr.samples.name(),
            "compression": job.exr.compression.name(),
            "split": job.exr.is_split,
        }),
        OutputFormat::Png => {
            let window = job.render.window;
            let exposure = match job.exposure {
                Exposure::Auto => json!("auto"),
                Exposure::Ev(ev) => json!(ev.to_bits()),
            };
            json!({
                "png": job.tone.name(),
                "exposure": exposure,
                "crop": [window.x0, window.y0, window.x1, window.y1],
            })
        }
    }
}

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]).map(|digit| DIGITS[digit as usize] as char).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, MaterialIndex, Mesh, MeshIndex, Node, Primitive};

    #[test]
    fn catchers_are_those_of_the_variant() {
        let primitive = Primitive {
            material: MaterialIndex(0),
            variants: vec![(VariantIndex(1), MaterialIndex(1))],
            ..Primitive::default()
        };
        let catcher = Material { is_shadow_catcher: true, ..Material::default() };
        let scene = Scene {
            materials: vec![Material::default(), catcher],
            meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }],
            nodes: vec![Node::default(), Node { mesh: Some(MeshIndex(0)), ..Node::default() }],
            ..Scene::default()
        };
        assert!(
            shadow_catchers(&scene, None).is_empty()
                && shadow_catchers(&scene, Some(VariantIndex(0))).is_empty()
        );
        assert_eq!(shadow_catchers(&scene, Some(VariantIndex(1))), [[1, 0]]);
    }
}
