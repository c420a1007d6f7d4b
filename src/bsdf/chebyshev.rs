//! Polynomial interpolation between Chebyshev nodes.

/// Nodes of an interval, lowest first.
pub(super) struct ChebyshevNodes<const N: usize> {
    /// Positions.
    pub(super) positions: [f32; N],
    /// Reciprocal products of each position's differences to the others.
    scales: [f32; N],
}

impl<const N: usize> ChebyshevNodes<N> {
    /// The nodes between `from` and `to`.
    pub(super) fn between(from: f32, to: f32) -> Self {
        let (center, half) = (0.5 * (from + to), 0.5 * (to - from));
        let positions: [f32; N] = std::array::from_fn(|step| {
            let angle = std::f32::consts::PI * (step as f32 + 0.5) / N as f32;
            center - half * libm::cosf(angle)
        });
        let scales = positions.map(|own| {
            let others = positions.iter().filter(|other| **other != own);
            1.0 / others.map(|other| own - other).product::<f32>()
        });
        Self { positions, scales }
    }

    /// Lagrange weights of the nodes at a position.
    pub(super) fn weights(&self, position: f32) -> [f32; N] {
        let mut weights = self.scales;
        // Products of the differences to all nodes before and after each one
        let (mut before, mut after) = (1.0, 1.0);
        for step in 0..N {
            weights[step] *= before;
            before *= position - self.positions[step];
            let back = N - 1 - step;
            weights[back] *= after;
            after *= position - self.positions[back];
        }
        weights
    }
}
