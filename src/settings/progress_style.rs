/// Progress output style.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgressStyle {
    /// Bars on a terminal, plain lines elsewhere.
    #[default]
    Auto,
    /// Bars.
    Bar,
    /// One line a frame.
    Plain,
    /// One JSON object a line, on the standard output.
    Json,
    /// The lines that Open Job Description knows, on the standard output.
    OpenJd,
    /// No output.
    None,
}
