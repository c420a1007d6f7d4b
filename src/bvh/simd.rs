//! SIMD instruction sets of traversal and their detection.
//!
//! Lane code is written once over [`fearless_simd::Simd`] and compiled for each level. A task selects its level when it starts.

use fearless_simd::Level;

/// Instruction set of traversal. All give the same answers.
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
    /// All levels of all machines.
    pub const ALL: [Self; 5] = [Self::Scalar, Self::Sse42, Self::Avx2, Self::Avx512, Self::Neon];

    /// Best level of this machine.
    pub fn best() -> Self {
        let best = Self::ALL.into_iter().rfind(|level| level.is_supported());
        best.unwrap_or(Self::Scalar)
    }

    /// Whether this machine has the level. Queries fall back to [`SimdLevel::Scalar`] otherwise.
    pub fn is_supported(self) -> bool {
        self.detected().is_some()
    }

    /// Token that proves that this machine has the level, or that of plain Rust.
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

/// The level for code of eight lanes, which AVX-512 does not make faster: AVX2 where `level` has it.
pub(super) fn with_eight_lanes(level: Level) -> Level {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = level.as_avx2() {
        return Level::Avx2(avx2);
    }
    level
}

/// Runs lane code at a level. It is compiled for each [`SimdLevel`], not for SSE2 as `fearless_simd::dispatch` would. Without
/// vectors, the expression after `else` runs instead where there is one.
macro_rules! dispatch_lanes {
    ($level:expr, $simd:ident => $task:expr $(, else $scalar:expr)?) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx512($simd) => $crate::geometry::compiled_for!($simd, $task),
            level => $crate::bvh::simd::dispatch_eight_lanes!(level, $simd => $task $(, else $scalar)?),
        }
    };
}
pub(super) use dispatch_lanes;

/// [`dispatch_lanes`] for code of eight lanes, which is not compiled for AVX-512.
macro_rules! dispatch_eight_lanes {
    ($level:expr, $simd:ident => $task:expr) => {
        $crate::bvh::simd::dispatch_eight_lanes!($level, $simd => $task, else {
            let $simd = fearless_simd::Fallback::new();
            $task
        })
    };
    ($level:expr, $simd:ident => $task:expr, else $scalar:expr) => {
        match $crate::bvh::simd::with_eight_lanes($level) {
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx2($simd) => $crate::geometry::compiled_for!($simd, $task),
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Sse4_2($simd) => $crate::geometry::compiled_for!($simd, $task),
            #[cfg(target_arch = "aarch64")]
            fearless_simd::Level::Neon($simd) => $crate::geometry::compiled_for!($simd, $task),
            _ => $scalar,
        }
    };
}
pub(super) use dispatch_eight_lanes;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scalar_and_the_best_level_are_supported() {
        assert!(SimdLevel::Scalar.is_supported());
        assert!(SimdLevel::best().is_supported());
        assert!(!(SimdLevel::Avx2.is_supported() && SimdLevel::Neon.is_supported()));
    }
}
