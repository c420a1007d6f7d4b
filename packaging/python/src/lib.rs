//! The functions of the Python module `rayframe._rayframe`, which `rayframe/__init__.py` documents and wraps.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use numpy::{PyArray1, PyArray3, PyArrayMethods as _, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayframe::cancel::CancelFlag;
use rayframe::error::{Error, Provenance, Result};
use rayframe::image::{ColorEncoding, Image};
use rayframe::regression::{BEAUTY, Channel, Preset, Samples};
use rayframe::sequence::SequenceEvent;
use rayframe::settings::{Definition, Group, Settings};
use rayframe::{RenderedFrame, Renderer};

create_exception!(
    rayframe,
    RayframeError,
    PyException,
    "An error of Rayframe. `exit_code` is that of the program."
);

/// Interval between looks at Ctrl-C.
const TICK: Duration = Duration::from_millis(50);

/// Settings by name, each with one value or the elements of a list.
type Arguments = Vec<(String, Vec<OsString>)>;
/// Width and height.
type Size = Option<(i64, i64)>;

/// What a function makes, on which it depends which settings have a meaning.
#[derive(Clone, Copy, PartialEq)]
enum Product {
    Pixels,
    Channels,
    Files,
}

impl Product {
    /// Why a setting has no meaning for it.
    fn refusal(self, setting: &Definition) -> Option<&'static str> {
        let is_of_files = setting.group == Group::Output && setting.is_for_runs;
        let is_of_sequences = setting.group == Group::Frames && setting.name != "fps";
        match setting.name {
            "scene" => return Some("the scene is the first argument"),
            "stats" | "manifest" | "show" | "progress" | "quiet" | "verbose" => {
                return Some("only the program has it");
            }
            _ => {}
        }
        match self {
            Self::Files if setting.name == "output" => Some("the files are the second argument"),
            Self::Files => None,
            _ if is_of_sequences => Some("one frame is rendered: that of the argument 'frame'"),
            _ if is_of_files => Some("no file is written; render_sequence writes files"),
            Self::Pixels if setting.group == Group::Output => {
                Some("only colour and alpha are returned; render_channels returns all")
            }
            Self::Pixels | Self::Channels => None,
        }
    }

    /// Checks the arguments, and returns the number of threads among them.
    fn check(self, size: Size, arguments: &Arguments) -> Result<Option<usize>> {
        let mut threads = None;
        for (name, values) in arguments {
            let Some(setting) = Definition::of(name) else { continue };
            if let Some(why) = self.refusal(setting) {
                return Err(Error::usage(format!("{name}: {why}")));
            }
            if size.is_some() && ["resolution", "width", "height"].contains(&setting.name) {
                return Err(Error::usage(format!("size and {name} contradict each other")));
            }
            if setting.name == "threads" {
                threads = values.first().and_then(|value| value.to_str()?.parse().ok());
            }
        }
        Ok(threads)
    }
}

fn raised(error: Error) -> PyErr {
    Python::attach(|py| {
        let raised = RayframeError::new_err(error.to_string());
        // An exception without the attribute is better than another one.
        let _ = raised.value(py).setattr("exit_code", error.exit_code());
        raised
    })
}

/// Runs `work` on another thread without the interpreter's lock. A signal, such as Ctrl-C, cancels it.
fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&CancelFlag) -> Result<T> + Send) -> PyResult<T> {
    let cancel = CancelFlag::new();
    py.detach(|| {
        thread::scope(|threads| {
            let (sender, receiver) = channel();
            let flag = &cancel;
            let worker = threads.spawn(move || {
                let _ = sender.send(work(flag));
            });
            loop {
                match receiver.recv_timeout(TICK) {
                    Ok(result) => return result.map_err(raised),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => {
                        // The scope would panic for a thread whose panic nobody took.
                        let _ = worker.join();
                        return Err(raised(Error::Internal { message: "the renderer panicked".to_owned() }));
                    }
                }
                #[expect(
                    clippy::redundant_closure_for_method_calls,
                    reason = "the method is not general enough"
                )]
                let signals = Python::attach(|py| py.check_signals());
                if let Err(interrupt) = signals {
                    cancel.raise();
                    let _ = receiver.recv();
                    return Err(interrupt);
                }
            }
        })
    })
}

