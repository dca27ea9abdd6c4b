use abbe::output::png::Exposure;

/// The PNG beside the picture.
#[derive(clap::Args)]
pub struct PngOptions {
    /// Exposure of the PNG: auto (neither black nor burnt, by the picture's own brightness), or stops, of
    /// which each doubles what the EXR holds. With 0 what is 1 in the EXR is white, in every picture alike
    #[arg(long, value_name = "EV|auto", default_value = "auto", allow_negative_numbers = true, value_parser = parse_exposure)]
    pub exposure: Exposure,

    /// Write no PNG
    #[arg(long)]
    no_png: bool,
}

impl PngOptions {
    pub fn is_wanted(&self) -> bool {
        !self.no_png
    }
}

fn parse_exposure(text: &str) -> Result<Exposure, String> {
    match (text, text.parse::<f64>()) {
        ("auto", _) => Ok(Exposure::Auto),
        (_, Ok(stops)) if stops.abs() <= 100.0 => Ok(Exposure::Stops(stops)),
        _ => Err("expected auto or stops from -100 to 100, for example -1.5".to_owned()),
    }
}
