//! The option `--suite`, common to all commands about suites.

use std::path::{Path, PathBuf};

use clap::Args;

use super::output_folders::check_inside;
use rayframe::error::{Error, Result};
use rayframe::regression::suite::{SUITE_FILE, Suite, shell_word};
use rayframe::shot::check_suite_settings;

/// The option `--suite`.
#[derive(Clone, Debug, Args)]
pub(super) struct SuiteOption {
    /// The suite: its folder or its file [default: suite.toml here, or in the nearest folder above that has one]
    #[arg(long, value_name = "DIR|FILE")]
    suite: Option<PathBuf>,
    /// Permit references, report and cache of the suite file in this folder, which is outside its own
    #[arg(long, value_name = "DIR")]
    allow_dir: Vec<PathBuf>,
}

impl SuiteOption {
    /// Reads the suite.
    ///
    /// # Errors
    /// [`Error::Usage`] when none is named and none found, and those of reading it.
    pub(super) fn read(&self) -> Result<Suite> {
        let suite = Suite::read(&self.file()?)?;
        check_suite_settings(&suite.file)?;
        let folders = [("references", &suite.references), ("report", &suite.report), ("cache", &suite.cache)];
        for (key, folder) in folders {
            check_inside(&suite.file, key, folder, &self.allow_dir)?;
        }
        Ok(suite)
    }

    fn file(&self) -> Result<PathBuf> {
        let here = PathBuf::from(SUITE_FILE);
        if let Some(path) = &self.suite {
            return Ok(path.clone());
        }
        if here.is_file() {
            return Ok(here);
        }
        let folder = std::env::current_dir().unwrap_or_default();
        Suite::find(&folder).ok_or_else(|| {
            Error::usage(format!(
                "there is no {SUITE_FILE} here or in a folder above; rayframe test --init makes one, --suite names one elsewhere"
            ))
        })
    }

    /// ` --suite DIR --allow-dir DIR` as it was typed; nothing where it was not.
    pub(super) fn shown(&self) -> String {
        let suite = self.suite.iter().map(|path| ("--suite", path));
        let options = suite.chain(self.allow_dir.iter().map(|path| ("--allow-dir", path)));
        options.fold(String::new(), |text, (option, path)| {
            format!("{text} {option} {}", shell_word(&path.display().to_string()))
        })
    }

    /// The folders of `--allow-dir`.
    pub(super) fn allowed(&self) -> &[PathBuf] {
        &self.allow_dir
    }

    /// The given folder, or the current one.
    pub(super) fn folder(&self) -> &Path {
        self.suite.as_deref().unwrap_or(Path::new(""))
    }
}
