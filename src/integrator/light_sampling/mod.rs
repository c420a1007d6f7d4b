//! Temporary.
use glam::{Vec2, Vec3};
pub(crate) struct Emitter {
    pub corners: [Vec3; 3],
    pub power: f32,
    pub is_two_sided: bool,
}
#[derive(Clone, Debug)]
pub(crate) struct LightTree(Vec<f32>);
impl LightTree {
    pub(crate) fn new(emitters: &[Emitter]) -> Self {
        let _ = emitters.iter().map(|e| (e.corners, e.is_two_sided));
        let sum: f32 = emitters.iter().map(|e| e.power).sum();
        Self(emitters.iter().map(|e| e.power / sum).collect())
    }
    pub(crate) fn sample(&self, _p: Vec3, _n: Option<Vec3>, mut u: f32) -> Option<(u32, f32)> {
        for (i, p) in self.0.iter().enumerate() {
            if u < *p {
                return Some((i as u32, *p));
            }
            u -= p;
        }
        None
    }
    pub(crate) fn probability(&self, _p: Vec3, _n: Option<Vec3>, e: u32) -> f32 {
        self.0[e as usize]
    }
}
#[derive(Clone, Debug)]
pub(crate) struct EnvironmentDistribution;
impl EnvironmentDistribution {
    pub(crate) fn new(_rows: u32, _columns: u32, _radiance: impl Fn(Vec3) -> f32 + Sync) -> Self {
        Self
    }
    pub(crate) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let z = 1.0 - 2.0 * u.x;
        let r = libm::sqrtf((1.0 - z * z).abs());
        let (s, c) = libm::sincosf(u.y * std::f32::consts::TAU);
        Some((Vec3::new(r * c, z, r * s), 0.25 * std::f32::consts::FRAC_1_PI))
    }
    pub(crate) fn pdf(&self, _d: Vec3) -> f32 {
        0.25 * std::f32::consts::FRAC_1_PI
    }
}
pub(crate) mod triangle {
    use glam::{Vec2, Vec3};
    pub(crate) struct TriangleSample {
        pub barycentrics: [f32; 2],
        pub direction: Vec3,
        pub distance: f32,
        pub pdf: f32,
    }
    pub(crate) fn sample(c: [Vec3; 3], point: Vec3, u: Vec2) -> Option<TriangleSample> {
        let s = libm::sqrtf(u.x);
        let b = [s * (1.0 - u.y), s * u.y];
        let p = c[0] + (c[1] - c[0]) * b[0] + (c[2] - c[0]) * b[1];
        let d = p - point;
        let distance = d.length();
        let direction = d / distance;
        let pdf = pdf(c, point, direction, distance);
        (pdf > 0.0 && pdf.is_finite()).then_some(TriangleSample { barycentrics: b, direction, distance, pdf })
    }
    pub(crate) fn pdf(c: [Vec3; 3], _point: Vec3, direction: Vec3, distance: f32) -> f32 {
        let n = (c[1] - c[0]).cross(c[2] - c[0]);
        let area = 0.5 * n.length();
        let cos = n.normalize().dot(direction).abs();
        distance * distance / (area * cos)
    }
}
