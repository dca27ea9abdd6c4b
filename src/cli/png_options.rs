use abbe::output::png::{Exposure, ToneCurve};

/// The PNG beside the picture.
#[derive(clap::Args)]
pub struct PngOptions {
    /// Exposure of the PNG: auto (neither black nor burnt, by the picture's own brightness), or stops, of
    /// which each doubles what the EXR holds. With 0 what is 1 in the EXR is white, in every picture alike
    #[arg(long, value_name = "EV|auto", default_value = "auto", value_parser = parse_exposure)]
    pub exposure: Exposure,

    /// Tone curve of the PNG: linear, reinhard (a shoulder that takes the brightest pixel to white) or aces
    /// (an S, for contrast) [default: reinhard with auto, linear with stops]
    #[arg(long, value_name = "CURVE", value_parser = parse_curve)]
    pub tone: Option<ToneCurve>,

    /// Write no PNG
    #[arg(long)]
    no_png: bool,
}

impl PngOptions {
    pub fn is_wanted(&self) -> bool {
        !self.no_png
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
