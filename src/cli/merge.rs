use super::png_options::PngOptions;
use super::render::{
    cannot_read_content, cannot_write, counted, has_extension, no_room_for_bins, sample_count,
};
use super::{Failure, print, print_message};
use abbe::film::{Film, Storage};
use abbe::output::checkpoint::merge::{Plan, Refusal, plan};
use abbe::output::checkpoint::{self, Description, Header, RenderPart};
use abbe::output::{self, Picture};
use abbe::render::Auxiliary;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Put a picture together from parts of it
///
/// Parts are the checkpoints of abbe render, with --samples or --crop or both. Their samples are those of the
/// whole picture, so what is put together has the bits of a render in one go, in whatever order the parts are
/// given. What is given twice counts once; overlaps and parts of another scene, seed, build or other settings
/// are refused. What is missing is told as options of abbe render.
#[derive(clap::Args)]
#[command(
    after_help = "Exit codes: 0 done, 2 wrong input, 3 something is missing (what there is, is written), 1 anything else."
)]
pub struct Args {
    /// Checkpoints of parts of one picture
    #[arg(value_name = "PART.checkpoint", required = true)]
    parts: Vec<PathBuf>,

    /// Where to write the picture, and a PNG beside it; or *.checkpoint, to merge it with others later
    #[arg(short, long, value_name = "OUT.exr|checkpoint")]
    output: PathBuf,

    /// Print what is there and what is missing as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    png: PngOptions,

    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// What to do about a part that is damaged.
const ANEW: &str = "render this part again, or leave it out: what is missing is told";

pub fn run(args: &Args) -> Result<(), Failure> {
    let is_picture = has_extension(&args.output, "exr");
    if !is_picture && !has_extension(&args.output, checkpoint::EXTENSION) {
        return Err(Failure::Input(format!(
            "error: {}: name the output *.exr, or *.{}",
            args.output.display(),
            checkpoint::EXTENSION
        )));
    }
    args.png.refuse_without_png(is_picture)?;
    if let Some(path) = args.parts.iter().find(|path| has_extension(path, "exr")) {
        return Err(Failure::Input(format!(
            "error: {}: pictures are rounded; parts are put together from their checkpoints\n\
             help: render them with --checkpoint, and give {}",
            path.display(),
            path.with_extension(checkpoint::EXTENSION).display()
        )));
    }
    let mut files: Vec<(Header, u32)> = Vec::new();
    for path in &args.parts {
        let opened = checkpoint::open(path).map_err(|error| cannot_read_content(path, &error, ANEW))?;
        files.push((opened.header, opened.digest));
    }
    let told: Vec<(&Header, u32)> = files.iter().map(|(header, digest)| (header, *digest)).collect();
    let plan = plan(&told).map_err(|refusal| args.refused(&refusal))?;
    let header = &files[0].0;
    let is_written = is_written(&plan, header);
    if is_written {
        let png = args.output.with_extension("png");
        let png = (is_picture && args.png.is_wanted()).then_some(png);
        for path in std::iter::once(&args.output).chain(&png) {
            output::refuse_unwritable(path).map_err(|error| cannot_write(path, &error))?;
        }
        let folder = output::folder_of(&args.output);
        let film = header
            .film
            .film(Storage::Folder(folder), plan.extent)
            .map_err(|error| no_room_for_bins(folder, &error))?;
        let (film, images) = plan
            .add_up(film, |file| checkpoint::open(&args.parts[file]))
            .map_err(|(file, error)| cannot_read_content(&args.parts[file], &error, ANEW))?;
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |error| cannot_write(&path, &error)
        };
        if is_picture {
            let picture = picture(&film, &header.picture, images);
            output::exr::write(&args.output, &picture).map_err(failed(&args.output))?;
            if let Some(png) = &png {
                args.png.write(png, &picture).map_err(failed(png))?;
            }
        } else {
            write(&args.output, header, &plan, &film, &images).map_err(failed(&args.output))?;
        }
        if !args.quiet && !args.json {
            print_message(&format!(
                "{}: {} samples per pixel of {} {}",
                args.output.display(),
                sample_count(&film.samples_per_pixel()),
                plan.used.len(),
                if plan.used.len() == 1 { "part" } else { "parts" }
            ));
        }
    }
    if args.json {
        print(&args.told_as_json(&plan, header, is_written))?;
    } else if !args.quiet {
        for &file in &plan.redundant {
            print_message(&format!("{}: all of it is in others", args.parts[file].display()));
        }
    }
    if plan.missing.is_empty() { Ok(()) } else { Err(args.missing(&plan, header, is_written)) }
}

