//! The pictures of an animation, one after another.

use super::super::Failure;
use super::{Args, cannot_read_content, has_extension};
use abbe::output::exr;
use abbe::scene::Description;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Which pictures of an animation are rendered.
#[derive(clap::Args)]
#[command(next_help_heading = "Animations")]
pub struct FrameOptions {
    /// Render frames A to B − 1, each to a file of its own: the name given with -o has %d, or %04d for four
    /// digits, in place of the number. In frame N the shutter opens and closes N / FPS later than the scene
    /// says, and N is added to the seed. Implies --checkpoint, until the frame is complete. With --resume
    /// complete frames are skipped
    #[arg(long, value_name = "A..B", value_parser = parse_frames, allow_hyphen_values = true, requires = "output", conflicts_with = "samples")]
    pub frames: Option<Range<u32>>,

    /// Frames per unit of the scene's time
    #[arg(long, value_name = "FPS", default_value = "24", value_parser = parse_rate, requires = "frames")]
    pub fps: f64,
}

impl FrameOptions {
    /// The scene as it is in a frame.
    pub fn of_frame(&self, frame: u32, mut description: Description) -> Description {
        let sensor = &mut description.sensor;
        let later = f64::from(frame) / self.fps;
        sensor.shutter.open += later;
        sensor.shutter.close += later;
        sensor.sampler.seed = sensor.sampler.seed.wrapping_add(u64::from(frame));
        description
    }
}

/// The file of a frame: `%d` or `%0Nd` in the name stands for its number.
pub fn path_of_frame(pattern: &Path, frame: u32) -> Result<PathBuf, Failure> {
    let refused = || {
        Failure::Input(format!(
            "error: {}: every frame would have the same file\n\
             help: write %04d where the number of the frame belongs, such as -o turn-%04d.exr",
            pattern.display()
        ))
    };
    let text = pattern.to_str().ok_or_else(refused)?;
    let (before, rest) = text.split_once('%').ok_or_else(refused)?;
    let (digits, after) = rest.split_once('d').ok_or_else(refused)?;
    let width = match digits {
        "" => 0,
        _ => digits.strip_prefix('0').and_then(|width| width.parse::<usize>().ok()).ok_or_else(refused)?,
    };
    if width > 20 || after.contains('%') || !has_extension(pattern, "exr") {
        return Err(refused());
    }
    Ok(PathBuf::from(format!("{before}{frame:0width$}{after}")))
}

/// Whether the file of a frame holds all of it: it is there, nothing of it is still to be done, and it is the
/// picture that is asked for. A picture of something else is refused.
pub fn is_complete(
    args: &Args,
    path: &Path,
    attributes: &[(String, String)],
    png: Option<&Path>,
    checkpoint: Option<&Path>,
) -> Result<bool, Failure> {
    if !args.long.resumes() || !path.exists() || checkpoint.is_some_and(Path::exists) {
        return Ok(false);
    }
    let found = exr::read(path)
        .map_err(|error| cannot_read_content(path, &error, "remove it, and the frame is rendered again"))?;
    // The hash of the scene last: what else differs tells more.
    let by_hash = |(name, _): &&(String, String)| name == "abbe.sceneHash";
    let (hash, rest): (Vec<_>, Vec<_>) = attributes.iter().partition(by_hash);
    for (name, here) in rest.into_iter().chain(hash) {
        let there = found.attribute(name).unwrap_or("nothing");
        if there != here {
            return Err(Failure::Input(format!(
                "error: {} is another picture: {name} is {there} there and {here} here\n\
                 help: resume as it was begun, or give another -o",
                path.display()
            )));
        }
    }
    Ok(png.is_none_or(Path::exists))
}

fn parse_frames(text: &str) -> Result<Range<u32>, String> {
    let ends =
        text.split_once("..").and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
    match ends {
        Some((start, end)) if start < end => Ok(start..end),
        _ => Err("expected A..B, frames A to B − 1, for example 0..48".to_owned()),
    }
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate > 0.0 && rate.is_finite() => Ok(rate),
        _ => Err("expected a number above 0, for example 24".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_the_number_of_the_frame() {
        let named = |pattern: &str| path_of_frame(Path::new(pattern), 37).ok();
        for (pattern, name) in [
            ("turn-%04d.exr", "turn-0037.exr"),
            ("%d.exr", "37.exr"),
            ("a/%02d/x.exr", "a/37/x.exr"),
            ("%01d.exr", "37.exr"),
        ] {
            assert_eq!(named(pattern), Some(PathBuf::from(name)), "{pattern}");
        }
        for wrong in ["turn.exr", "%.exr", "%4d.exr", "%04x.exr", "%d-%d.exr", "%d.checkpoint", "%099d.exr"] {
            assert_eq!(named(wrong), None, "{wrong}");
        }
        assert_eq!(parse_frames("3..7"), Ok(3..7));
        assert!(["3", "7..3", "3..3", "-1..3", "a..b"].iter().all(|text| parse_frames(text).is_err()));
        assert!(["0", "-1", "nan", "inf", "x"].iter().all(|text| parse_rate(text).is_err()));
    }
}
