//! Options of `rayframe watch`: those of `rayframe render`, with the defaults of one image.

use clap::{ArgMatches, Command, FromArgMatches};

use super::super::render_options::RenderOptions;

/// Options that choose several frames, or render none.
const HIDDEN: [&str; 5] = ["all", "start", "end", "step", "dry_run"];
/// Help of options with other defaults.
const OWN_HELP: [(&str, &str); 2] = [
    (
        "output",
        "Output name: look.png, look.exr [default: NAME.watch.png by the name of the scene or shot file; .exr where --aovs, --exr, --split-aovs, --stamp or --preview is set]",
    ),
    ("frames", "Frame to render [default: 0]"),
];

/// The typed options.
#[derive(Clone, Debug)]
pub(in crate::cli) struct WatchOptions(pub(super) RenderOptions);

impl FromArgMatches for WatchOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        RenderOptions::from_arg_matches(matches).map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0.update_from_arg_matches(matches)
    }
}

impl clap::Args for WatchOptions {
    fn augment_args(command: Command) -> Command {
        let command = RenderOptions::augment_args(command).mut_arg("scene", |arg| arg.num_args(1));
        let command =
            HIDDEN.into_iter().fold(command, |command, name| command.mut_arg(name, |arg| arg.hide(true)));
        OWN_HELP.into_iter().fold(command, |command, (name, help)| {
            command.mut_arg(name, |arg| arg.help(help).long_help(help))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
