//! Input files: scenes and rays as little-endian `f32`, cameras as text.
//!
//! * `scenes/NAME.tri`: nine numbers per triangle;
//! * `scenes/NAME.cam`: eye, target, up, vertical field of view in degrees, position of the light;
//! * `rays/NAME.SET.rays`: eight numbers per ray: origin, `t_min`, direction, `t_max`.

use std::path::Path;

use glam::Vec3;
use rayframe::geometry::{Ray, Triangle};

use crate::Result;
use peers::ray_set::RaySet;
use peers::soup::Soup;

/// Pinhole camera and point light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) eye: Vec3,
    pub(crate) target: Vec3,
    pub(crate) up: Vec3,
    pub(crate) fov_y_radians: f32,
    pub(crate) light: Vec3,
}

/// Scene with the rays that every tracer traces.
pub(crate) struct Subject {
    pub(crate) name: String,
    pub(crate) soup: Soup,
    pub(crate) view: View,
    /// Primary, shadow, reflect and diffuse; the first three are a frame.
    pub(crate) sets: Vec<RaySet>,
}

/// Sets that make up a frame.
pub(crate) const FRAME_SETS: usize = 3;

impl Subject {
    pub(crate) fn read(folder: &Path, name: &str) -> Result<Self> {
        let scene = |ending: &str| folder.join("scenes").join(format!("{name}.{ending}"));
        let rays = |set: &str| read_rays(&folder.join("rays").join(format!("{name}.{set}.rays")));
        let numbers = floats(&scene("tri"))?;
        let triangles = numbers
            .chunks_exact(9)
            .map(|corners| Triangle { vertices: [0, 3, 6].map(|first| Vec3::from_slice(&corners[first..])) });
        let view = View::read(&scene("cam"))?;
        let sets = vec![
            RaySet::closest("primary", rays("primary")?),
            RaySet::shadow(rays("shadow")?, view.light),
            RaySet::closest("reflect", rays("reflect")?),
            RaySet::closest("diffuse", rays("diffuse")?),
        ];
        Ok(Self { name: name.to_owned(), soup: Soup::new(triangles.collect()), view, sets })
    }
}

impl View {
    fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let numbers: Vec<f32> =
            text.split_whitespace().map(str::parse).collect::<std::result::Result<_, _>>()?;
        if numbers.len() != 13 {
            return Err(format!("{}: 13 numbers expected, not {}", path.display(), numbers.len()).into());
        }
        let point = |first: usize| Vec3::from_slice(&numbers[first..]);
        Ok(Self {
            eye: point(0),
            target: point(3),
            up: point(6),
            fov_y_radians: numbers[9].to_radians(),
            light: point(10),
        })
    }
}

fn read_rays(path: &Path) -> Result<Vec<Ray>> {
    let ray = |numbers: &[f32]| Ray {
        origin: Vec3::from_slice(numbers),
        t_min: numbers[3],
        direction: Vec3::from_slice(&numbers[4..]),
        t_max: numbers[7],
    };
    Ok(floats(path)?.chunks_exact(8).map(ray).collect())
}

fn floats(path: &Path) -> Result<Vec<f32>> {
    let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let (words, rest) = bytes.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(format!("{}: not a whole number of f32", path.display()).into());
    }
    Ok(words.iter().map(|word| f32::from_le_bytes(*word)).collect())
}
