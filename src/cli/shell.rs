//! What the shell and the manual know of the command line: both follow from its declaration.

use super::{Failure, command, print};
use clap_complete::Shell;
use clap_mangen::Man;

/// Print what lets a shell complete abbe's commands and options
///
/// bash:        abbe completions bash > ~/.local/share/bash-completion/completions/abbe
///
/// zsh:         abbe completions zsh > DIR/_abbe, where DIR is in $fpath
///
/// fish:        abbe completions fish > ~/.config/fish/completions/abbe.fish
///
/// powershell:  abbe completions powershell >> $PROFILE
#[derive(clap::Args)]
pub struct CompletionsArgs {
    /// The shell that is to complete
    shell: Shell,
}

pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "abbe", &mut script);
    print(&String::from_utf8_lossy(&script))
}

/// Print the manual page of abbe or of one of its commands
///
/// To read:     abbe man render | man -l -
///
/// To install:  abbe man render > ~/.local/share/man/man1/abbe-render.1
#[derive(clap::Args)]
pub struct ManArgs {
    /// The command that the page is about [default: abbe as a whole]
    command: Option<String>,
}

pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut abbe = command();
    abbe.build();
    let command = match &args.command {
        None => abbe,
        Some(name) => abbe.find_subcommand(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = abbe.get_subcommands().map(clap::Command::get_name).collect();
            Failure::Input(format!(
                "error: there is no command '{name}'\nhelp: the commands are {}",
                known.join(", ")
            ))
        })?,
    };
    let mut page = Vec::new();
    Man::new(command)
        .render(&mut page)
        .map_err(|error| Failure::Other(format!("error: cannot write the manual page: {error}")))?;
    print(&String::from_utf8_lossy(&page))
}
