//! Options that select a part of a suite, beside the name.

use clap::Args;

use rayframe::regression::suite::Shard;

/// Options that select a part of a suite.
#[derive(Clone, Debug, Args)]
#[group(id = "selection", multiple = true)]
pub(super) struct SelectionOptions {
    /// Only part I of N, for N machines. A shot stays in its part when others are added
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Only shots whose files differ from a revision of the git repository, or from where the branch left it
    #[arg(long, value_name = "REV")]
    changed_since: Option<String>,
}

impl SelectionOptions {
    /// The part.
    pub(super) fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// The revision.
    pub(super) fn changed_since(&self) -> Option<String> {
        self.changed_since.clone()
    }

    /// The options as words of a command.
    pub(super) fn words(&self) -> Vec<String> {
        let shard = self.shard.map(|shard| ["--shard".to_owned(), shard.to_string()]);
        let changed = self.changed_since.clone().map(|revision| ["--changed-since".to_owned(), revision]);
        shard.into_iter().chain(changed).flatten().collect()
    }
}
