//! Probes in one mip level: the texels around each by wrapping, and their weights by nearest or linear filtering.

use glam::Vec2;

use crate::scene::{Filter, Sampler, WrapMode};

/// Evenly spaced probes along a line of the texture.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeLine {
    /// Texture coordinates of the line's centre.
    pub(super) center: Vec2,
    /// Vector from one end to the other.
    pub(super) along: Vec2,
    /// Number of probes, at least one.
    pub(super) count: u32,
}

impl ProbeLine {
    /// The first probe and the step to the next.
    fn start_and_step(&self) -> (Vec2, Vec2) {
        let step = self.along / self.count as f32;
        (self.center - step * (0.5 * (self.count - 1) as f32), step)
    }
}

/// Fraction bits of the fixed-point positions in [`LevelLookup`].
const FRACTION_BITS: u32 = 24;

/// The texels around a probe and their weights. The nearest texel alone is the first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WeightedTexels {
    /// Indices in the row-major level: upper left, upper right, lower left, lower right.
    pub(super) texels: [usize; 4],
    /// Their sum is one.
    pub(super) weights: [f32; 4],
}

/// The probes of a line in one level. Positions are fixed-point texels; those beyond 2³⁸ texels saturate.
#[derive(Clone, Copy, Debug)]
pub(super) struct LevelLookup {
    /// Position of the first probe: from the centre of the first texel for linear filtering, from its edge for nearest.
    start: [i64; 2],
    step: [i64; 2],
    columns: Axis,
    rows: Axis,
    is_linear: bool,
}

/// Size and wrap mode of one axis of a level.
#[derive(Clone, Copy, Debug)]
struct Axis {
    mode: WrapMode,
    size: u32,
}

impl Axis {
    /// Bit mask of positions, where the axis repeats after a power of two.
    fn mask(self) -> Option<i64> {
        (self.mode == WrapMode::Repeat && self.size.is_power_of_two()).then(|| i64::from(self.size) - 1)
    }

    fn wrap(self, position: i64) -> usize {
        wrap(self.mode, position, self.size) as usize
    }
}

impl LevelLookup {
    #[inline(always)]
    pub(super) fn new([width, height]: [u32; 2], line: &ProbeLine, sampler: Sampler, filter: Filter) -> Self {
        let (start, step) = line.start_and_step();
        let is_linear = filter == Filter::Linear;
        let shift = if is_linear { 0.5 } else { 0.0 };
        // Casts saturate, and map NaN to zero.
        let fixed = |texels: f64| (texels * f64::from(1 << FRACTION_BITS)) as i64;
        let position = |at: f32, side: u32| fixed(f64::from(at) * f64::from(side) - shift);
        let stride = |step: f32, side: u32| fixed(f64::from(step) * f64::from(side));
        Self {
            start: [position(start.x, width), position(start.y, height)],
            step: [stride(step.x, width), stride(step.y, height)],
            columns: Axis { mode: sampler.wrap_u, size: width },
            rows: Axis { mode: sampler.wrap_v, size: height },
            is_linear,
        }
    }

    pub(super) fn is_linear(&self) -> bool {
        self.is_linear
    }

    /// Writes the texels and weights of the first probes.
    #[inline(always)]
    pub(super) fn fill(&self, probes: &mut [WeightedTexels]) {
        if !self.is_linear {
            self.fill_nearest(probes);
        } else if let (Some(across), Some(down)) = (self.columns.mask(), self.rows.mask()) {
            self.fill_linear(probes, |[x, y]| [(x & across) as usize, (y & down) as usize]);
        } else {
            self.fill_linear(probes, |[x, y]| [self.columns.wrap(x), self.rows.wrap(y)]);
        }
    }

    #[inline(always)]
    fn fill_linear(&self, probes: &mut [WeightedTexels], wrap: impl Fn([i64; 2]) -> [usize; 2]) {
        const FRACTION: i64 = (1 << FRACTION_BITS) - 1;
        let fraction =
            |position: i64| (position & FRACTION) as i32 as f32 * (1.0 / (1 << FRACTION_BITS) as f32);
        let stride = self.columns.size as usize;
        let [mut x, mut y] = self.start;
        for probe in probes {
            let (column, row) = (x >> FRACTION_BITS, y >> FRACTION_BITS);
            let ([left, upper], [right, lower]) = (wrap([column, row]), wrap([column + 1, row + 1]));
            let (right_share, lower_share) = (fraction(x), fraction(y));
            let (left_share, upper_share) = (1.0 - right_share, 1.0 - lower_share);
            let (upper, lower) = (upper * stride, lower * stride);
            probe.texels = [upper + left, upper + right, lower + left, lower + right];
            probe.weights = [
                left_share * upper_share,
                right_share * upper_share,
                left_share * lower_share,
                right_share * lower_share,
            ];
            x = x.wrapping_add(self.step[0]);
            y = y.wrapping_add(self.step[1]);
        }
    }

    fn fill_nearest(&self, probes: &mut [WeightedTexels]) {
        let [mut x, mut y] = self.start;
        for probe in probes {
            let row = self.rows.wrap(y >> FRACTION_BITS) * self.columns.size as usize;
            probe.texels[0] = row + self.columns.wrap(x >> FRACTION_BITS);
            x = x.wrapping_add(self.step[0]);
            y = y.wrapping_add(self.step[1]);
        }
    }
}

/// Index of the texel at integer coordinate `position`, which may lie outside the image.
pub(super) fn wrap(mode: WrapMode, position: i64, size: u32) -> u32 {
    let size = i64::from(size);
    if (0..size).contains(&position) {
        return position as u32;
    }
    let wrapped = match mode {
        WrapMode::Repeat => modulo(position, size),
        WrapMode::MirroredRepeat => {
            let folded = modulo(position, 2 * size);
            if folded < size { folded } else { 2 * size - 1 - folded }
        }
        WrapMode::ClampToEdge => position.clamp(0, size - 1),
    };
    wrapped as u32
}

/// The non-negative remainder, without a division for powers of two.
fn modulo(position: i64, size: i64) -> i64 {
    if size & (size - 1) == 0 { position & (size - 1) } else { position.rem_euclid(size) }
}
