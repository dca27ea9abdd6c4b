use super::{Failure, is_same};
use abbe::compare::{Comparison, Condition, Map, MapKind, Options, Unmet, compare, flip};
use abbe::output::exr::{self, Channels};
use abbe::output::png;
use std::path::{Path, PathBuf};

/// Compare a picture with a reference: error figures, colour difference, FLIP, and a test for bias
///
/// Where a file states standard errors (channels error.*), Welch's t-test tells a bias from noise, of the
/// whole picture, of tiles and of pixels. The other file may be of any program: half floats and layers are
/// read. Without errors it counts as exact; of several renders that differ in the seed, the spread is the
/// error:
///
///   abbe compare A.exr --reference b1.exr b2.exr b3.exr b4.exr
#[derive(clap::Args)]
#[command(
    override_usage = "abbe compare [OPTIONS] <A.exr> <B.exr>\n       \
                      abbe compare [OPTIONS] <A.exr>... --reference <B.exr>...",
    after_help = "Exit codes: 0 done, 1 a --fail-if is met (or a file cannot be written), 2 wrong input."
)]
pub struct Args {
    /// The picture that is judged and the reference; with --reference, renders of what is judged
    #[arg(value_name = "A.exr", required = true)]
    pictures: Vec<PathBuf>,

    /// The reference: renders of one scene that differ in the seed
    #[arg(long, value_name = "B.exr", num_args = 1..)]
    reference: Vec<PathBuf>,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,

    /// End with exit code 1 if a figure is beyond a bound, such as 'relmse>1e-3', 'p<0.01' or 'R.bias>0.01'.
    /// Names are those of the JSON. May be repeated
    #[arg(long, value_name = "CONDITION")]
    fail_if: Vec<Condition>,

    /// Write A − B: every channel to *.exr, or one in colours to *.png
    #[arg(long, value_name = "OUT.exr|png")]
    difference: Option<PathBuf>,

    /// Write the difference in standard errors
    #[arg(long, value_name = "OUT.exr|png")]
    z: Option<PathBuf>,

    /// Write the p-values of the pixels
    #[arg(long, value_name = "OUT.exr|png")]
    p_values: Option<PathBuf>,

    /// Write HDR-FLIP
    #[arg(long, value_name = "OUT.exr|png")]
    flip: Option<PathBuf>,

    /// Luminance that is white for ΔE2000 and FLIP, in the unit of the files [default: the reference's mean
    /// over 0.18]
    #[arg(long, value_name = "Y", value_parser = parse_positive)]
    white: Option<f64>,

