//! Command-line options.

use std::path::PathBuf;

use crate::Result;

/// Default scenes. `pipes` is measured only when named, because it takes minutes.
const SCENES: [&str; 7] = ["bunny", "sponza", "kitchen", "arch", "stadium", "ico70k", "ico1m"];

/// Command-line options.
pub(crate) struct Options {
    /// Folder written by `run_peer.sh`.
    pub(crate) folder: PathBuf,
    /// File to which rows are appended.
    pub(crate) csv: Option<PathBuf>,
    pub(crate) scenes: Vec<String>,
    /// Compare answers instead of measuring.
    pub(crate) check: bool,
    /// Rays of a scene that [`Options::check`] compares with brute force.
    pub(crate) sample: usize,
    libraries: Vec<String>,
    configurations: Vec<String>,
    /// Numbers of threads.
    pub(crate) threads: Vec<usize>,
}

impl Options {
    /// `WORKDIR [--csv FILE] [--lib rayframe|obvhs]… [--config NAME]… [--threads N]… [--check [--sample N]] [SCENE…]`.
    pub(crate) fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Self> {
        let mut options = Self {
            folder: PathBuf::new(),
            csv: None,
            scenes: Vec::new(),
            check: false,
            sample: 10_000,
            libraries: Vec::new(),
            configurations: Vec::new(),
            threads: Vec::new(),
        };
        let mut positional = Vec::new();
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
            match argument.as_str() {
                // Cargo passes this to every benchmark.
                "--bench" => {}
                "--check" => options.check = true,
                "--csv" => options.csv = Some(value()?.into()),
                "--sample" => options.sample = value()?.parse()?,
                "--lib" => options.libraries.push(value()?),
                "--config" => options.configurations.push(value()?),
                "--threads" => options.threads.push(value()?.parse()?),
                flag if flag.starts_with('-') => return Err(format!("{flag} is not an option").into()),
                _ => positional.push(argument),
            }
        }
        let mut positional = positional.into_iter();
        options.folder = positional.next().ok_or("name the folder written by run_peer.sh")?.into();
        options.scenes = positional.collect();
        if options.scenes.is_empty() {
            options.scenes = SCENES.map(str::to_owned).to_vec();
        }
        if options.threads.is_empty() {
            options.threads = vec![1, 2];
        }
        if options.threads.contains(&0) {
            return Err("--threads is at least 1".into());
        }
        Ok(options)
    }

    /// Whether rows of `library` are selected.
    pub(crate) fn wants_library(&self, library: &str) -> bool {
        self.libraries.is_empty() || self.libraries.iter().any(|wanted| wanted == library)
    }

    /// Whether rows of `configuration` are selected.
    pub(crate) fn wants(&self, configuration: &str) -> bool {
        self.configurations.is_empty() || self.configurations.iter().any(|wanted| wanted == configuration)
    }
}
