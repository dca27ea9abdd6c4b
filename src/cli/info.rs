use super::Failure;
use super::scene_options::SceneOptions;
use abbe::scene::{CompileOptions, compile, json, outline};

/// Say what a scene is: everything that its file means with the defaults filled in, the extensions and assumptions
/// that it makes, and what the renderer will skip because the scene has no need of it
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Say it in JSON, shaped like Mitsuba's dictionaries. It can be rendered in the place of the scene file
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let description = args.scene.read()?;
    let scene = compile(&description, &CompileOptions::default())
        .map_err(|errors| Failure::Input(errors.to_string()))?;
    if args.json {
        print!("{}", json(&description, &scene.needs(), None));
    } else {
        print!("{}", outline(&description));
        println!("renderer: {}", scene.needs());
    }
    Ok(())
}
