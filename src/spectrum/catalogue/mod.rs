//! The measured spectra that come with the program, by name.
//!
//! A name is found whatever its capitals, blanks, hyphens and underscores, and by its aliases:
//!
//! | kind | names |
//! | --- | --- |
//! | illuminant | `A`, `C`, `D50`, `D55`, `D65`, `D75`, `E`, `FL1`–`FL12` (`F1`–`F12`), `FL3.1`–`FL3.15`, `HP1`–`HP5`, `ID50`, `ID65`, `LED-B1`..., `lamp/...` |
//! | reflectance | `colorchecker/dark-skin`... (BabelColor average), `colorchecker-ohta/...`, `cie13.3/TCS01`..., `usgs/calcite`..., `derived/Au/johnson-christy`..., `mallett-yuksel/red`... |
//! | conductor | `Au` or `gold` (one set per metal is its default), `Au/johnson-christy`, `Au/mcpeak`... |
//! | dielectric | `BK7` (`N-BK7`), `SF11`, `fused-silica`, `diamond`, `water`... |
//! | absorption | `water`, `soda-lime-bronze`, `isuzu-IEB470`, `blood-oxygenated`..., in 1/m |
//! | sensitivity | `cie1931-2deg/y`, `cone/L`... |
//!
//! Emission and sensitivity are zero outside their tables; material data keep their end value, because zero
//! would be unphysical. The daylight illuminants, whose tables end at 780 nm, are continued to 830 nm by the
//! CIE's formula.

mod records;

use super::dispersion::{DispersionFormula, FormulaKind, abbe_number};
use super::table_file::{TableError, TableFile};
use super::{Extrapolation, Spectrum, SpectrumError, data, daylight};
use crate::units::WavelengthRange;
use records::{Reading, Record};
use std::fmt;

/// What a spectrum of the catalogue describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Relative spectral power of a light source.
    Illuminant,
    /// Reflectance factor, 0 to 1.
    Reflectance,
    /// Complex index n + i k of a metal or semiconductor.
    Conductor,
    /// Real index of a transparent medium.
    Dielectric,
    /// Absorption coefficient, 1/m (Napierian: the internal transmittance of a length d is exp(−a d)).
    Absorption,
    /// Response of an observer or a sensor.
    Sensitivity,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Illuminant,
        Self::Reflectance,
        Self::Conductor,
        Self::Dielectric,
        Self::Absorption,
        Self::Sensitivity,
    ];

    /// The word for it, as `abbe spectrum --kind` takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Illuminant => "illuminant",
            Self::Reflectance => "reflectance",
            Self::Conductor => "conductor",
            Self::Dielectric => "dielectric",
            Self::Absorption => "absorption",
            Self::Sensitivity => "sensitivity",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A spectrum of the catalogue with all that its table says about itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is.
    pub kind: Kind,
    /// Its name.
    pub name: String,
    /// Other names that it is found by.
    pub aliases: Vec<String>,
    /// The table below `data/`, without `.csv`.
    pub file: &'static str,
    /// The column (or row of the table of formulas) that holds it.
    pub column: String,
    /// Where the data are from.
    pub source: String,
    /// Licence of the data.
    pub licence: String,
    /// Units as the table's header states them.
    pub units: String,
    /// Notes of the table's header, and what was done beyond the table.
    pub notes: Vec<String>,
    /// The data.
    pub quantity: Quantity,
}

/// The function or functions of an entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// Relative power, reflectance, absorption in 1/m, or response, by the entry's kind.
    Spectrum(Spectrum),
    /// The index of a dielectric.
    Index(RefractiveIndex),
    /// The complex index n + i k of a conductor.
    ComplexIndex {
        /// Real part of the index.
        n: Spectrum,
        /// Imaginary part of the index, at least 0.
        k: Spectrum,
    },
}

/// The real refractive index of a transparent medium.
#[derive(Clone, Debug, PartialEq)]
pub enum RefractiveIndex {
    /// A dispersion formula.
    Formula(DispersionFormula),
    /// Measured values.
    Table(Spectrum),
}

impl RefractiveIndex {
    /// The index at a wavelength (nm).
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Formula(formula) => formula.index(nm),
            Self::Table(table) => table.at(nm),
        }
    }

    /// Abbe number, see [`abbe_number`].
    pub fn abbe_number(&self) -> f64 {
        abbe_number(|nm| self.at(nm))
    }

    /// The index over `range` as a table, see [`DispersionFormula::to_spectrum`].
    ///
    /// # Errors
    /// A range without width.
    pub fn to_spectrum(&self, range: WavelengthRange) -> Result<Spectrum, SpectrumError> {
        match self {
            Self::Formula(formula) => formula.to_spectrum(range),
            Self::Table(table) => Ok(table.clone()),
        }
    }

    /// What using this index over `range` assumes beyond its source, as a sentence; `None` where it covers
    /// the range.
    pub fn assumption(&self, range: WavelengthRange) -> Option<String> {
        match self {
            Self::Formula(formula) => {
                let reach = formula.reach(range);
                reach.is_extended().then(|| reach.to_string())
            }
            Self::Table(table) => held_outside(table, range),
        }
    }
}

