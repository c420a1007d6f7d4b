//! Opens the report in a browser.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::progress::print_warning;

/// The program that opens a file as the desktop would.
const OPENER: &str = if cfg!(target_os = "macos") {
    "open"
} else if cfg!(windows) {
    "explorer"
} else {
    "xdg-open"
};

/// Opens `page`, or warns that it cannot.
pub(super) fn open_in_browser(page: &Path) {
    let mut command = Command::new(OPENER);
    command.arg(page).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    if let Err(error) = command.spawn() {
        print_warning(&format!("{} cannot be opened: {}: {error}", page.display(), OPENER));
    }
}
