//! `rayframe man`: manual pages, one for the program and one for each verb.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use crate::progress::{print_generated, print_output};
use rayframe::error::{Error, Result};
use rayframe::image_file::{OutputKind, check_output, probe_folder, write_atomically};

/// Options of `rayframe man`.
#[derive(Clone, Debug, Args)]
pub(super) struct ManArgs {
    /// The verb; without it, the program
    #[arg(value_name = "VERB")]
    verb: Option<String>,
    /// Write all pages into this folder, such as ~/.local/share/man/man1
    #[arg(long, value_name = "FOLDER", conflicts_with = "verb")]
    folder: Option<PathBuf>,
}

/// Prints a page, or writes all.
///
/// # Errors
/// [`Error::Usage`] for an unknown verb, and those of writing.
pub(super) fn run(args: &ManArgs, mut program: Command) -> Result<()> {
    // Fills in what commands inherit from the program.
    program.build();
    let Some(folder) = &args.folder else {
        let command = match &args.verb {
            None => &program,
            Some(verb) => {
                program.find_subcommand(verb).ok_or_else(|| Error::usage(unknown_verb(verb, &program)))?
            }
        };
        print_generated(&String::from_utf8_lossy(&page(command)?.1));
        return Ok(());
    };
    let pages: Result<Vec<_>> =
        std::iter::once(&program).chain(program.get_subcommands()).map(page).collect();
    let pages: Vec<_> = pages?.into_iter().map(|(name, text)| (folder.join(name), text)).collect();
    for (path, _) in &pages {
        probe_folder(path)?;
        check_output(path, OutputKind::ManualPage, false)?;
    }
    for (path, text) in &pages {
        write_atomically(path, text)?;
        print_output(&path.display().to_string());
    }
    Ok(())
}

fn unknown_verb(verb: &str, program: &Command) -> String {
    let verbs = program.get_subcommands().filter(|command| !command.is_hide_set());
    let verbs: Vec<_> = verbs.map(Command::get_name).collect();
    format!("'{verb}' is no verb of rayframe; there are {}", verbs.join(", "))
}

/// The name and the contents of a command's page.
fn page(command: &Command) -> Result<(String, Vec<u8>)> {
    let version = concat!("rayframe ", env!("CARGO_PKG_VERSION"));
    let man = Man::new(command.clone()).manual("Rayframe").source(version);
    let mut text = Vec::new();
    man.render(&mut text).map_err(|error| Error::Internal { message: format!("manual page: {error}") })?;
    Ok((man.get_filename(), text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbs_are_listed_where_one_is_not_known() {
        let verbs = [Command::new("render"), Command::new("old").hide(true), Command::new("info")];
        let program = Command::new("rayframe").subcommands(verbs);
        assert_eq!(unknown_verb("rendr", &program), "'rendr' is no verb of rayframe; there are render, info");
    }
}
