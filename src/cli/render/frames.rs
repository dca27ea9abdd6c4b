//! The pictures of an animation, one after another.

use super::super::Failure;
use super::{Args, cannot_read_content, has_extension, report};
use abbe::output::exr;
use abbe::scene::Description;
use std::ffi::OsStr;
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

/// The file of a frame: `%d` or `%0Nd` in its name, not in that of its folder, stands for its number.
pub fn path_of_frame(pattern: &Path, frame: u32) -> Result<PathBuf, Failure> {
    let refused = |problem: &str| {
        Failure::Input(format!(
            "error: {}: {problem}\n\
             help: write %04d once, where the number of the frame belongs, such as -o turn-%04d.exr",
            pattern.display()
        ))
    };
    let text = |part: Option<&OsStr>| part.and_then(OsStr::to_str).unwrap_or_default().to_owned();
    let (folder, name) = (text(pattern.parent().map(Path::as_os_str)), text(pattern.file_name()));
    let mut pieces = name.split('%');
    let (Some(before), Some(rest)) = (pieces.next(), pieces.next()) else {
        return Err(refused(match folder.contains('%') {
            true => "the number of the frame belongs into the name of the file, not of its folder",
            false => "every frame would have the same file",
        }));
    };
    if pieces.next().is_some() {
        return Err(refused("the number of the frame may stand in the name once"));
    }
    if !has_extension(pattern, "exr") {
        return Err(refused("frames are EXR files"));
    }
    let (width, after) = numbering(rest).ok_or_else(|| refused("% stands before something else than d"))?;
    Ok(pattern.with_file_name(format!("{before}{frame:0width$}{after}")))
}

/// How many digits a number has at least, and what follows it, of what stands behind `%`.
fn numbering(text: &str) -> Option<(usize, &str)> {
    let (digits, after) = text.split_once('d')?;
    let width = match digits {
        "" => 0,
        _ => digits.strip_prefix('0')?.parse().ok()?,
    };
    (width <= 20).then_some((width, after))
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
            let what = if name == report::ASKED_SAMPLES { "the number of samples per pixel" } else { name };
            return Err(Failure::Input(format!(
                "error: {} is another picture: {what} is {there} there and {here} here\n\
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
            ("a%/%02d.exr", "a%/37.exr"),
            ("%01d.exr", "37.exr"),
        ] {
            assert_eq!(named(pattern), Some(PathBuf::from(name)), "{pattern}");
        }
        for (wrong, problem) in [
            ("turn.exr", "the same file"),
            ("turn%d/x.exr", "not of its folder"),
            ("%d-%d.exr", "once"),
            ("%d.checkpoint", "EXR files"),
            ("%.exr", "something else than d"),
            ("%4d.exr", "something else than d"),
            ("%04x.exr", "something else than d"),
            ("%099d.exr", "something else than d"),
        ] {
            let Err(Failure::Input(told)) = path_of_frame(Path::new(wrong), 37) else { panic!("{wrong}") };
            assert!(told.contains(problem) && told.contains("help: "), "{told}");
        }
        assert_eq!(parse_frames("3..7"), Ok(3..7));
        assert!(["3", "7..3", "3..3", "-1..3", "a..b"].iter().all(|text| parse_frames(text).is_err()));
        assert!(["0", "-1", "nan", "inf", "x"].iter().all(|text| parse_rate(text).is_err()));
    }
}
