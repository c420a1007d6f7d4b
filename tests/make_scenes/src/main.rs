//! Writes the suite `scenes/`, or with `--check` lists the files that differ from what it would write.

use std::error::Error;
use std::path::Path;

use make_scenes::{all_scenes, differences};

#[expect(clippy::print_stdout, reason = "a program that says what it wrote")]
fn main() -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scenes = all_scenes()?;
    if std::env::args().skip(1).any(|argument| argument == "--check") {
        let lines = differences(&folder, &scenes)?;
        return if lines.is_empty() { Ok(()) } else { Err(lines.join("\n").into()) };
    }
    for (path, content) in &scenes {
        let file = folder.join(path);
        if let Some(parent) = file.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(&file, content)?;
        println!("scenes/{}: {} bytes", path.display(), content.len());
    }
    Ok(())
}
