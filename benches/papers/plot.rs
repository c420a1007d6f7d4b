//! Plots of sweeps, gains and throughput as SVG.

use std::path::Path;

use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;

use super::Result;
use super::gain::Gain;
use super::measure::SceneTable;
use super::systems::BUDGETS;
use super::throughput::Point;

const SIZE: (u32, u32) = (760, 440);
/// Colours that all people tell apart, colour-blind ones too (Okabe and Ito 2008).
const COLORS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(140, 110, 60),
];

/// Points with a name. A `marked` point gets a ring.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
    marked: Option<(f64, f64)>,
    is_line: bool,
}

type Context<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// Words and lines of a chart.
struct Chart<'a> {
    title: &'a str,
    x: &'a str,
    y: &'a str,
    /// Where a vertical line is.
    limit: Option<f64>,
    legend: SeriesLabelPosition,
}

/// Speed-up of camera rays against references a triangle: a line for each scene, and a ring for the automatic choice.
pub(crate) fn sweep(file: &Path, tables: &[SceneTable]) -> Result<()> {
    let series = tables.iter().filter_map(|table| {
        let base = table.rows.iter().find(|row| row.system == "Rayframe, unsplit")?.primary.microseconds;
        let point = |row: &super::measure::Row| (row.references_a_triangle, base / row.primary.microseconds);
        let rows = table.rows.iter().filter(|row| row.system.starts_with("Rayframe") && !row.is_automatic);
        Some(Series {
            name: table.scene.clone(),
            points: rows.map(point).collect(),
            marked: table.rows.iter().find(|row| row.is_automatic).map(point),
            is_line: true,
        })
    });
    let chart = Chart {
        title: "Early split clipping: speed-up of camera rays over no splits (rings: automatic)",
        x: "references a triangle, R",
        y: "speed-up",
        limit: None,
        legend: SeriesLabelPosition::UpperRight,
    };
    draw(file, &chart, &series.collect::<Vec<_>>())
}

/// Least overlap of sparse boxes that a plot shows; the scale is logarithmic.
const LEAST_OVERLAP: f64 = 0.01;

/// Gain of rays against the overlap of sparse boxes.
pub(crate) fn gain(file: &Path, gains: &[Gain]) -> Result<()> {
    let names = BUDGETS.map(|budget| format!("R = {budget}")).into_iter().chain(["automatic".to_owned()]);
    let series: Vec<_> = names
        .enumerate()
        .map(|(index, name)| Series {
            name,
            points: gains
                .iter()
                .map(|gain| (gain.sparse_overlap.max(LEAST_OVERLAP), gain.of_rays[index]))
                .collect(),
            marked: None,
            is_line: false,
        })
        .collect();
    let chart = Chart {
        title: "Gain of splits: time of rays without splits over time with them",
        x: "overlap D of sparse boxes, 0.01 and more (line: 4, from which Rayframe splits)",
        y: "gain",
        limit: Some(4.0),
        legend: SeriesLabelPosition::UpperLeft,
    };
    draw(file, &chart, &series)
}

/// Throughput against triangles with all threads: a line for each builder.
pub(crate) fn throughput(file: &Path, points: &[Point]) -> Result<()> {
    let most = points.iter().map(|point| point.threads).max().unwrap_or(1);
    let mut series: Vec<Series> = Vec::new();
    for point in points.iter().filter(|point| point.threads == most) {
        let at = (point.triangles as f64, point.throughput());
        match series.iter_mut().find(|series| series.name == point.builder) {
            Some(series) => series.points.push(at),
            None => series.push(Series {
                name: point.builder.to_owned(),
                points: vec![at],
                marked: None,
                is_line: true,
            }),
        }
    }
    let title = format!("Build throughput on an even mesh, threads: {most}");
    let chart = Chart {
        title: &title,
        x: "triangles",
        y: "million triangles a second",
        limit: None,
        legend: SeriesLabelPosition::UpperLeft,
    };
    draw(file, &chart, &series)
}

/// A chart with logarithmic axes.
fn draw(file: &Path, chart: &Chart, series: &[Series]) -> Result<()> {
    let all = || series.iter().flat_map(|series| series.points.iter().chain(&series.marked));
    let range = |of: fn(&(f64, f64)) -> f64, above: f64| {
        let (low, high) =
            all().map(of).fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        (low / 1.15..high * above).log_scale()
    };
    // The legend is above the points.
    let (x, y) = (range(|point| point.0, 1.15), range(|point| point.1, 4.0));
    let area = SVGBackend::new(file, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut context = ChartBuilder::on(&area)
        .caption(chart.title, ("sans-serif", 17))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(56)
        .build_cartesian_2d(x, y)?;
    context
        .configure_mesh()
        .x_desc(chart.x)
        .y_desc(chart.y)
        .x_label_formatter(&|x| format!("{x}"))
        .y_label_formatter(&|y| format!("{y}"))
        .light_line_style(BLACK.mix(0.06))
        .max_light_lines(1)
        .bold_line_style(BLACK.mix(0.18))
        .draw()?;
    if let Some(limit) = chart.limit {
        let height = context.y_range();
        let line = vec![(limit, height.start), (limit, height.end)];
        context.draw_series([PathElement::new(line, BLACK.stroke_width(2))])?;
    }
    for (index, series) in series.iter().enumerate() {
        plot_series(&mut context, series, index)?;
    }
    context
        .configure_series_labels()
        .position(chart.legend.clone())
        .label_font(("sans-serif", 13))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(area.present()?)
}

/// A line through the points, the points, and a ring around the marked one.
fn plot_series<'a>(context: &mut Context<'a, 'a>, series: &Series, index: usize) -> Result<()> {
    let color = COLORS[index % COLORS.len()];
    // Lines beyond the colours are thin.
    let width = if index < COLORS.len() { 2 } else { 1 };
    if series.is_line {
        context.draw_series(LineSeries::new(series.points.iter().copied(), color.stroke_width(width)))?;
    }
    let dots = series.points.iter().map(|&point| Circle::new(point, 3, color.filled()));
    let legend = move |(x, y): (i32, i32)| Circle::new((x + 8, y), 4, color.filled());
    context.draw_series(dots)?.label(&series.name).legend(legend);
    let ring = series.marked.iter().map(|&point| Circle::new(point, 7, color.stroke_width(2)));
    context.draw_series(ring)?;
    Ok(())
}
