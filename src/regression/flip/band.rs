//! FLIP of a band of rows: from the colours of both images to the error of each pixel.
//!
//! Source: Andersson et al. 2020, sections 4.1 to 4.4, with the constants of its table 1.

use super::color::{hunt_lab_from_linear, hyab, linear_from_opponent, opponent_from_linear};
use super::kernels::Kernels;

/// Exponent of the colour difference.
const Q_C: f32 = 0.7;
/// Share of the largest colour difference that is mapped to [0, `P_T`].
const P_C: f32 = 0.4;
/// Range of the result over which that share is spread.
const P_T: f32 = 0.95;
/// Exponent of the feature difference.
const Q_F: f32 = 0.5;

/// Rows of one image in the opponent space, with margins of the filter radius above and below. The outermost rows of the image repeat.
pub(super) struct Band {
    /// Lightness, red–green, blue–yellow.
    planes: [Vec<f32>; 3],
}

/// The filtered planes of a band.
struct Filtered {
    /// Colours, blurred by the contrast sensitivity functions.
    colors: [Vec<f32>; 3],
    /// Strength of edges.
    edges: Vec<f32>,
    /// Strength of points.
    points: Vec<f32>,
}

/// The rows whose errors are computed.
#[derive(Clone, Copy)]
pub(super) struct Rows {
    /// Width of the image.
    pub(super) width: usize,
    /// Height of the image.
    pub(super) height: usize,
    /// First row.
    pub(super) first: usize,
    /// Number of rows.
    pub(super) count: usize,
}

impl Band {
    /// The band around `rows`. `color` gives the linear colour of the pixel at an index.
    pub(super) fn new(rows: Rows, radius: usize, color: impl Fn(usize) -> [f32; 3]) -> Self {
        let count = (rows.count + 2 * radius) * rows.width;
        let mut planes = [0; 3].map(|_| Vec::with_capacity(count));
        for row in 0..rows.count + 2 * radius {
            let y = (rows.first + row).saturating_sub(radius).min(rows.height - 1);
            for index in y * rows.width..(y + 1) * rows.width {
                let opponent = opponent_from_linear(color(index));
                for (plane, value) in planes.iter_mut().zip(opponent) {
                    plane.push(value);
                }
            }
        }
        Self { planes }
    }

    fn filtered(&self, rows: Rows, kernels: &Kernels) -> Filtered {
        let width = rows.width;
        let [lightness, red_green, blue_yellow] = &self.planes;
        let both = |plane: &[f32], across: &[f32], down: &[f32]| {
            filter_columns(&filter_rows(plane, width, across), width, down)
        };
        let [narrow, wide] = &kernels.blue_yellow;
        let mut last = both(blue_yellow, narrow, narrow);
        add(&mut last, &both(blue_yellow, wide, wide));
        let colors = [
            both(lightness, &kernels.lightness, &kernels.lightness),
            both(red_green, &kernels.red_green, &kernels.red_green),
            last,
        ];
        // Features are detected in lightness between 0 and 1.
        let light: Vec<f32> = lightness.iter().map(|value| (value + 16.0) / 116.0).collect();
        let smooth = filter_rows(&light, width, &kernels.bell);
        let strength = |derivative: &[f32]| {
            let across = filter_columns(&filter_rows(&light, width, derivative), width, &kernels.bell);
            let down = filter_columns(&smooth, width, derivative);
            across.iter().zip(&down).map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Filtered { colors, edges: strength(&kernels.slope), points: strength(&kernels.bend) }
    }
}

/// The errors of the pixels of `rows`, between 0 and 1.
pub(super) fn errors(reference: &Band, test: &Band, rows: Rows, kernels: &Kernels) -> Vec<f32> {
    let (ours, theirs) = (test.filtered(rows, kernels), reference.filtered(rows, kernels));
    let largest =
        libm::powf(hyab(hunt_lab_from_linear([0.0, 1.0, 0.0]), hunt_lab_from_linear([0.0, 0.0, 1.0])), Q_C);
    let error = |at: usize| {
        let lab = |filtered: &Filtered| {
            let [lightness, red_green, blue_yellow] = &filtered.colors;
            hunt_lab_from_linear(linear_from_opponent([lightness[at], red_green[at], blue_yellow[at]]))
        };
        let color = redistributed(libm::powf(hyab(lab(&theirs), lab(&ours)), Q_C), largest);
        let edge = (theirs.edges[at] - ours.edges[at]).abs();
        let point = (theirs.points[at] - ours.points[at]).abs();
        let strongest = if edge > point { edge } else { point };
        let feature = libm::powf(std::f32::consts::FRAC_1_SQRT_2 * strongest, Q_F);
        libm::powf(color, 1.0 - feature)
    };
    (0..rows.width * rows.count).map(error).collect()
}

/// Compresses large colour differences into a small part of the range, because all of them look large.
fn redistributed(difference: f32, largest: f32) -> f32 {
    let bend = P_C * largest;
    if difference < bend {
        difference * P_T / bend
    } else {
        P_T + (difference - bend) / (largest - bend) * (1.0 - P_T)
    }
}

/// Filters along rows. The first and last values repeat beyond the row.
fn filter_rows(plane: &[f32], width: usize, kernel: &[f32]) -> Vec<f32> {
    let radius = kernel.len() / 2;
    let mut filtered = vec![0.0; plane.len()];
    let mut padded = vec![0.0; width + 2 * radius];
    for (row, out) in plane.chunks_exact(width).zip(filtered.chunks_exact_mut(width)) {
        padded[..radius].fill(row[0]);
        padded[radius..radius + width].copy_from_slice(row);
        padded[radius + width..].fill(row[width - 1]);
        for (weight, values) in kernel.iter().zip(padded.windows(width)) {
            if *weight != 0.0 {
                for (sum, value) in out.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
    }
    filtered
}

/// Filters along columns. The result has no margins.
fn filter_columns(plane: &[f32], width: usize, kernel: &[f32]) -> Vec<f32> {
    let mut filtered = vec![0.0; plane.len() - (kernel.len() - 1) * width];
    for (y, out) in filtered.chunks_exact_mut(width).enumerate() {
        for (weight, values) in kernel.iter().zip(plane[y * width..].chunks_exact(width)) {
            if *weight != 0.0 {
                for (sum, value) in out.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
        }
    }
    filtered
}

fn add(sum: &mut [f32], plane: &[f32]) {
    for (sum, value) in sum.iter_mut().zip(plane) {
        *sum += value;
    }
}
