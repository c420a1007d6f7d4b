//! Weights of the two ways to find a light.

/// The power heuristic for one sample of each way (Veach 1997, equation 9.11, β = 2): the weight of the way with density `pdf`.
#[inline(always)]
pub(super) fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // Squares of densities overflow; their ratio does not.
    let ratio = other / pdf;
    if ratio.is_finite() { 1.0 / (1.0 + ratio * ratio) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_weights_sum_to_one() {
        for (a, b) in [(1.0_f32, 3.0), (1e-3, 1e3), (1e25, 1e24), (2.0, 0.0)] {
            assert!((power_heuristic(a, b) + power_heuristic(b, a) - 1.0).abs() < 1e-6, "{a} {b}");
        }
        assert_eq!(power_heuristic(1.0, 3.0), 0.1);
        assert_eq!(power_heuristic(1e-30, 1e30), 0.0);
        assert_eq!(power_heuristic(f32::INFINITY, 1e30), 1.0);
    }
}
