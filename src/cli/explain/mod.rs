mod picture;
mod text;

use super::render::{cannot_write, thread_pool};
use super::sampling_options::SamplingOptions;
use super::scene_options::SceneOptions;
use super::whole::whole;
use super::{Failure, refuse_to_replace};
use abbe::output::write_whole;
use abbe::render::{Wanted, explain};
use abbe::scene::compile;
use std::path::PathBuf;

/// Tell what one sample of a picture is made of: its path vertex by vertex, with what each wavelength
/// carries, the light samples, and why the path ends
///
/// Give the options that the picture was rendered with: the sample is then the very one that is in it. With
/// the estimator plain a sample is one path, and the path is all of it. With shared the sample is told as the
/// sum of its own light and of what the paths of the pixels of its group bring to it. Where one of these
/// brings more than its own light, the one that brings the most is told as that pixel alone would follow it:
/// up to its second surface it is the one that is shared, and beyond it Russian roulette may decide
/// otherwise. Else the sample's own path is told. Light subpaths are not told.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneOptions,

    /// Which pixel: column and row from the upper left corner of the whole film, from 0
    #[arg(long, value_name = "X,Y", value_parser = parse_pixel, allow_hyphen_values = true)]
    pixel: [u32; 2],

    /// Which of the pixel's own samples, from 0 [default: the one that brings the most to the pixel, its own
    /// or a neighbour's that the filter spreads over it]
    #[arg(long, value_name = "K", value_parser = whole::<u64>(0..=u64::MAX))]
    sample: Option<u64>,

    #[command(flatten)]
    sampling: SamplingOptions,

    /// Threads for the pilots [default: as many as there are cores]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=1024))]
    threads: Option<u32>,

    /// Print JSON
    #[arg(long)]
    json: bool,

    /// Draw the path in two projections, as SVG or PNG
    #[arg(long, value_name = "OUT.svg|png")]
    svg: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let mut description = args.scene.read()?;
    if let Some(path) = &args.svg {
        refuse_to_replace(&description, path, "give the drawing another name")?;
    }
    args.sampling.apply_to(&mut description, None)?;
    let range = args.sampling.range(&description);
    let description = description.over(range);
    let options = args.sampling.compile_options(range);
    let scene = compile(&description, &options).map_err(|errors| Failure::Input(errors.to_string()))?;
    let settings = args.sampling.settings(&description, range);
    super::render::refuse_what_no_memory_holds(&scene, &settings)?;
    let wanted = args.sample.map_or(Wanted::Brightest, Wanted::Sample);
    let explained = thread_pool(args.threads)?
        .install(|| explain(&scene, &settings, args.pixel, wanted))
        .map_err(|problem| Failure::Input(format!("error: {problem}")))?;
    if let Some(path) = &args.svg {
        let drawing = picture::draw(&explained);
        let bytes = drawing
            .file(path)
            .map_err(|problem| Failure::Input(format!("error: --svg {}: {problem}", path.display())))?;
        write_whole(path, &bytes).map_err(|error| cannot_write(path, &error))?;
    }
    if args.json {
        let json = serde_json::to_string_pretty(&explained)
            .map_err(|error| Failure::Other(format!("error: cannot write JSON: {error}")))?;
        return super::print(&format!("{json}\n"));
    }
    super::print(&text::tell(&explained, &description, scene.light_tracing().is_some()))
}

fn parse_pixel(text: &str) -> Result<[u32; 2], String> {
    let pixel =
        text.split_once(',').and_then(|(x, y)| Some([x.trim().parse().ok()?, y.trim().parse().ok()?]));
    pixel.ok_or_else(|| "expected X,Y, a column and a row from 0, for example 120,45".to_owned())
}
