//! The program `abbe`: see `abbe --help`.

mod cli;
#[cfg(target_arch = "x86_64")]
mod processor;

fn main() -> std::process::ExitCode {
    #[cfg(target_arch = "x86_64")]
    processor::demand();
    cli::main()
}