    /// Pixels per degree of visual angle, for FLIP [default: 67, a 4K monitor 0.7 m wide from 0.7 m]
    #[arg(long, value_name = "N", value_parser = parse_pixels_per_degree)]
    ppd: Option<f64>,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    let paths = args.sides()?;
    let maps: Vec<(MapKind, &Path)> = args.maps().collect();
    for (index, &(_, path)) in maps.iter().enumerate() {
        refuse_what_cannot_be_written(path, args)?;
        if maps[..index].iter().any(|(_, earlier)| is_same(path, earlier)) {
            return refused(path, "two pictures would go into one file", "give each a name of its own");
        }
    }
    let (a, b) = (pictures(paths[0])?, pictures(paths[1])?);
    let options =
        Options { white: args.white, pixels_per_degree: args.ppd.unwrap_or(flip::PIXELS_PER_DEGREE) };
    let comparison = compare(&a, &b, &options).map_err(|mismatch| Failure::Input(mismatch.to_string()))?;
    let met = met(&args.fail_if, &comparison)?;
    let maps = maps
        .into_iter()
        .map(|(kind, path)| {
            let map = comparison.map(kind).ok_or_else(|| cannot_be_shown(path, kind))?;
            Ok((map, path))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    for (map, path) in &maps {
        write(map, path, &comparison)
            .map_err(|error| Failure::Other(format!("error: cannot write {}: {error}", path.display())))?;
    }
    // To standard error too: who reads one figure of many should not miss it.
    for assumption in &comparison.assumptions {
        eprintln!("warning: {assumption}");
    }
    let files: [Vec<String>; 2] =
        paths.map(|side| side.iter().map(|path| path.to_string_lossy().into_owned()).collect());
    let files: [&[String]; 2] = files.each_ref().map(Vec::as_slice);
    if args.json {
        super::print(&comparison.json(files))?;
    } else {
        super::print(&comparison.table(files))?;
        for (map, path) in &maps {
            super::print(&format!("{}: {}\n", path.display(), map.legend()))?;
        }
    }
    if met.is_empty() { Ok(()) } else { Err(Failure::Other(met.join("\n"))) }
}

impl Args {
    /// The pictures of A and of B.
    fn sides(&self) -> Result<[&[PathBuf]; 2], Failure> {
        match (self.pictures.as_slice(), self.reference.as_slice()) {
            ([a, b], []) => Ok([std::slice::from_ref(a), std::slice::from_ref(b)]),
            (a, b @ [_, ..]) => Ok([a, b]),
            ([_], []) => Err(Failure::Input(
                "error: there is one picture, and nothing to compare it with\nhelp: abbe compare A.exr B.exr"
                    .to_owned(),
            )),
            (several, []) => Err(Failure::Input(format!(
                "error: it is not clear which of {} pictures are the reference\n\
                 help: put --reference before those that are: abbe compare A.exr --reference b1.exr b2.exr",
                several.len()
            ))),
        }
    }

    fn maps(&self) -> impl Iterator<Item = (MapKind, &Path)> {
        let wanted = [
            (MapKind::Difference, &self.difference),
            (MapKind::Z, &self.z),
            (MapKind::PValues, &self.p_values),
            (MapKind::Flip, &self.flip),
        ];
        wanted.into_iter().filter_map(|(kind, path)| Some((kind, path.as_deref()?)))
    }
}

/// The picture of each file.
fn pictures(files: &[PathBuf]) -> Result<Vec<Channels>, Failure> {
    let found = files.iter().map(|path| {
        exr::read(path).map_err(|error| {
            Failure::Input(format!(
                "error: {}: {error}\nhelp: expected an OpenEXR file with flat channels, as abbe render writes it",
                path.display()
            ))
        })
    });
    found.collect()
}

fn extension(path: &Path) -> &str {
    path.extension().and_then(|extension| extension.to_str()).unwrap_or("")
}

fn refused(path: &Path, problem: &str, remedy: &str) -> Result<(), Failure> {
    Err(Failure::Input(format!("error: {}: {problem}\nhelp: {remedy}", path.display())))
}

fn refuse_what_cannot_be_written(path: &Path, args: &Args) -> Result<(), Failure> {
    if !["exr", "png"].contains(&extension(path)) {
        return refused(
            path,
            "the picture must be of a known kind",
            "name it *.exr for numbers or *.png for colours",
        );
    }
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return refused(path, &format!("there is no folder {}", folder.display()), "make it first");
    }
    if args.pictures.iter().chain(&args.reference).any(|compared| is_same(path, compared)) {
        return refused(path, "the picture would go over one that is compared", "give it another name");
    }
    Ok(())
}

/// The conditions that hold, each with the value that met it.
fn met(conditions: &[Condition], comparison: &Comparison) -> Result<Vec<String>, Failure> {
    let figures = comparison.figures();
    let mut met = Vec::new();
    for condition in conditions {
        match condition.holds(&figures) {
            Ok(None) => {}
            Ok(Some(value)) => met.push(format!("failed: {condition}: it is {value:e}")),
            Err(Unmet::Unknown(name)) => {
                let names: Vec<&str> = figures.iter().map(|(name, _)| name.as_str()).collect();
                return Err(Failure::Input(format!(
                    "error: --fail-if: there is no figure '{name}'\nhelp: these files have {}",
                    names.join(", ")
                )));
            }
            Err(Unmet::WithoutValue(name)) => {
                return Err(Failure::Input(format!(
                    "error: --fail-if: '{name}' is not known for these files\n\
                     help: p-values and bounds of detection need a file with errors (channels error.*) or several \
                     renders of one side, delta_e and FLIP need colours"
                )));
            }
        }
    }
    Ok(met)
}

fn cannot_be_shown(path: &Path, kind: MapKind) -> Failure {
    let needed = match kind {
        MapKind::Flip => "colours: channels R G B, X Y Z or Y in both files",
        _ => "errors: channels error.* in one of the files, or several renders of one side",
    };
    Failure::Input(format!(
        "error: {}: these files do not have what it shows\nhelp: it needs {needed}",
        path.display()
    ))
}

fn write(map: &Map, path: &Path, comparison: &Comparison) -> std::io::Result<()> {
    if extension(path) == "png" {
        return png::write_colours(path, comparison.width, &map.colours());
    }
    let single = |(name, values): &(String, Vec<f64>)| {
        (name.clone(), values.iter().map(|&value| value as f32).collect::<Vec<f32>>())
    };
    let channels: Vec<_> = map.channels.iter().map(single).collect();
    exr::write_channels(path, [comparison.width, comparison.height], &channels)
}

fn parse_positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|value| value.is_finite() && *value > 0.0);
    value.ok_or_else(|| "expected a number above 0".to_owned())
}

fn parse_pixels_per_degree(text: &str) -> Result<f64, String> {
    // The filters' radius in pixels grows with it.
    let value = text.parse::<f64>().ok().filter(|value| (1.0..=1000.0).contains(value));
    value.ok_or_else(|| "expected a number of pixels from 1 to 1000".to_owned())
}
