//! Exit codes of errors, after `sysexits.h`.

/// Images differ, or a test failed.
pub const DIFFERENT: u8 = 1;
/// Invalid or conflicting options.
pub const USAGE: u8 = 2;
/// Invalid or unsupported content of a file.
pub const INVALID: u8 = 65;
/// A file is missing or unreadable.
pub const MISSING: u8 = 66;
/// Bug in Rayframe.
pub const INTERNAL: u8 = 70;
/// An output cannot be created.
pub const CANNOT_CREATE: u8 = 73;
/// Writing an output failed.
pub const WRITE_FAILED: u8 = 74;
/// The work was cancelled, or the system is short of something; it may be retried.
pub const TEMPORARY: u8 = 75;
/// A limit was exceeded, or access is not permitted.
pub const REFUSED: u8 = 77;

/// Rank of an exit code by how permanent its failure is: highest for a bug, low for a full disk, 0 for success.
pub fn permanence(exit_code: u8) -> u8 {
    match exit_code {
        0 => 0,
        INTERNAL => 4,
        INVALID | MISSING => 3,
        REFUSED => 2,
        _ => 1,
    }
}