/// Runs `work` on so many threads, by default on all cores.
fn on_threads<T: Send>(threads: Option<usize>, work: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let Some(threads) = threads else { return work() };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(Error::no_threads)?;
    pool.install(work)
}

/// The settings that arguments are. Elements of a list are values of a setting that may be repeated, and else those of one value.
fn settings_of(arguments: &Arguments) -> Result<Settings> {
    let mut settings = Settings::default();
    let mut set = |name: &str, value: &OsStr| settings.set(name, value, &Provenance::Library);
    for (name, values) in arguments {
        let form = Definition::of(name).map(|setting| setting.form);
        if form.is_some_and(|form| form.is_repeated) {
            values.iter().try_for_each(|value| set(name, value))?;
        } else {
            let separator = form.and_then(|form| form.separator).unwrap_or(",");
            set(name, &values.join(OsStr::new(separator)))?;
        }
    }
    Ok(settings)
}

fn renderer(path: &Path, size: Size, arguments: &Arguments, cancel: &CancelFlag) -> Result<Renderer> {
    let mut settings = settings_of(arguments)?;
    let scale = settings.scale.clone();
    if let Some((width, height)) = size {
        let resolution = format!("{width}x{height}");
        settings.set("resolution", resolution.as_ref(), &Provenance::Library)?;
    }
    let mut renderer = Renderer::open_with(path, settings)?.cancelled_by(cancel);
    if size.is_some() {
        renderer.settings_mut().scale = scale;
    }
    Ok(renderer)
}

fn rendered(
    py: Python<'_>,
    path: &Path,
    frame: i64,
    size: Size,
    (settings, product): (&Arguments, Product),
) -> PyResult<RenderedFrame> {
    let threads = product.check(size, settings).map_err(raised)?;
    interruptible(py, |cancel| on_threads(threads, || renderer(path, size, settings, cancel)?.frame(frame)))
}

#[pyfunction]
fn render<'py>(
    py: Python<'py>,
    path: PathBuf,
    frame: i64,
    size: Size,
    settings: Arguments,
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let frame = rendered(py, &path, frame, size, (&settings, Product::Pixels))?;
    let (width, height) = frame.size();
    let values = PyArray1::from_slice(py, frame.pixels().as_flattened());
    values.reshape([height as usize, width as usize, 4])
}

#[pyfunction]
fn render_channels<'py>(
    py: Python<'py>,
    path: PathBuf,
    frame: i64,
    size: Size,
    settings: Arguments,
) -> PyResult<Bound<'py, PyDict>> {
    let frame = rendered(py, &path, frame, size, (&settings, Product::Channels))?;
    let image = frame.image().map_err(raised)?;
    let (width, height) = image.data_window.size();
    let shape = [height as usize, width as usize];
    let channels = PyDict::new(py);
    for channel in &image.channels {
        let array = match &channel.samples {
            Samples::Uint(values) => PyArray1::from_slice(py, values).reshape(shape)?.into_any(),
            samples => {
                let values = samples.floats().unwrap_or_default();
                PyArray1::from_slice(py, &values).reshape(shape)?.into_any()
            }
        };
        channels.set_item(&channel.name, array)?;
    }
    Ok(channels)
}

