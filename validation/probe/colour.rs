use abbe::spectrum::catalogue::{self, Kind, Quantity};
use abbe::spectrum::colour::{
    Lab, Observer, Xyz, delta_e_2000, rec709_to_xyz, srgb_decode, srgb_encode, srgb_hex, xyz_to_rec709,
};
use abbe::spectrum::daylight::daylight;
use abbe::spectrum::{Extrapolation, Spectrum, upsample};
use abbe::units::WavelengthRange;
use serde::Deserialize;
use serde_json::{Value, json};
use std::error::Error;

/// Wavelengths are in nm, 360 to 830 where a question names none; a perfect white reflector has Y = 1.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// CIEDE2000 of pairs of CIELAB colours.
    DeltaE2000 { first: Vec<[f64; 3]>, second: Vec<[f64; 3]> },
    /// Colour-matching functions of an observer at wavelengths.
    Observer { name: String, nm: Vec<f64> },
    /// Name, table and column of every entry of a kind.
    Catalogue { kind: String },
    /// Nodes of a spectrum, and its values at wavelengths.
    Spectrum { kind: String, name: String, nm: Vec<f64> },
    /// XYZ of each illuminant's white, and XYZ, xy and CIELAB of each reflectance under each illuminant.
    Colours { observer: String, illuminants: Vec<String>, reflectances: Vec<Reflectance> },
    /// Radiance of black bodies at wavelengths, and their chromaticities.
    Blackbody { kelvin: Vec<f64>, nm: Vec<f64> },
    /// CIE daylight of correlated colour temperatures at wavelengths.
    Daylight { kelvin: Vec<f64>, nm: Vec<f64> },
    /// What colours are in other spaces.
    FromXyz { xyz: Vec<[f64; 3]>, white: [f64; 3] },
    /// The colours of CIELAB coordinates.
    FromLab { lab: Vec<[f64; 3]>, white: [f64; 3] },
    /// The colours of linear BT.709 values.
    FromRec709 { rgb: Vec<[f64; 3]> },
    /// sRGB's transfer function both ways.
    Transfer { values: Vec<f64> },
    /// Reflectances made for linear BT.709 values: the coefficients, and the values at wavelengths.
    Upsampled { rgb: Vec<[f64; 3]>, nm: Vec<f64> },
}

/// A reflectance by its name, by a table (linear, its ends held), or made for linear BT.709 values.
#[derive(Deserialize)]
#[serde(untagged)]
pub enum Reflectance {
    Named(String),
    Table { nm: Vec<f64>, values: Vec<f64> },
    Upsampled { rgb: [f64; 3] },
}

const RANGE: WavelengthRange = WavelengthRange::VISIBLE;

