//! Prints which damages the presets of comparisons catch, and, beside them, the limits that Blender's tests give `idiff`:
//! `cargo run --release --example damages`.
//!
//! Each damage is judged as light (what EXR files hold) and as a display shows it (PNG files of eight bits). `CAUGHT` is a
//! preset that fails, as it should for all but a little noise or exposure.

mod damage;
mod pictures;
mod table;

use std::path::Path;

#[expect(clippy::print_stdout, reason = "a program that prints a table")]
fn main() -> rayframe::error::Result<()> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let rows = table::rows(&scenes)?;
    print!("{}", table::text(&rows));
    Ok(())
}
