//! Integrates the tables of albedos anew: `cargo run --release -p oracles --bin albedo_tables`, from the project's root.

use std::path::Path;

use rayframe::bsdf::integrated_albedo_tables;

fn main() -> std::io::Result<()> {
    for (name, bytes) in integrated_albedo_tables() {
        std::fs::write(Path::new("src/bsdf").join(name), bytes)?;
    }
    Ok(())
}
