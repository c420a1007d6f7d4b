//! Command-line options of the bench.

use std::path::PathBuf;

use super::{Result, scenes};

/// What `--help` prints.
pub(crate) const HELP: &str = "\
The papers' tables and plots, on any scene.

Usage: cargo bench --bench papers -- [OPTIONS] [SCENE…]

A SCENE is scan, mirror-hall, mirror-hall-fine, plant, plant-N (N pipes and beams), a .tri file with a .cam file
beside it, or a glTF file. The default is the first four. Every system must give the hits of the product, to the
last bit; otherwise the run fails. Progress goes to stderr, tables to stdout.

Options:
  --report NAME      table: all systems of the papers (default)
                     sweep: SA_max from coarse to fine, with the product's automatic choice marked
                     gain: what splits gain against the overlap of each scene's boxes
                     throughput: triangles built a second, by threads and by number of triangles; needs no scene
  --size N           camera rays a row and a column of the image, pixels [1000]
  --factors A,B,…    SA_max of early splits, as multiples of the area of the scene's box over its triangles
                     [64,16,4; for sweep 1024 to 0.5]
  --threads N        threads that build; rays are traced on one [1; for throughput all]
  --repeats N        runs of each measurement, of which the fastest counts [1]
  --largest SHARE    leave out triangles whose box has more than this share of the area of the scene's box [1]
  --no-overlap       leave out the end-point overlap, which takes long
  --output FOLDER    write NAME.csv, NAME.json and NAME.md, and plots as NAME.svg, except for table
  --help             print this
";

/// Which measurement is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Report {
    Table,
    Sweep,
    Gain,
    Throughput,
}

impl Report {
    /// Name of the option and of the files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Table => "table",
            Self::Sweep => "sweep",
            Self::Gain => "gain",
            Self::Throughput => "throughput",
        }
    }
}

/// Command-line options.
#[derive(Debug)]
pub(crate) struct Options {
    pub(crate) report: Report,
    pub(crate) scenes: Vec<String>,
    pub(crate) size: u32,
    /// SA_max of early splits, as multiples of the scene's area over its triangles.
    pub(crate) factors: Vec<f64>,
    /// Largest box of a triangle that is kept, as a share of the area of the scene's box.
    pub(crate) largest: f64,
    pub(crate) threads: usize,
    pub(crate) repeats: u32,
    pub(crate) has_overlap: bool,
    pub(crate) output: Option<PathBuf>,
}

impl Options {
    /// Parses arguments; `None` where `--help` is among them.
    ///
    /// # Errors
    /// Unknown options and values.
    pub(crate) fn parse(mut arguments: impl Iterator<Item = String>) -> Result<Option<Self>> {
        let mut options = Self {
            report: Report::Table,
            scenes: Vec::new(),
            size: 1000,
            factors: Vec::new(),
            largest: 1.0,
            threads: 0,
            repeats: 1,
            has_overlap: true,
            output: None,
        };
        while let Some(argument) = arguments.next() {
            let mut value = || arguments.next().ok_or_else(|| format!("{argument} needs a value"));
            match argument.as_str() {
                // Cargo passes this to every benchmark.
                "--bench" => {}
                "--help" | "-h" => return Ok(None),
                "--report" => {
                    let name = value()?;
                    options.report = [Report::Table, Report::Sweep, Report::Gain, Report::Throughput]
                        .into_iter()
                        .find(|report| report.name() == name)
                        .ok_or_else(|| format!("{name} is not a report: table, sweep, gain or throughput"))?;
                }
                "--size" => options.size = value()?.parse()?,
                "--largest" => options.largest = value()?.parse()?,
                "--threads" => options.threads = value()?.parse()?,
                "--repeats" => options.repeats = value()?.parse()?,
                "--factors" => {
                    options.factors =
                        value()?.split(',').map(str::parse).collect::<std::result::Result<_, _>>()?;
                }
                "--no-overlap" => options.has_overlap = false,
                "--output" => options.output = Some(value()?.into()),
                flag if flag.starts_with('-') => {
                    return Err(format!("{flag} is not an option; --help lists them").into());
                }
                scene => options.scenes.push(scene.to_owned()),
            }
        }
        if options.size == 0 || options.repeats == 0 {
            return Err("--size and --repeats need at least one".into());
        }
        options.fill();
        Ok(Some(options))
    }

    /// Sets what was not given.
    fn fill(&mut self) {
        if self.scenes.is_empty() {
            self.scenes = scenes::GENERATED.map(str::to_owned).to_vec();
        }
        if self.factors.is_empty() {
            self.factors = match self.report {
                Report::Sweep => (-1..=10).rev().map(|exponent| libm::exp2(f64::from(exponent))).collect(),
                _ => vec![64.0, 16.0, 4.0],
            };
        }
        if self.threads == 0 {
            self.threads = match self.report {
                Report::Throughput => std::thread::available_parallelism().map_or(1, usize::from),
                _ => 1,
            };
        }
    }
}
