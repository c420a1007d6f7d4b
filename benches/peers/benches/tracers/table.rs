//! Table of results: rows `lib,scene,config,threads,metric,value`.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::Path;

use crate::Result;

/// First columns of the rows of one measurement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key<'a> {
    pub(crate) library: &'a str,
    pub(crate) scene: &'a str,
    pub(crate) configuration: &'a str,
    pub(crate) threads: usize,
}

/// Output of rows: a file, or standard output if none is named.
pub(crate) struct Table(Option<File>);

impl Table {
    pub(crate) fn append_to(path: Option<&Path>) -> Result<Self> {
        let open = |path| OpenOptions::new().create(true).append(true).open(path);
        Ok(Self(path.map(open).transpose()?))
    }

    pub(crate) fn row(&mut self, key: Key<'_>, metric: &str, value: f64) -> Result<()> {
        let Key { library, scene, configuration, threads } = key;
        let line = format!("{library},{scene},{configuration},{threads},{metric},{value:.6}");
        match &mut self.0 {
            Some(file) => writeln!(file, "{line}")?,
            None => writeln!(std::io::stdout(), "{line}")?,
        }
        Ok(())
    }
}
