use super::scene_options::SceneOptions;
use super::{Failure, refuse_to_replace};
use abbe::integrator::why_nothing_is_shared;
use abbe::output::write_whole;
use abbe::scene::{CompileOptions, compile, json, outline};
use std::path::{Path, PathBuf};

/// Say what a scene is: everything that its file means with the defaults filled in, the extensions and
/// assumptions that it makes, and what the renderer will skip because the scene has no need of it
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Say it in JSON, shaped like Mitsuba's dictionaries. It can be rendered in place of the scene file
    #[arg(long)]
    json: bool,

    /// Write it to a file. JSON then names meshes and images relative to that file, else by their whole path
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let description = args.scene.read()?;
    if let Some(path) = &args.output {
        refuse_to_replace(&description, path, "give the output another name")?;
    }
    let range = description.sensor.film.wavelength_range();
    let mut description = description.over(range);
    let scene = compile(&description, &CompileOptions::default())
        .map_err(|errors| Failure::Input(errors.to_string()))?;
    description.remarks.extend(scene.warnings.iter().cloned());
    let folder = args.output.as_ref().map(|path| match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    });
    let text = if args.json {
        json(&description, &scene.features(), folder)
    } else {
        let shared = why_nothing_is_shared(&scene).map_or_else(
            || "light at diffuse and glossy surfaces, where it pays".to_owned(),
            |reason| format!("nothing, because {reason}"),
        );
        format!("{}renderer: {}\nshared between pixels: {shared}\n", outline(&description), scene.features())
    };
    match &args.output {
        Some(path) => write_whole(path, text.as_bytes())
            .map_err(|error| Failure::Other(format!("error: cannot write {}: {error}", path.display()))),
        None => super::print(&text),
    }
}