pub fn answer(question: Question) -> Result<Value, Box<dyn Error>> {
    let lab = |[l, a, b]: [f64; 3]| Lab { l, a, b };
    Ok(match question {
        Question::DeltaE2000 { first, second } => {
            let pairs = first.into_iter().zip(second);
            json!(pairs.map(|(a, b)| delta_e_2000(lab(a), lab(b))).collect::<Vec<f64>>())
        }
        Question::Observer { name, nm } => {
            let observer = observer(&name)?;
            let values: Vec<_> = nm.iter().map(|&nm| observer.at(nm)).collect();
            json!({ "values": values, "domain": [observer.domain().min, observer.domain().max] })
        }
        Question::Catalogue { kind } => {
            let kind = self::kind(&kind)?;
            let entries = catalogue::names(kind).into_iter().map(|name| catalogue::lookup(kind, name));
            let entries: Result<Vec<_>, _> = entries.collect();
            json!(entries?.iter().map(|entry| (&entry.name, entry.file, &entry.column)).collect::<Vec<_>>())
        }
        Question::Spectrum { kind, name, nm } => {
            let entry = catalogue::lookup(self::kind(&kind)?, &name)?;
            let Quantity::Spectrum(spectrum) = entry.quantity else {
                return Err(format!("{name} is not one spectrum").into());
            };
            let values: Vec<f64> = nm.iter().map(|&nm| spectrum.at(nm)).collect();
            json!({ "nodes": spectrum.nodes(), "values": values })
        }
        Question::Colours { observer, illuminants, reflectances } => {
            let observer = self::observer(&observer)?;
            let surfaces: Result<Vec<Spectrum>, _> = reflectances.into_iter().map(reflectance).collect();
            let surfaces = surfaces?;
            let mut answers = Vec::new();
            for name in illuminants {
                let light = catalogue::illuminant(&name)?;
                let white = observer.white(&light, RANGE);
                let colours: Vec<Xyz> =
                    surfaces.iter().map(|surface| observer.reflected(&light, surface, RANGE)).collect();
                let labs: Vec<_> = colours.iter().map(|colour| coordinates(colour.to_lab(white))).collect();
                let xy: Vec<_> = colours.iter().map(|colour| colour.chromaticity()).collect();
                let xyz: Vec<[f64; 3]> = colours.into_iter().map(Into::into).collect();
                let white: [f64; 3] = white.into();
                answers.push(json!({ "white": white, "xyz": xyz, "xy": xy, "lab": labs }));
            }
            json!(answers)
        }
        Question::Blackbody { kelvin, nm } => {
            let bodies: Result<Vec<Spectrum>, _> = kelvin.into_iter().map(Spectrum::blackbody).collect();
            let bodies = bodies?;
            let radiance: Vec<_> =
                bodies.iter().map(|body| nm.iter().map(|&nm| body.at(nm)).collect::<Vec<_>>()).collect();
            let xy: Vec<_> =
                bodies.iter().map(|body| Observer::cie1931().white(body, RANGE).chromaticity()).collect();
            json!({ "radiance": radiance, "xy": xy })
        }
        Question::Daylight { kelvin, nm } => {
            let lights: Result<Vec<Spectrum>, _> = kelvin.into_iter().map(daylight).collect();
            let values = |light: &Spectrum| nm.iter().map(|&nm| light.at(nm)).collect::<Vec<_>>();
            json!(lights?.iter().map(values).collect::<Vec<_>>())
        }
        Question::FromXyz { xyz, white } => {
            let colours: Vec<Xyz> = xyz.into_iter().map(Into::into).collect();
            let labs: Vec<_> =
                colours.iter().map(|colour| coordinates(colour.to_lab(white.into()))).collect();
            json!({
                "lab": labs,
                "xy": colours.iter().map(|colour| colour.chromaticity()).collect::<Vec<_>>(),
                "rec709": colours.iter().map(|&colour| xyz_to_rec709(colour)).collect::<Vec<_>>(),
                "hex": colours.iter().map(|&colour| srgb_hex(colour)).collect::<Vec<_>>(),
            })
        }
        Question::FromLab { lab: labs, white } => {
            json!(labs.into_iter().map(|c| triple(lab(c).to_xyz(white.into()))).collect::<Vec<_>>())
        }
        Question::FromRec709 { rgb } => {
            json!(rgb.into_iter().map(|rgb| triple(rec709_to_xyz(rgb))).collect::<Vec<_>>())
        }
        Question::Transfer { values } => json!({
            "encoded": values.iter().map(|&value| srgb_encode(value)).collect::<Vec<_>>(),
            "decoded": values.iter().map(|&value| srgb_decode(value)).collect::<Vec<_>>(),
        }),
        Question::Upsampled { rgb, nm } => {
            let shapes: Vec<_> = rgb.into_iter().map(upsample).collect();
            let values: Vec<_> =
                shapes.iter().map(|shape| nm.iter().map(|&nm| shape.at(nm)).collect::<Vec<_>>()).collect();
            json!({ "coefficients": shapes.iter().map(|shape| shape.coefficients).collect::<Vec<_>>(), "values": values })
        }
    })
}

fn triple(colour: Xyz) -> [f64; 3] {
    colour.into()
}

fn coordinates(Lab { l, a, b }: Lab) -> [f64; 3] {
    [l, a, b]
}

/// By the names that `--observer` takes.
fn observer(name: &str) -> Result<&'static Observer, String> {
    Ok(match name {
        "cie1931" => Observer::cie1931(),
        "cie1931-5nm" => Observer::cie1931_5nm(),
        "cie1964" => Observer::cie1964(),
        "cie2015-2" => Observer::cie2015_2deg(),
        "cie2015-10" => Observer::cie2015_10deg(),
        _ => return Err(format!("there is no observer named {name}")),
    })
}

fn kind(name: &str) -> Result<Kind, String> {
    let known = Kind::ALL.into_iter().find(|kind| kind.name() == name);
    known.ok_or_else(|| format!("there is no kind named {name}"))
}

fn reflectance(of: Reflectance) -> Result<Spectrum, Box<dyn Error>> {
    Ok(match of {
        Reflectance::Named(name) => catalogue::reflectance(&name)?,
        Reflectance::Table { nm, values } => Spectrum::irregular(&nm, &values, Extrapolation::Hold)?,
        Reflectance::Upsampled { rgb } => Spectrum::Sigmoid { shape: upsample(rgb), factor: 1.0 },
    })
}