/// What using `spectrum` over `range` assumes, if its table is shorter and its end values are held; else
/// `None`.
pub fn held_outside(spectrum: &Spectrum, range: WavelengthRange) -> Option<String> {
    let known = spectrum.domain().filter(|_| spectrum.is_held_within(range))?;
    Some(held(known))
}

/// What is assumed of a material whose table covers `known`, as a sentence.
pub fn held(known: WavelengthRange) -> String {
    format!("the table covers {}–{} nm; its end values are held beyond", known.min, known.max)
}

/// No entry of this kind has this name.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownName {
    /// What was looked for.
    pub kind: Kind,
    /// The name that is not known.
    pub name: String,
    /// The valid name that looks most like it, if any does.
    pub nearest: Option<String>,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "there is no {} named '{}'", self.kind, self.name)?;
        match &self.nearest {
            Some(nearest) => write!(f, "; did you mean '{nearest}'?"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for UnknownName {}

/// The names of all entries of a kind, in the catalogue's order, without aliases.
pub fn names(kind: Kind) -> Vec<&'static str> {
    records::all().iter().filter(|record| record.kind == kind).map(|record| record.name.as_str()).collect()
}

/// The entry of a kind with this name or alias.
///
/// # Errors
/// There is none; the error says which name looks most like it.
pub fn lookup(kind: Kind, name: &str) -> Result<Entry, UnknownName> {
    let wanted = key(name);
    let of_kind = || records::all().iter().filter(|record| record.kind == kind);
    let called = |record: &&Record| record.names().any(|known| key(known) == wanted);
    match of_kind().find(called) {
        Some(record) => Ok(read(record).expect("the built-in tables are well formed, which a test checks")),
        None => {
            let alike = |known: &&str| strsim::jaro_winkler(&key(known), &wanted);
            let nearest = of_kind()
                .flat_map(Record::names)
                .filter(|known| alike(known) > 0.7)
                .max_by(|a, b| alike(a).total_cmp(&alike(b)).then_with(|| b.len().cmp(&a.len())));
            Err(UnknownName { kind, name: name.to_owned(), nearest: nearest.map(str::to_owned) })
        }
    }
}

/// Relative spectral power of an illuminant.
///
/// # Errors
/// As [`lookup`].
pub fn illuminant(name: &str) -> Result<Spectrum, UnknownName> {
    single(Kind::Illuminant, name)
}

/// A reflectance factor, 0 to 1 (fluorescence-free samples).
///
/// # Errors
/// As [`lookup`].
pub fn reflectance(name: &str) -> Result<Spectrum, UnknownName> {
    single(Kind::Reflectance, name)
}

/// An absorption coefficient, 1/m.
///
/// # Errors
/// As [`lookup`].
pub fn absorption(name: &str) -> Result<Spectrum, UnknownName> {
    single(Kind::Absorption, name)
}

/// What a sensor, or an eye, makes of each wavelength.
///
/// # Errors
/// As [`lookup`].
pub fn sensitivity(name: &str) -> Result<Spectrum, UnknownName> {
    single(Kind::Sensitivity, name)
}

/// n and k of a conductor.
///
/// # Errors
/// As [`lookup`].
pub fn conductor(name: &str) -> Result<(Spectrum, Spectrum), UnknownName> {
    match lookup(Kind::Conductor, name)?.quantity {
        Quantity::ComplexIndex { n, k } => Ok((n, k)),
        Quantity::Spectrum(_) | Quantity::Index(_) => unreachable!("conductors are read as n and k"),
    }
}

/// The index of a dielectric.
///
/// # Errors
/// As [`lookup`].
pub fn dielectric(name: &str) -> Result<RefractiveIndex, UnknownName> {
    match lookup(Kind::Dielectric, name)?.quantity {
        Quantity::Index(index) => Ok(index),
        Quantity::Spectrum(_) | Quantity::ComplexIndex { .. } => {
            unreachable!("dielectrics are read as an index")
        }
    }
}

fn single(kind: Kind, name: &str) -> Result<Spectrum, UnknownName> {
    match lookup(kind, name)?.quantity {
        Quantity::Spectrum(spectrum) => Ok(spectrum),
        Quantity::Index(_) | Quantity::ComplexIndex { .. } => {
            unreachable!("{kind}s are read as one spectrum")
        }
    }
}

/// Names that differ only in capitals, blanks, hyphens, underscores or British spelling are the same.
fn key(name: &str) -> String {
    let bare: String = name.chars().filter(|c| !c.is_whitespace() && !"-_".contains(*c)).collect();
    bare.to_lowercase().replace("colour", "color").replace("gray", "grey")
}

/// Why a built-in table could not be read: never, as a test makes sure.
#[derive(Debug)]
enum Malformed {
    Table(#[allow(dead_code, reason = "shown by Debug")] TableError),
    Spectrum(#[allow(dead_code, reason = "shown by Debug")] SpectrumError),
    Formula(#[allow(dead_code, reason = "shown by Debug")] String),
}

impl From<TableError> for Malformed {
    fn from(error: TableError) -> Self {
        Self::Table(error)
    }
}

impl From<SpectrumError> for Malformed {
    fn from(error: SpectrumError) -> Self {
        Self::Spectrum(error)
    }
}

fn read(record: &Record) -> Result<Entry, Malformed> {
    let table = TableFile::parse(data::text(record.file))?;
    let outside = match record.kind {
        Kind::Illuminant | Kind::Sensitivity => Extrapolation::Zero,
        Kind::Reflectance | Kind::Conductor | Kind::Dielectric | Kind::Absorption => Extrapolation::Hold,
    };
    let spectrum = |column: &str| -> Result<Spectrum, Malformed> {
        Ok(Spectrum::irregular(&table.numbers("wavelength_nm")?, &table.numbers(column)?, outside)?)
    };
    let mut source = table.source.clone();
    let mut notes = table.notes.clone();
    let quantity = match record.reading {
        Reading::Column => Quantity::Spectrum(spectrum(&record.column)?),
        Reading::ComplexIndex => Quantity::ComplexIndex { n: spectrum("n")?, k: spectrum("k")? },
        Reading::Index => Quantity::Index(RefractiveIndex::Table(spectrum(&record.column)?)),
        Reading::Formula => {
            let (formula, reference) = read_formula(&table, &record.column)?;
            source = format!("{reference}; {source}");
            notes = notes_of_row(&table, &record.column)?;
            Quantity::Index(RefractiveIndex::Formula(formula))
        }
        Reading::Clear => {
            let (formula, reference) = read_formula(&table, &record.column)?;
            source = format!("{reference}; {source}");
            notes = notes_of_row(&table, &record.column)?;
            notes.push("clear: k = 0; what is not reflected is taken as absorbed".to_owned());
            Quantity::ComplexIndex { n: formula.to_spectrum(WavelengthRange::VISIBLE)?, k: Spectrum::ZERO }
        }
        Reading::Daylight { nominal } => {
            let (mut nodes, mut values) = (table.numbers("wavelength_nm")?, table.numbers(&record.column)?);
            daylight::completed(&mut nodes, &mut values, nominal)?;
            notes.push("continued from 780 to 830 nm by the CIE daylight formula (CIE 15)".to_owned());
            Quantity::Spectrum(Spectrum::irregular(&nodes, &values, outside)?)
        }
        Reading::Blood => {
            // µ in 1/cm = 2.303 e c / 64500 (table's header), and 100 cm in a metre.
            notes.push(format!("absorption of whole blood with {HAEMOGLOBIN} g/L of haemoglobin, 1/m"));
            Quantity::Spectrum(spectrum(&record.column)?.scaled(100.0 * 2.303 * HAEMOGLOBIN / 64_500.0))
        }
    };
    Ok(Entry {
        kind: record.kind,
        name: record.name.clone(),
        aliases: record.aliases.clone(),
        file: record.file,
        column: record.column.clone(),
        source,
        licence: table.licence,
        units: table.units,
        notes,
        quantity,
    })
}

/// Haemoglobin in whole blood, g/L, as the table's header gives it.
const HAEMOGLOBIN: f64 = 150.0;

/// The notes of a table of rows that concern one of them: a note that begins with the name of a row is about
/// that row alone, and one that begins with the name of a column is about how the table is read.
fn notes_of_row(table: &TableFile, name: &str) -> Result<Vec<String>, TableError> {
    let names = table.texts("name")?;
    let concerns = |note: &&String| {
        let subject = note.split([' ', ',']).next().unwrap_or_default();
        let is_known = names.contains(&subject) || table.columns.iter().any(|column| column == subject);
        subject == name || !is_known
    };
    Ok(table.notes.iter().filter(concerns).cloned().collect())
}

/// A row of the table of dispersion formulas, with its reference.
fn read_formula(table: &TableFile, name: &str) -> Result<(DispersionFormula, String), Malformed> {
    let names = table.texts("name")?;
    let row = names.iter().position(|known| *known == name);
    let row = row.ok_or_else(|| Malformed::Formula(format!("no formula named {name}")))?;
    let numbers = |column: &str| Ok::<f64, TableError>(table.numbers(column)?[row]);
    let kind = FormulaKind::from_number(numbers("formula")? as u32);
    let kind = kind.ok_or_else(|| Malformed::Formula(format!("{name} has a formula of unknown number")))?;
    let coefficients: Result<Vec<f64>, _> =
        table.texts("coefficients_um")?[row].split_whitespace().map(str::parse).collect();
    let coefficients = coefficients.map_err(|error| Malformed::Formula(format!("{name}: {error}")))?;
    let stated = WavelengthRange { min: numbers("min_nm")?, max: numbers("max_nm")? };
    let formula = DispersionFormula::new(kind, &coefficients, stated);
    let formula = formula.map_err(|error| Malformed::Formula(format!("{name}: {error}")))?;
    Ok((formula, table.texts("reference")?[row].to_owned()))
}

#[cfg(test)]
mod tests;
