//! The speed of ray queries, beside that of other programs in turn: on one thread, one ray a call, the same
//! rays.
//!
//! `cargo run --release -p abbe-validation --bin rays` measures abbe alone, and `validation/speed/rays/run`
//! beside Embree.

mod scene;
mod serve;
mod turns;

use clap::{Args, Parser, Subcommand};
use std::error::Error;
use std::path::PathBuf;

/// How fast rays are answered
#[derive(Parser)]
#[command(args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    measure: Measure,
}

#[derive(Subcommand)]
enum Command {
    /// Answers the rays of a file whenever it is asked to on standard input: the part of one program in a
    /// comparison
    Serve { file: PathBuf },
}

#[derive(Args)]
struct Measure {
    /// About how many triangles, scene after scene
    #[arg(long, value_delimiter = ',', default_values_t = [10_000, 1_000_000])]
    triangles: Vec<usize>,
    /// How many rays of each kind
    #[arg(long, default_value_t = 1_000_000)]
    rays: usize,
    /// How often each program answers them; the medians are shown
    #[arg(long, default_value_t = 9)]
    rounds: usize,
    /// A program to measure in turn with this one, called with the file of rays; may be repeated
    #[arg(long = "beside", value_name = "COMMAND")]
    beside: Vec<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let cli = Cli::parse();
    match cli.command {
        Some(Command::Serve { file }) => serve::serve(&file),
        None => turns::measure(&cli.measure),
    }
}
