//! Clipping of triangles by planes (Sutherland and Hodgman 1974), in `f64`, with boxes rounded outward.

use glam::{DVec3, Vec3};

use rayframe::geometry::{Aabb, Triangle};

/// What remains of a triangle after cuts.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    corners: Vec<DVec3>,
    bounds: Aabb,
}

impl Part {
    /// The whole triangle.
    pub(crate) fn whole(triangle: &Triangle) -> Self {
        Self {
            corners: triangle.vertices.iter().map(|vertex| vertex.as_dvec3()).collect(),
            bounds: triangle.bounds(),
        }
    }

    /// The tight box.
    pub(crate) fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// The surface area.
    pub(crate) fn area(&self) -> f64 {
        let Some((&first, rest)) = self.corners.split_first() else { return 0.0 };
        let fan = rest.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first));
        fan.fold(DVec3::ZERO, |sum, normal| sum + normal).length() * 0.5
    }

    /// The parts below and above a plane. Corners on it belong to both.
    pub(crate) fn cut(&self, axis: usize, plane: f32) -> [Option<Self>; 2] {
        let height = |corner: DVec3| corner[axis] - f64::from(plane);
        let (mut below, mut above) = (Vec::new(), Vec::new());
        for (index, &from) in self.corners.iter().enumerate() {
            let to = self.corners[(index + 1) % self.corners.len()];
            let (from_height, to_height) = (height(from), height(to));
            if from_height <= 0.0 {
                below.push(from);
            }
            if from_height >= 0.0 {
                above.push(from);
            }
            if from_height * to_height < 0.0 {
                let mut corner = from + (to - from) * (from_height / (from_height - to_height));
                corner[axis] = f64::from(plane);
                below.push(corner);
                above.push(corner);
            }
        }
        let (mut low, mut high) = (self.bounds, self.bounds);
        low.max[axis] = plane;
        high.min[axis] = plane;
        [Self::within(below, &low), Self::within(above, &high)]
    }

    /// The part inside a box; `None` where there is none.
    pub(crate) fn inside(mut self, bounds: &Aabb) -> Option<Self> {
        for axis in 0..3 {
            if self.bounds.min[axis] < bounds.min[axis] {
                let [_, above] = self.cut(axis, bounds.min[axis]);
                self = above?;
            }
            if self.bounds.max[axis] > bounds.max[axis] {
                let [below, _] = self.cut(axis, bounds.max[axis]);
                self = below?;
            }
        }
        Some(self)
    }

    fn within(corners: Vec<DVec3>, region: &Aabb) -> Option<Self> {
        let &first = corners.first()?;
        let (min, max) =
            corners.iter().fold((first, first), |(min, max), &corner| (min.min(corner), max.max(corner)));
        let bounds = Aabb {
            min: rounded(min, f32::next_down, |near, exact| near > exact).max(region.min),
            max: rounded(max, f32::next_up, |near, exact| near < exact).min(region.max),
        };
        (!bounds.is_empty()).then_some(Self { corners, bounds })
    }
}

/// The nearest `f32`s, moved by one where they lie on the wrong side.
fn rounded(exact: DVec3, next: fn(f32) -> f32, is_wrong: fn(f64, f64) -> bool) -> Vec3 {
    let component = |exact: f64| {
        let near = exact as f32;
        if is_wrong(f64::from(near), exact) { next(near) } else { near }
    };
    Vec3::new(component(exact.x), component(exact.y), component(exact.z))
}
