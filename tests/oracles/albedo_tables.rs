//! Integrates the tables of albedos anew: `cargo run --release -p oracles --bin albedo_tables`, from the project's root.

use rayframe::bsdf::integrated_albedo_tables;

fn main() -> std::io::Result<()> {
    std::fs::write("src/bsdf/albedo_tables.bin", integrated_albedo_tables())
}
