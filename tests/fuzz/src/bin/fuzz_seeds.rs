//! Writes the seeds of every target to `FOLDER/TARGET` and its dictionary to `FOLDER/TARGET.dict`, and prints the names of the targets.

use std::error::Error;
use std::path::PathBuf;

use fuzz_targets::TARGETS;

#[expect(clippy::print_stdout, reason = "run.py reads the names")]
fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args_os().nth(1).ok_or("usage: fuzz_seeds FOLDER")?);
    for target in &TARGETS {
        let seeds = folder.join(target.name);
        std::fs::create_dir_all(&seeds)?;
        for seed in (target.seeds)() {
            std::fs::write(seeds.join(&seed.name), &seed.bytes)?;
        }
        std::fs::write(folder.join(target.name).with_extension("dict"), fuzz_targets::dictionary())?;
        println!("{}", target.name);
    }
    Ok(())
}
