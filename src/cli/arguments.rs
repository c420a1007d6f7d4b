//! From the words of the command line to typed arguments.

use std::ffi::OsString;
use std::path::Path;

use clap::builder::ValueParser;
use clap::error::ErrorKind;
use clap::{ArgMatches, Command, Error, Parser};

use rayframe::settings::check_expanded;

/// Parses `arguments` (the program's name first).
pub(super) fn parse<P: Parser>(arguments: impl IntoIterator<Item = OsString>) -> Result<P, Error> {
    let mut program = P::command();
    let matches = program.try_get_matches_from_mut(arguments)?;
    check_home_folders(&mut program, &matches)?;
    P::from_arg_matches(&matches)
}

/// Refuses files and folders below `~/`, as the settings do.
fn check_home_folders(command: &mut Command, matches: &ArgMatches) -> Result<(), Error> {
    let paths = ValueParser::path_buf().type_id();
    let refused = command
        .get_arguments()
        .filter(|option| option.get_value_parser().type_id() == paths)
        .find_map(|option| {
            let mut given = matches.get_raw(option.get_id().as_str())?;
            let error = given.find_map(|path| check_expanded(Path::new(path)).err())?;
            let name = option.get_long().map_or_else(|| option.to_string(), |long| format!("--{long}"));
            Some(format!("{name}: {error}"))
        });
    if let Some(message) = refused {
        return Err(command.error(ErrorKind::ValueValidation, message));
    }
    match matches.subcommand() {
        Some((name, matches)) => {
            command.find_subcommand_mut(name).map_or(Ok(()), |command| check_home_folders(command, matches))
        }
        None => Ok(()),
    }
}
