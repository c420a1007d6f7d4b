//! Curves through keys.
//!
//! A smooth point follows the centripetal Catmull–Rom spline through the keys (E. Catmull, R. Rom, "A Class of Local Interpolating
//! Splines", 1974; C. Yuksel, S. Schaefer, J. Keyser, "Parameterization and Applications of Catmull-Rom Curves", 2011), which has
//! neither cusps nor self-intersections between two keys. Its parameter is a monotone cubic of time (F. Fritsch, J. Butland, "A Method for
//! Constructing Local Monotone Piecewise Cubic Interpolants", 1984), as single values are: the point passes each key at its time, never
//! runs backwards, and its velocity is continuous.

/// How values between two keys are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CurveKind {
    /// Continuous velocity.
    #[default]
    Smooth,
    /// Constant velocity between two keys.
    Linear,
}

/// Times of keys, increasing. There is at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyTimes {
    /// Seconds.
    pub seconds: Vec<f64>,
    /// Seconds after which the first key comes again; `None` where the ends are held.
    pub period: Option<f64>,
}

/// A number over time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedValue {
    times: KeyTimes,
    kind: CurveKind,
    values: Vec<f64>,
    /// Change a second at each key.
    slopes: Vec<f64>,
}

/// A point over time.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyedPoint {
    points: Vec<[f64; 3]>,
    /// Change of the point along the parameter at each key.
    tangents: Vec<[f64; 3]>,
    /// Position on the knots over time.
    parameter: KeyedValue,
}

impl KeyedPoint {
    /// Time of the first key, seconds.
    pub fn start_seconds(&self) -> f64 {
        self.parameter.times.seconds[0]
    }
}

impl KeyTimes {
    /// Number of stretches between keys.
    fn stretches(&self) -> usize {
        self.seconds.len() - usize::from(self.period.is_none())
    }

    /// Length of a stretch, seconds.
    fn length(&self, stretch: usize) -> f64 {
        match (self.seconds.get(stretch + 1), self.period) {
            (Some(next), _) => next - self.seconds[stretch],
            (None, Some(period)) => self.seconds[0] + period - self.seconds[stretch],
            (None, None) => 0.0,
        }
    }

    /// The stretch of a time, and the share of it that has passed.
    fn find(&self, seconds: f64) -> (usize, f64) {
        let first = self.seconds[0];
        let seconds = match self.period {
            Some(period) => first + (seconds - first).rem_euclid(period),
            None => seconds.clamp(first, self.seconds[self.seconds.len() - 1]),
        };
        let after = self.seconds.partition_point(|&key| key <= seconds);
        let stretch = after.saturating_sub(1).min(self.stretches().saturating_sub(1));
        let length = self.length(stretch);
        let share = if length > 0.0 { (seconds - self.seconds[stretch]) / length } else { 0.0 };
        (stretch, share.clamp(0.0, 1.0))
    }
}

impl KeyedValue {
    /// A number that has `values` at `times`. A loop comes back to the first value.
    pub fn new(times: KeyTimes, kind: CurveKind, values: Vec<f64>) -> Self {
        Self::rising(times, kind, values, 0.0)
    }

    /// The same for a number that is greater by `rise` after each period.
    fn rising(times: KeyTimes, kind: CurveKind, mut values: Vec<f64>, rise: f64) -> Self {
        if times.period.is_some() {
            values.push(values[0] + rise);
        }
        let secants: Vec<f64> = (0..times.stretches())
            .map(|stretch| (values[stretch + 1] - values[stretch]) / times.length(stretch))
            .collect();
        let slopes = (0..=times.stretches()).map(|key| {
            let (before, after) = around(&times, key);
            match (before, after) {
                (Some(before), Some(after)) => monotone_slope(
                    (times.length(before), secants[before]),
                    (times.length(after), secants[after]),
                ),
                (Some(only), None) | (None, Some(only)) => secants[only],
                (None, None) => 0.0,
            }
        });
        let slopes = slopes.collect();
        Self { times, kind, values, slopes }
    }

    /// The number at a time.
    pub fn at(&self, seconds: f64) -> f64 {
        let (stretch, share) = self.times.find(seconds);
        self.within(stretch, share)
    }

