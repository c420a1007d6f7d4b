//! Random triangles and bars in a cube.

use glam::Vec3;
use rayframe::geometry::Triangle;

/// Triangles of a box.
const BOX_TRIANGLES: usize = 12;
/// Half the length and thickness of a bar.
const BAR: (f32, f32) = (0.7, 0.004);

/// `size` triangles with random corners near random points of a cube around the origin.
pub(super) fn soup(size: usize) -> Vec<Triangle> {
    let mut random = Random(1);
    // A cube of two metres, divided evenly among the triangles.
    let reach = libm::cbrtf(8.0 / size.max(1) as f32);
    let triangle = |_| {
        let middle = random.in_cube();
        Triangle { vertices: [(); 3].map(|()| middle + random.in_cube() * reach) }
    };
    (0..size).map(triangle).collect()
}

/// About `size` triangles as long bars around random points of a cube, in random directions.
pub(super) fn bars(size: usize) -> Vec<Triangle> {
    let mut random = Random(2);
    (0..size.div_ceil(BOX_TRIANGLES)).flat_map(|_| bar(random.in_cube(), random.in_cube())).collect()
}

fn bar(middle: Vec3, direction: Vec3) -> [Triangle; BOX_TRIANGLES] {
    let along = direction.normalize_or(Vec3::X);
    let (side, up) = along.any_orthonormal_pair();
    let (length, thickness) = BAR;
    let axes = [along * length, side * thickness, up * thickness];
    // Bit i of a corner's index is its side along axis i.
    let corner = |number: usize| {
        (0..3).fold(
            middle,
            |sum, axis| if number >> axis & 1 == 0 { sum - axes[axis] } else { sum + axes[axis] },
        )
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    std::array::from_fn(|i| {
        let [a, b, c, d] = quads[i / 2].map(corner);
        Triangle { vertices: if i % 2 == 0 { [a, b, c] } else { [a, c, d] } }
    })
}

/// Random numbers: Marsaglia, "Xorshift RNGs", 2003. The state is never zero.
struct Random(u32);

impl Random {
    /// Point with coordinates from −1 to 1.
    fn in_cube(&mut self) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 17;
            self.0 ^= self.0 << 5;
            (self.0 >> 8) as f32 / (1 << 23) as f32 - 1.0
        }))
    }
}
