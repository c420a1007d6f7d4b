//! Integrates the tables of albedos anew: `cargo run --release -p oracles --bin albedo_tables`, from the project's root.
//! With `--check` it compares the files with their integrals instead of writing them.

use std::io::{Error, Result};
use std::path::Path;

use rayframe::bsdf::integrated_albedo_tables;

fn main() -> Result<()> {
    let only_checks = std::env::args().any(|argument| argument == "--check");
    for (name, bytes) in integrated_albedo_tables() {
        let path = Path::new("src/bsdf").join(name);
        if !only_checks {
            std::fs::write(path, bytes)?;
        } else if std::fs::read(&path)? != bytes {
            return Err(Error::other(format!("{} is not its integral", path.display())));
        }
    }
    Ok(())
}
