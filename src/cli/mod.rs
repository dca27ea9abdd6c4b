//! The command line.

mod compare;
mod explain;
mod faults;
mod info;
mod merge;
mod png_options;
mod progress;
mod pulse;
mod render;
mod sampling_options;
mod scene_options;
mod shell;
mod spectrum;
mod stop;
mod study;
mod tev;
mod view;
mod whole;

use abbe::output;
use abbe::scene::Description;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::process::ExitCode;

/// A spectral, physically based Monte Carlo renderer.
///
/// abbe renders Mitsuba 3 scene files wavelength by wavelength and writes pictures that carry their own
/// error bars.
#[derive(Parser)]
#[command(version, long_version = LONG_VERSION, propagate_version = true)]
#[command(
    after_help = "Exit codes: 0 done, 2 wrong input, 3 not all that was asked for (a render was stopped by Ctrl-C, SIGTERM or SIGHUP, or has not reached its --until; parts of a merge are missing), 130 the same twice, 1 anything else (for compare: a --fail-if is met)."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Render(render::Args),
    Merge(merge::Args),
    View(view::Args),
    Compare(compare::Args),
    Explain(explain::Args),
    Info(info::Args),
    Spectrum(spectrum::Args),
    Study(study::Args),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

/// What `--version` says: also the registers that the program was compiled for.
const LONG_VERSION: &str = match () {
    () if cfg!(target_feature = "avx512f") => {
        concat!(env!("CARGO_PKG_VERSION"), "\ncompiled for AVX-512: 16 lanes in registers of 8")
    }
    () if cfg!(target_feature = "avx2") => {
        concat!(env!("CARGO_PKG_VERSION"), "\ncompiled for AVX2: 16 lanes in registers of 4")
    }
    () => concat!(env!("CARGO_PKG_VERSION"), "\ncompiled for any processor of its kind: 16 lanes in pairs"),
};

/// The command line as it is read: what an option takes may be a negative number, so that the option says
/// what it expects.
fn command() -> clap::Command {
    Cli::command().mut_subcommands(|command| {
        command.mut_args(|argument| match argument.get_long() {
            Some(_) if argument.get_action().takes_values() => argument.allow_negative_numbers(true),
            _ => argument,
        })
    })
}

/// Why a command did not do what it was asked.
pub enum Failure {
    /// The input is wrong: the user can put it right.
    Input(String),
    /// A signal ended it; what that leaves is told.
    Stopped(String),
    /// Anything else, such as a full disk.
    Other(String),
}

/// Writes a line to standard error. Where nobody reads it any more, such as after the terminal was closed,
/// the work goes on.
fn print_message(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Refuses to write over a file that a scene is read from.
fn refuse_to_replace(description: &Description, output: &Path, remedy: &str) -> Result<(), Failure> {
    if !description.files.iter().any(|file| is_same(file, output)) {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "error: {}: the scene is read from this file\nhelp: {remedy}",
        output.display()
    )))
}

/// Whether two paths lead to the same file, or would if it were there.
fn is_same(a: &Path, b: &Path) -> bool {
    let whole = |path: &Path| {
        path.canonicalize()
            .ok()
            .or_else(|| Some(output::folder_of(path).canonicalize().ok()?.join(path.file_name()?)))
    };
    whole(a).is_some_and(|a| whole(b) == Some(a))
}

/// Writes to standard output. Who reads no further, such as `head`, has had enough: that is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut output = std::io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::Other(format!("error: cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

// Not inlined: nothing of it may move before the check of the processor.
#[inline(never)]
pub fn main() -> ExitCode {
    faults::watch();
    let cli = Cli::from_arg_matches(&command().get_matches()).unwrap_or_else(|error| error.exit());
    let outcome = match cli.command {
        Command::Render(args) => render::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::View(args) => view::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Explain(args) => explain::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Spectrum(args) => spectrum::run(&args),
        Command::Study(args) => study::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    };
    let (message, code) = match outcome {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Input(message)) => (message, 2),
        Err(Failure::Stopped(message)) => (message, 3),
        Err(Failure::Other(message)) => (message, 1),
    };
    print_message(message.trim_end());
    ExitCode::from(code)
}
