//! Instruction sets: which there are, which the machine has.
//!
//! Lane code is written once over [`fearless_simd::Simd`] and compiled for each level; a task chooses one when it starts.

use fearless_simd::Level;

/// Instruction sets that traversal can use; each gives the same answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SimdLevel {
    /// Plain Rust, on every machine.
    Scalar,
    /// x86-64-v2: SSE4.2.
    Sse42,
    /// x86-64-v3: AVX2.
    Avx2,
    /// AVX-512 as of Ice Lake and Zen 4.
    Avx512,
    /// 64-bit ARM.
    Neon,
}

impl SimdLevel {
    /// All levels, on whatever machine.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon];

    /// The best level of the machine that runs.
    pub fn best() -> Self {
        let best = Self::ALL.into_iter().rfind(|level| level.is_supported());
        best.unwrap_or(Self::Scalar)
    }

    /// Whether the machine that runs has this level; queries fall back to [`SimdLevel::Scalar`] where it has not.
    pub fn is_supported(self) -> bool {
        self.detected().is_some()
    }

    /// The proof that the machine has this level, or the one of plain Rust.
    pub(super) fn level(self) -> Level {
        self.detected().unwrap_or_else(Level::fallback)
    }

    fn detected(self) -> Option<Level> {
        match self {
            Self::Scalar => Some(Level::fallback()),
            #[cfg(target_arch = "x86_64")]
            Self::Sse42 => Level::new().as_sse4_2().map(Level::Sse4_2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => Level::new().as_avx2().map(Level::Avx2),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => Level::new().as_avx512().map(Level::Avx512),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => Level::new().as_neon().map(Level::Neon),
            #[expect(clippy::allow_attributes, reason = "which levels are left depends on the architecture")]
            #[allow(unreachable_patterns)]
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_rust_is_everywhere_and_the_best_level_is_supported() {
        assert!(SimdLevel::Scalar.is_supported());
        assert!(SimdLevel::best().is_supported());
        assert!(!(SimdLevel::Avx2.is_supported() && SimdLevel::Neon.is_supported()));
    }
}
