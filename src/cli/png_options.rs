use super::Failure;
use abbe::output::Picture;
use abbe::output::png::{self, Exposure, ToneCurve};
use std::path::Path;

/// The PNG beside the picture.
#[derive(clap::Args)]
pub struct PngOptions {
    /// Exposure of the PNG: auto (neither black nor burnt, by the picture's own brightness), or stops, of
    /// which each doubles what the EXR holds. With 0 what is 1 in the EXR is white, in every picture alike
    /// [default: auto]
    #[arg(long, value_name = "EV|auto", value_parser = parse_exposure)]
    exposure: Option<Exposure>,

    /// Tone curve of the PNG: linear, reinhard (where pixels are beyond white, a shoulder that takes the
    /// brightest to white; else as linear) or aces (an S, for contrast) [default: reinhard with auto, linear
    /// with stops]
    #[arg(long, value_name = "CURVE", value_parser = parse_curve)]
    tone: Option<ToneCurve>,

    /// Write no PNG
    #[arg(long)]
    no_png: bool,
}

impl PngOptions {
    pub fn is_wanted(&self) -> bool {
        !self.no_png
    }

    /// Refuses to shape a PNG that is not written. `with_picture`: whether the output is a picture.
    pub fn refuse_without_png(&self, with_picture: bool) -> Result<(), Failure> {
        let given = [("--exposure", self.exposure.is_some()), ("--tone", self.tone.is_some())];
        let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) else { return Ok(()) };
        let remedy = match (with_picture, self.no_png) {
            (true, false) => return Ok(()),
            (true, true) => "leave out one of the two",
            (false, _) => {
                "leave it out, or name the output *.exr; abbe merge makes the picture of a checkpoint"
            }
        };
        let reason = if with_picture { "--no-png leaves it out" } else { "a checkpoint has none beside it" };
        Err(Failure::Input(format!("error: {option} is of the PNG, and {reason}\nhelp: {remedy}")))
    }

    /// Writes the PNG of a picture.
    pub fn write(&self, path: &Path, picture: &Picture) -> std::io::Result<()> {
        png::write(path, picture, self.exposure.unwrap_or(Exposure::Auto), self.tone)
    }
}

fn parse_curve(text: &str) -> Result<ToneCurve, String> {
    ToneCurve::named(text).ok_or_else(|| {
        let names = ToneCurve::NAMES.map(|(name, _)| name);
        format!("expected one of {}", names.join(", "))
    })
}

fn parse_exposure(text: &str) -> Result<Exposure, String> {
    match (text, text.parse::<f64>()) {
        ("auto", _) => Ok(Exposure::Auto),
        (_, Ok(stops)) if stops.abs() <= 100.0 => Ok(Exposure::Stops(stops)),
        _ => Err("expected auto or stops from -100 to 100, for example -1.5".to_owned()),
    }
}
