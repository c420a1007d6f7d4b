//! Blocks of values, component by component, for loops that the compiler turns into vector instructions.
//!
//! A loop over a block calls the scalar function that defines the value, once for each lane, inside [`vectorized`]. So
//! there is one definition of every value, and all instruction sets compute the same bits. To be vectorised, the body of such a loop has no
//! calls that are not inlined and no memory accesses that depend on a condition; doubles have loops of their own.

use glam::{Vec2, Vec3};

/// Runs a task that is compiled for the instruction set of a token.
macro_rules! compiled_for {
    ($simd:expr, $task:expr) => {
        fearless_simd::Simd::vectorize(
            $simd,
            #[inline(always)]
            || $task,
        )
    };
}
pub(crate) use compiled_for;

/// Compiles a loop over lanes for the instruction sets whose vectors are wider than those that every machine has, and runs it at `level`.
macro_rules! vectorized {
    ($level:expr, $task:expr) => {
        match $level {
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx512(simd) => $crate::geometry::compiled_for!(simd, $task),
            #[cfg(target_arch = "x86_64")]
            fearless_simd::Level::Avx2(simd) => $crate::geometry::compiled_for!(simd, $task),
            _ => $task,
        }
    };
}
pub(crate) use vectorized;

/// Number of lanes of a block: a vector of the widest instruction set.
pub(crate) const LANES: usize = 16;

/// One number for each lane.
pub(crate) type F32Lanes = [f32; LANES];

/// One vector of two components for each lane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vec2Lanes {
    x: F32Lanes,
    y: F32Lanes,
}

/// One vector of three components for each lane.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vec3Lanes {
    x: F32Lanes,
    y: F32Lanes,
    z: F32Lanes,
}

impl Vec2Lanes {
    /// The vector of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec2 {
        Vec2::new(self.x[lane], self.y[lane])
    }

    /// Replaces the vector of a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, vector: Vec2) {
        self.x[lane] = vector.x;
        self.y[lane] = vector.y;
    }
}

impl Vec3Lanes {
    /// The vector of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    /// Replaces the vector of a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, vector: Vec3) {
        self.x[lane] = vector.x;
        self.y[lane] = vector.y;
        self.z[lane] = vector.z;
    }
}
