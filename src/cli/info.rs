//! `rayframe info`: contents of a file, default selection, unsupported features.

mod report;
mod text;

use std::path::PathBuf;

use clap::Args;

use crate::progress::{print_json, print_output};
use rayframe::error::Result;
use rayframe::gltf::{self, ImageLoading, ImportOptions};
use rayframe::scene::{Selection, SelectionRequest};

use rayframe::settings::parse as options;
use rayframe::shot::memory_limit::default_max_memory_bytes;

/// Options of `rayframe info`.
#[derive(Clone, Debug, Args)]
pub(super) struct InfoArgs {
    /// The scene: .glb or .gltf
    scene: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Memory limit, such as 8G; only the headers of textures are read [default: 80 % of the available memory]
    #[arg(long, value_name = "SIZE", value_parser = options::memory_size)]
    max_memory: Option<u64>,
    /// Permit files of the scene in this folder, which is outside its own
    #[arg(long, value_name = "DIR")]
    allow_dir: Vec<PathBuf>,
}

/// Prints the contents of the file.
pub(super) fn run(args: &InfoArgs) -> Result<()> {
    let max_memory_bytes = args.max_memory.unwrap_or_else(default_max_memory_bytes);
    let allowed_folders = args.allow_dir.clone();
    let options = ImportOptions { max_memory_bytes, images: ImageLoading::Headers, allowed_folders };
    let scene = gltf::import(&args.scene, &options)?;
    let (selection, warnings) = Selection::resolve(&SelectionRequest::default(), &scene)?;
    let report = report::Report::new(&scene, &selection, &warnings);
    if args.json {
        let json = serde_json::to_string_pretty(&report)
            .map_err(|error| rayframe::error::Error::Internal { message: error.to_string() })?;
        print_json(&json);
    } else {
        print_output(&text::text(&report));
    }
    Ok(())
}