#[pyfunction]
fn render_sequence(
    py: Python<'_>,
    path: PathBuf,
    output: OsString,
    size: Size,
    settings: Arguments,
) -> PyResult<Vec<OsString>> {
    let threads = Product::Files.check(size, &settings).map_err(raised)?;
    let run = |cancel: &CancelFlag| {
        let sequence = renderer(&path, size, &settings, cancel)?.sequence(&output)?;
        let files = Mutex::new(BTreeMap::new());
        let done = |frame: i64, path: &Path| {
            let mut files = files.lock().unwrap_or_else(PoisonError::into_inner);
            files.insert(frame, path.as_os_str().to_owned());
        };
        let on_event = |event: SequenceEvent<'_>| match event {
            SequenceEvent::FrameWritten(report) => done(report.frame, &report.path),
            SequenceEvent::FrameKept(planned) => done(planned.frame, &planned.path),
            _ => {}
        };
        let summary = sequence.run(on_event)?;
        // With `keep_going` the run itself succeeds.
        summary.outcome()?;
        let mut files = files.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(sequence.frames().iter().filter_map(|frame| files.remove(frame)).collect())
    };
    interruptible(py, |cancel| on_threads(threads, || run(cancel)))
}

/// A file, or pixels.
#[derive(FromPyObject)]
enum Source<'py> {
    File(OsString),
    Pixels(PyReadonlyArray3<'py, f32>),
}

/// An image that was read or copied, and whether it is an array.
enum Copied {
    File(OsString),
    Pixels(Box<Image>),
}

impl Source<'_> {
    fn copied(&self) -> PyResult<Copied> {
        let pixels = match self {
            Self::File(path) => return Ok(Copied::File(path.clone())),
            Self::Pixels(pixels) => pixels,
        };
        let &[height, width, _] = pixels.shape() else {
            return Err(raised(Error::usage("an image has rows and columns".to_owned())));
        };
        let values = pixels.as_slice()?.as_chunks::<4>().0;
        let size = (u32::try_from(width)?, u32::try_from(height)?);
        Ok(Copied::Pixels(Box::new(Image::from_rgba(size, ColorEncoding::Linear, values))))
    }
}

/// The images, an array as the file would hold it that it is compared with.
fn images(actual: Copied, reference: Copied) -> Result<(Image, Image)> {
    Ok(match (actual, reference) {
        (Copied::Pixels(a), Copied::Pixels(b)) => (*a, *b),
        (Copied::File(a), Copied::File(b)) => (Image::read(a.as_ref())?, Image::read(b.as_ref())?),
        (Copied::Pixels(a), Copied::File(b)) => {
            let b = Image::read(b.as_ref())?;
            (like(*a, &b), b)
        }
        (Copied::File(a), Copied::Pixels(b)) => {
            let a = Image::read(a.as_ref())?;
            let b = like(*b, &a);
            (a, b)
        }
    })
}

/// The pixels as the file would hold them, where it holds halves alone.
fn like(pixels: Image, file: &Image) -> Image {
    let halves = file.clone().rounded_to_halves();
    let is_half = |channel: &Channel| {
        let rounded = halves.channel(&channel.name).and_then(|channel| channel.samples.floats());
        channel.samples.floats() == rounded
    };
    let is_half = file.channels_of(BEAUTY).all(is_half);
    if is_half { pixels.rounded_to_halves() } else { pixels }
}

#[pyfunction]
fn compare(
    py: Python<'_>,
    actual: Source<'_>,
    reference: Source<'_>,
    preset: &str,
) -> PyResult<(bool, Vec<String>, String)> {
    let unknown = || raised(Error::usage(format!("'{preset}' is no preset; there are {}", Preset::NAMES)));
    let limits = Preset::of_name(preset).ok_or_else(unknown)?.limits();
    let (actual, reference) = (actual.copied()?, reference.copied()?);
    interruptible(py, move |_| {
        let (actual, reference) = images(actual, reference)?;
        let comparison = rayframe::regression::compare(&actual, &reference, &limits);
        let details = serde_json::to_string(&comparison)
            .map_err(|error| Error::Internal { message: error.to_string() })?;
        Ok((comparison.passes(), comparison.failures(), details))
    })
}

#[pymodule]
fn _rayframe(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("RayframeError", module.py().get_type::<RayframeError>())?;
    module.add_function(wrap_pyfunction!(render, module)?)?;
    module.add_function(wrap_pyfunction!(render_channels, module)?)?;
    module.add_function(wrap_pyfunction!(render_sequence, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)
}
