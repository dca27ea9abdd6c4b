//! A picture in a browser, finished or in the making.

mod growing;
mod server;

use super::render::{self, cannot_read_content, has_extension};
use super::stop::stop_on_signal;
use super::{Failure, print_message};
use abbe::output::exr;
use clap::parser::ValueSource;
pub use growing::Page;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Show a picture in a browser: an EXR, or a scene while it is rendered
///
/// Serves a page on this machine alone, at an address that it prints, until Ctrl-C. A scene is rendered as by
/// abbe render, with the same options and the same files in the end; the page shows the picture as it grows.
/// An EXR file takes no option but --port.
/// Under the cursor it tells all channels, and spectral bins with their standard errors.
#[derive(clap::Args)]
#[group(skip)]
pub struct Args {
    /// Port of the page [default: one that is free]
    #[arg(long, value_name = "N", default_value = "0", hide_default_value = true)]
    port: u16,

    #[command(flatten)]
    render: render::Args,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let path = args.render.scene_path();
    let page = Arc::new(Page::new(&path.to_string_lossy()));
    if !has_extension(path, "exr") {
        return render::run_shown(&args.render, Some(&page), || serve(&page, args.port));
    }
    if let Some(option) = option_of_render() {
        return Err(Failure::Input(format!(
            "error: --{option}: {} is shown as it is\nhelp: leave it out, or name a scene",
            path.display()
        )));
    }
    let picture = exr::Stored::open(path).map_err(|error| {
        cannot_read_content(path, &error, "expected an OpenEXR file, as abbe render writes it")
    })?;
    page.finished(Some(picture));
    let stop = stop_on_signal()?;
    serve(&page, args.port)?;
    wait(&stop);
    Ok(())
}

/// An option that was given and says how a scene is rendered.
fn option_of_render() -> Option<String> {
    let mut command = super::command();
    let matches = command.get_matches_mut();
    let (name, view) = matches.subcommand()?;
    let is_given = |option: &&clap::Arg| {
        view.try_contains_id(option.get_id().as_str()).unwrap_or(false)
            && view.value_source(option.get_id().as_str()) == Some(ValueSource::CommandLine)
    };
    let given = command.find_subcommand(name)?.get_arguments().filter(is_given);
    given.filter_map(clap::Arg::get_long).find(|&name| name != "port").map(str::to_owned)
}

/// Until a signal ends it.
pub fn wait(stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn serve(page: &Arc<Page>, port: u16) -> Result<(), Failure> {
    let address = server::serve(page.clone(), port).map_err(|error| {
        Failure::Other(format!(
            "error: cannot serve a page at port {port}: {error}\nhelp: give another --port, or none"
        ))
    })?;
    print_message(&format!("http://{address}/ shows it until Ctrl-C"));
    Ok(())
}
