use abbe::bsdf::fresnel;
use abbe::spectrum::catalogue::{self, Kind, Quantity};
use abbe::spectrum::normal_reflectance::{
    extinction_of_reflectance, front_face_of_slab, index_of_reflectance, reflectance_of_index,
};
use abbe::spectrum::{Extrapolation, NormalReflectance, Spectrum};
use abbe::units::WavelengthRange;
use serde::Deserialize;
use serde_json::{Value, json};
use std::error::Error;

/// Lists of one question are of equal length and are gone through together.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Unpolarised reflectance of a conductor n + ik seen from vacuum, at the cosines of the angles of
    /// incidence.
    Conductor { cosine: Vec<f64>, n: Vec<f64>, k: Vec<f64> },
    /// Unpolarised reflectance of a dielectric of relative index eta, and the cosine of the angle of
    /// refraction.
    Dielectric { cosine: Vec<f64>, eta: Vec<f64> },
    /// Reflectance at normal incidence of n + ik.
    ReflectanceOfIndex { n: Vec<f64>, k: Vec<f64> },
    /// The index n (k = 0) that belongs to a reflectance at normal incidence.
    IndexOfReflectance { reflectance: Vec<f64> },
    /// The k that belongs to a reflectance at normal incidence and a known n.
    ExtinctionOfReflectance { reflectance: Vec<f64>, n: Vec<f64> },
    /// Reflectance of one face from that of both faces of a clear slab.
    FrontFaceOfSlab { slab: Vec<f64> },
    /// n and k at the wavelengths (nm) from a table of reflectances at normal incidence: `n` of a conductor
    /// is given, a dielectric's is found.
    NormalReflectance { table_nm: Vec<f64>, table: Vec<f64>, n: Option<f64>, slab: bool, nm: Vec<f64> },
    /// Index of a dielectric of the catalogue at the wavelengths (nm): as its formula or table gives it, and
    /// as a render over `range` has it.
    Index { name: String, nm: Vec<f64>, range: [f64; 2] },
    /// n and k of a conductor of the catalogue at the wavelengths (nm).
    ComplexIndex { name: String, nm: Vec<f64> },
    /// Names of the catalogue's conductors or dielectrics.
    Names { conductors: bool },
}

pub fn answer(question: Question) -> Result<Value, Box<dyn Error>> {
    let pairs = |a: Vec<f64>, b: Vec<f64>| a.into_iter().zip(b);
    Ok(match question {
        Question::Conductor { cosine, n, k } => {
            let all = pairs(cosine, n).zip(k);
            json!(all.map(|((cosine, n), k)| fresnel::conductor(cosine, n, k)).collect::<Vec<f64>>())
        }
        Question::Dielectric { cosine, eta } => {
            let all = pairs(cosine, eta).map(|(cosine, eta)| fresnel::dielectric(cosine, eta));
            json!(all.map(|found| [found.reflectance, found.cos_refracted]).collect::<Vec<_>>())
        }
        Question::ReflectanceOfIndex { n, k } => {
            json!(pairs(n, k).map(|(n, k)| reflectance_of_index(n, k)).collect::<Vec<f64>>())
        }
        Question::IndexOfReflectance { reflectance } => {
            json!(reflectance.into_iter().map(index_of_reflectance).collect::<Result<Vec<f64>, _>>()?)
        }
        Question::ExtinctionOfReflectance { reflectance, n } => {
            let all = pairs(reflectance, n).map(|(reflectance, n)| extinction_of_reflectance(reflectance, n));
            json!(all.collect::<Result<Vec<f64>, _>>()?)
        }
        Question::FrontFaceOfSlab { slab } => {
            json!(slab.into_iter().map(front_face_of_slab).collect::<Vec<f64>>())
        }
        Question::NormalReflectance { table_nm, table, n, slab, nm } => {
            let reflectance = Spectrum::irregular(&table_nm, &table, Extrapolation::Hold)?;
            let range = WavelengthRange::VISIBLE;
            let surface = match n {
                Some(n) => NormalReflectance::conductor(reflectance, Spectrum::Constant(n), range)?,
                None if slab => NormalReflectance::slab(reflectance, range)?,
                None => NormalReflectance::dielectric(reflectance, range)?,
            };
            json!(nm.into_iter().map(|nm| surface.at(nm)).collect::<Vec<_>>())
        }
        Question::Index { name, nm, range } => {
            let index = catalogue::dielectric(&name)?;
            let rendered = index.to_spectrum(WavelengthRange { min: range[0], max: range[1] })?;
            json!({
                "index": nm.iter().map(|&nm| index.at(nm)).collect::<Vec<f64>>(),
                "rendered": nm.iter().map(|&nm| rendered.at(nm)).collect::<Vec<f64>>(),
                "abbe_number": index.abbe_number(),
            })
        }
        Question::ComplexIndex { name, nm } => {
            let (n, k) = catalogue::conductor(&name)?;
            json!(nm.into_iter().map(|nm| [n.at(nm), k.at(nm)]).collect::<Vec<_>>())
        }
        Question::Names { conductors } => {
            let kind = if conductors { Kind::Conductor } else { Kind::Dielectric };
            let described = |name: &str| {
                let entry = catalogue::lookup(kind, name).map_err(|error| error.to_string())?;
                let formula =
                    matches!(entry.quantity, Quantity::Index(catalogue::RefractiveIndex::Formula(_)));
                Ok::<_, String>(
                    json!({ "name": name, "file": entry.file, "column": entry.column, "formula": formula }),
                )
            };
            json!(catalogue::names(kind).into_iter().map(described).collect::<Result<Vec<_>, _>>()?)
        }
    })
}