/// Whether there is a picture to write: light subpaths are counted for all pixels together.
fn is_written(plan: &Plan, header: &Header) -> bool {
    !plan.used.is_empty() && (!header.film.extras.light_paths || plan.is_even(header.samples_per_pixel))
}

fn picture<'a>(film: &'a Film, description: &Description, auxiliary: Vec<Auxiliary>) -> Picture<'a> {
    let Description { content, moments, attributes } = description.clone();
    Picture { film, content, moments, auxiliary, attributes: [attributes, counted(film)].concat() }
}

/// Writes a part that is put together from others.
fn write(path: &Path, first: &Header, plan: &Plan, film: &Film, images: &[Auxiliary]) -> std::io::Result<()> {
    let header = Header {
        film: checkpoint::Measures::of(film),
        holds: plan.holds.clone(),
        render: None,
        bad: film.bad,
        light_paths: film.light_counts().to_vec(),
        images: images.iter().map(|image| (image.name.clone(), image.errors.is_some())).collect(),
        ..first.clone()
    };
    checkpoint::write(path, &header, film, images, rayon::current_num_threads())
}

impl Args {
    fn name(&self, file: usize) -> std::path::Display<'_> {
        self.parts[file].display()
    }

    fn refused(&self, refusal: &Refusal) -> Failure {
        Failure::Input(match refusal {
            Refusal::Different { files: [a, b], what, values: [first, second] } => format!(
                "error: {} and {} are of different pictures: {what} is {first} and {second}",
                self.name(*a),
                self.name(*b)
            ),
            Refusal::Overlap { files: [a, b], part } => format!(
                "error: {} and {} overlap: both hold {part}, and neither holds all of the other\nhelp: leave one of them out",
                self.name(*a),
                self.name(*b)
            ),
            Refusal::Contradiction { files: [a, b] } => format!(
                "error: {} and {} hold the same samples with different sums\n\
                 help: one of them comes from a machine that computes otherwise; render it again",
                self.name(*a),
                self.name(*b)
            ),
        })
    }

    /// How the parts that are missing can be had.
    fn missing(&self, plan: &Plan, header: &Header, is_written: bool) -> Failure {
        let mut lines = vec![match is_written {
            true => "something is missing; what there is, is written:".to_owned(),
            false => "something is missing, and nothing is written:".to_owned(),
        }];
        lines.extend(plan.missing.iter().map(|part| format!("missing: {}", options(part, plan, header))));
        let unfinished = |&file: &usize| format!("{}: interrupted; --resume it", self.name(file));
        lines.extend(plan.unfinished.iter().map(unfinished));
        Failure::Stopped(lines.join("\n"))
    }

    fn told_as_json(&self, plan: &Plan, header: &Header, is_written: bool) -> String {
        let names = |files: &[usize]| -> Vec<String> {
            files.iter().map(|&file| self.parts[file].to_string_lossy().into_owned()).collect()
        };
        let parts = |parts: &[RenderPart]| -> Vec<serde_json::Value> {
            let told = |part: &RenderPart| {
                let [[x, y], [width, height]] = [part.region.offset, part.region.size];
                json!({ "samples": [part.samples.start, part.samples.end], "crop": [x, y, width, height] })
            };
            parts.iter().map(told).collect()
        };
        let told = json!({
            "output": is_written.then(|| self.output.to_string_lossy()),
            "samples_per_pixel": header.samples_per_pixel,
            "used": names(&plan.used),
            "redundant": names(&plan.redundant),
            "unfinished": names(&plan.unfinished),
            "holds": parts(&plan.holds),
            "missing": parts(&plan.missing),
        });
        format!("{told:#}\n")
    }
}

/// A part as options of abbe render. A crop of all pixels is none.
fn options(part: &RenderPart, plan: &Plan, header: &Header) -> String {
    let told = part.to_string();
    let is_whole = part.region == header.film.extent.window && part.region == plan.extent.shown;
    match told.split_once(" --crop") {
        Some((samples, _)) if is_whole => samples.to_owned(),
        _ => told,
    }
}