    fn within(&self, stretch: usize, share: f64) -> f64 {
        let from = self.values[stretch];
        let Some(&to) = self.values.get(stretch + 1) else { return from };
        match self.kind {
            CurveKind::Linear => from + (to - from) * share,
            CurveKind::Smooth => {
                let length = self.times.length(stretch);
                let slopes = (self.slopes[stretch] * length, self.slopes[stretch + 1] * length);
                hermite((from, to), slopes, share)
            }
        }
    }
}

impl KeyedPoint {
    /// A point that is at `points` at `times`. A loop comes back to the first point.
    pub fn new(times: KeyTimes, kind: CurveKind, mut points: Vec<[f64; 3]>) -> Self {
        if times.period.is_some() {
            points.push(points[0]);
        }
        // Knots are as far apart as the square roots of distances.
        let gaps: Vec<f64> = points.windows(2).map(|pair| distance(pair[0], pair[1]).sqrt()).collect();
        let tangents = (0..points.len()).map(|key| {
            let (before, after) = around(&times, key);
            let moving = |stretch: &usize| gaps[*stretch] > 0.0;
            let secant = |stretch: usize, axis: usize| {
                (points[stretch + 1][axis] - points[stretch][axis]) / gaps[stretch]
            };
            match (before.filter(moving), after.filter(moving)) {
                (Some(before), Some(after)) => [0, 1, 2].map(|axis| {
                    let (d, e) = (gaps[before], gaps[after]);
                    (secant(before, axis) * e + secant(after, axis) * d) / (d + e)
                }),
                (Some(only), None) | (None, Some(only)) => [0, 1, 2].map(|axis| secant(only, axis)),
                (None, None) => [0.0; 3],
            }
        });
        let tangents = tangents.collect();
        let mut knots = vec![0.0];
        for gap in &gaps {
            knots.push(knots[knots.len() - 1] + gap);
        }
        let whole = knots[knots.len() - 1];
        knots.truncate(times.seconds.len());
        let parameter = KeyedValue::rising(times, kind, knots, whole);
        Self { points, tangents, parameter }
    }

    /// The point at a time.
    pub fn at(&self, seconds: f64) -> [f64; 3] {
        let (stretch, share) = self.parameter.times.find(seconds);
        let from = self.points[stretch];
        let Some(&to) = self.points.get(stretch + 1) else { return from };
        let axes = [0, 1, 2];
        if self.parameter.kind == CurveKind::Linear {
            return axes.map(|axis| from[axis] + (to[axis] - from[axis]) * share);
        }
        let knots = (self.parameter.values[stretch], self.parameter.values[stretch + 1]);
        let gap = knots.1 - knots.0;
        if gap <= 0.0 {
            return from;
        }
        let along = ((self.parameter.within(stretch, share) - knots.0) / gap).clamp(0.0, 1.0);
        axes.map(|axis| {
            let slopes = (self.tangents[stretch][axis] * gap, self.tangents[stretch + 1][axis] * gap);
            hermite((from[axis], to[axis]), slopes, along)
        })
    }
}

/// The stretches before and after a key. Key 0 of a loop comes again behind the last one.
fn around(times: &KeyTimes, key: usize) -> (Option<usize>, Option<usize>) {
    let stretches = times.stretches();
    if times.period.is_some() {
        return (Some((key + stretches - 1) % stretches), Some(key % stretches));
    }
    (key.checked_sub(1), (key < stretches).then_some(key))
}

/// Slope between two stretches, each with its length and secant: their weighted harmonic mean, 0 at an extreme (Fritsch and Butland,
/// equation 5).
fn monotone_slope((length_a, a): (f64, f64), (length_b, b): (f64, f64)) -> f64 {
    if a * b <= 0.0 {
        return 0.0;
    }
    let (weight_a, weight_b) = (2.0 * length_b + length_a, length_b + 2.0 * length_a);
    (weight_a + weight_b) / (weight_a / a + weight_b / b)
}

/// Cubic Hermite interpolation over a unit interval.
fn hermite((from, to): (f64, f64), (slope_from, slope_to): (f64, f64), share: f64) -> f64 {
    let rest = 1.0 - share;
    let ease = share * share * (3.0 - 2.0 * share);
    from + (to - from) * ease + share * rest * (slope_from * rest - slope_to * share)
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    [0, 1, 2].map(|axis| (a[axis] - b[axis]) * (a[axis] - b[axis])).iter().sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests;
