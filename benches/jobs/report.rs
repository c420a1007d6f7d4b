//! Tables of measured jobs.

use super::measure::Run;

/// Width of the column of names.
const NAME: usize = 16;

/// Tables of costs and of shares, and ratios where there are two runs of each job.
pub(crate) fn tables(jobs: &[(String, Vec<Run>)]) -> String {
    let mut text = String::from("\n");
    text +=
        &line("job", &["wall s", "CPU s", "first s", "Mrays/s", "peak MB", "faults k"].map(str::to_owned));
    for (name, run) in rows(jobs) {
        let mega_rays = run.rays / run.trace_seconds.max(1e-9) / 1e6;
        let values = [run.wall_seconds, run.cpu_seconds, run.first_tile_seconds, mega_rays];
        let mut cells: Vec<String> =
            values.iter().map(|value| known(*value, |value| format!("{value:.2}"))).collect();
        cells.push(format!("{:.0}", run.peak_bytes / 1e6));
        cells.push(format!("{:.0}", run.faults / 1e3));
        text += &line(&name, &cells);
    }

    text += "\n";
    text += &line(
        "share of wall",
        &["import", "pose", "build", "queries", "shading", "output"].map(str::to_owned),
    );
    for (name, run) in rows(jobs).filter(|(_, run)| run.trace_seconds > 0.0) {
        let shares = shares(run).map(|share| format!("{:.1} %", share * 100.0));
        text += &line(&name, &shares);
    }
    text + &ratios(jobs)
}

/// Every run with its name: `name` alone, or `name` and `name (2)` of two binaries.
fn rows(jobs: &[(String, Vec<Run>)]) -> impl Iterator<Item = (String, &Run)> {
    jobs.iter().flat_map(|(name, runs)| {
        let label = move |index| if index == 0 { name.clone() } else { format!("{name} ({})", index + 1) };
        runs.iter().enumerate().map(move |(index, run)| (label(index), run))
    })
}

fn shares(run: &Run) -> [f64; 6] {
    let Run { import_seconds, pose_seconds, build_seconds, query_seconds, trace_seconds, .. } = run;
    let shading = trace_seconds - query_seconds;
    let before_output = import_seconds + pose_seconds + build_seconds + trace_seconds;
    let output = (run.wall_seconds - before_output).max(0.0);
    let seconds = [*import_seconds, *pose_seconds, *build_seconds, *query_seconds, shading, output];
    seconds.map(|seconds| seconds / run.wall_seconds)
}

/// Times of the second binary over those of the first.
fn ratios(jobs: &[(String, Vec<Run>)]) -> String {
    let pairs: Vec<_> =
        jobs.iter().filter_map(|(name, runs)| Some((name, runs.first()?, runs.get(1)?))).collect();
    if pairs.is_empty() {
        return String::new();
    }
    let mut text = String::from("\n");
    text += &line("second / first", &["wall", "CPU", "first", "peak"].map(str::to_owned));
    let mut logarithms = [0.0; 4];
    let mut counts = [0.0_f64; 4];
    for (name, old, new) in pairs {
        let values = |run: &Run| [run.wall_seconds, run.cpu_seconds, run.first_tile_seconds, run.peak_bytes];
        let (old, new) = (values(old), values(new));
        let ratios: [f64; 4] =
            std::array::from_fn(|i| if old[i] > 0.0 && new[i] > 0.0 { new[i] / old[i] } else { 0.0 });
        for (i, ratio) in ratios.iter().enumerate().filter(|(_, ratio)| **ratio > 0.0) {
            logarithms[i] += libm::log(*ratio);
            counts[i] += 1.0;
        }
        text += &line(name, &ratios.map(|ratio| known(ratio, |ratio| format!("{ratio:.3}"))));
    }
    let means: [f64; 4] = std::array::from_fn(|i| libm::exp(logarithms[i] / counts[i].max(1.0)));
    text + &line("geometric mean", &means.map(|mean| format!("{mean:.3}")))
}

/// A value, or a dash for an unknown one, which is 0.
fn known(value: f64, format: impl Fn(f64) -> String) -> String {
    if value == 0.0 { "-".to_owned() } else { format(value) }
}

fn line(name: &str, cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:>10}")).collect();
    format!("{name:<NAME$}{}\n", cells.concat())
}
