//! Tests of the library through its public interface, one subject a module.

mod aovs;
mod bands;
mod bvh;
mod checkpoints;
mod closed_spaces;
mod colors;
mod conformance;
mod corruptions;
mod environment_shares;
mod exposed_samples;
mod exposure;
mod fault_table;
mod framing;
mod framing_motion;
mod framing_near;
mod framing_unseen;
mod image_lights;
mod interreflections;
mod known_answers;
mod motion_blur;
mod noise_threshold;
mod posing;
mod references;
mod renderer;
mod resume;
mod run_lock;
mod scene_hashes;
mod scenes;
mod sequence;
mod showcase;
mod source_lengths;
mod stage;
mod write_behind;

use rayframe::bvh::SimdLevel;

/// The SIMD levels of this processor. The first call reports the missing ones on the standard error stream, past the capture
/// of the test harness.
pub(crate) fn supported_simd_levels() -> impl Iterator<Item = SimdLevel> {
    static REPORT: std::sync::Once = std::sync::Once::new();
    REPORT.call_once(|| {
        use std::io::Write as _;
        for level in SimdLevel::ALL.into_iter().filter(|level| !level.is_supported()) {
            let _ = writeln!(std::io::stderr(), "skipped: {level:?}: this processor does not support it");
        }
    });
    SimdLevel::ALL.into_iter().filter(|level| level.is_supported())
}
