//! Conductors by name: tables of a folder such as Mitsuba 3's, or of the catalogue.

use super::super::description::{ConductorIndex, SpectrumKind, SpectrumSource};
use super::super::source::{Place, SceneError, SceneErrors, Sources};
use super::query::Query;
use super::spectra::{self, Use};
use super::{Reader, files, spd};
use crate::spectrum::catalogue::{self, Kind};
use crate::spectrum::text::{TO_NANOMETRES, TextProblem, parse_spd};
use std::path::Path;

/// The names that Mitsuba 3.9 has tables of (`data/ior`). Those with `_palik` are Palik's tables as they are,
/// the others may be joined from several.
pub(in crate::scene) const MITSUBA: [&str; 71] = [
    "Ag",
    "Al",
    "AlAs",
    "AlAs_palik",
    "AlSb",
    "AlSb_palik",
    "Au",
    "Be",
    "Be_palik",
    "Cr",
    "CsI",
    "CsI_palik",
    "Cu",
    "Cu2O",
    "Cu2O_palik",
    "CuO",
    "CuO_palik",
    "Cu_palik",
    "Hg",
    "HgTe",
    "HgTe_palik",
    "Hg_palik",
    "Ir",
    "Ir_palik",
    "K",
    "K_palik",
    "Li",
    "Li_palik",
    "MgO",
    "MgO_palik",
    "Mo",
    "Mo_palik",
    "Na_palik",
    "Nb",
    "Nb_palik",
    "Ni_palik",
    "Rh",
    "Rh_palik",
    "Se",
    "Se-e",
    "Se-e_palik",
    "Se_palik",
    "SiC",
    "SiC_palik",
    "SnTe",
    "SnTe_palik",
    "Ta",
    "Ta_palik",
    "Te",
    "Te-e",
    "Te-e_palik",
    "Te_palik",
    "ThF4",
    "ThF4_palik",
    "TiC",
    "TiC_palik",
    "TiN",
    "TiN_palik",
    "TiO2",
    "TiO2-e",
    "TiO2-e_palik",
    "TiO2_palik",
    "VC",
    "VC_palik",
    "VN",
    "VN_palik",
    "V_palik",
    "W",
    "a-C",
    "d-C",
    "d-C_palik",
];

/// How a table of n and one of k end.
const ENDINGS: [&str; 2] = [".eta.spd", ".k.spd"];

/// Whether a folder holds any tables of metals.
///
/// # Errors
/// What is wrong with it.
pub(in crate::scene) fn check_folder(folder: &Path) -> Result<(), SceneErrors> {
    let refuse = |problem: String| SceneErrors {
        sources: Sources::default(),
        errors: vec![SceneError {
            place: None,
            problem,
            expected: "expected a folder with NAME.eta.spd and NAME.k.spd, such as data/ior of Mitsuba 3"
                .to_owned(),
            remedy: None,
        }],
    };
    let entries = std::fs::read_dir(folder)
        .map_err(|error| refuse(format!("The folder {} cannot be read: {error}", folder.display())))?;
    let is_table = |name: &str| name.ends_with(ENDINGS[0]);
    match entries.flatten().any(|entry| entry.file_name().to_str().is_some_and(is_table)) {
        true => Ok(()),
        false => Err(refuse(format!("The folder {} has no tables of metals", folder.display()))),
    }
}

/// The metal that `material` names at `place`.
pub(in crate::scene) fn named(query: &Query<'_>, place: &Place, name: &str) -> ConductorIndex {
    let reader = query.reader;
    if let Some(tables) = reader.ior_tables.as_deref().and_then(|folder| tables(reader, place, folder, name))
    {
        return tables;
    }
    if let Ok(entry) = catalogue::lookup(Kind::Conductor, in_catalogue(name)) {
        reader.assumption(
            place,
            format!(
                "material \"{name}\": abbe's table {}, which is not the one that comes with Mitsuba 3; --ior-tables reads that",
                entry.name
            ),
        );
        if let catalogue::Quantity::ComplexIndex { n, .. } = &entry.quantity
            && let Some(range) = n.domain()
        {
            reader.holds(place, &format!("material \"{name}\""), range);
        }
    } else if MITSUBA.contains(&name) {
        let expected = "expected the name of a measured conductor";
        let remedy = format!(
            "Mitsuba 3 has tables of it, which have no open licence: --ior-tables DIR reads {name}.eta.spd and {name}.k.spd from the data/ior of an installed Mitsuba"
        );
        let problem = format!("There is no measured conductor \"{name}\"");
        reader.error(SceneError::at(place, problem, expected).with_remedy(remedy));
    } else {
        spectra::lookup(reader, place, Kind::Conductor, name);
    }
    ConductorIndex::Named { place: place.clone(), name: name.to_owned() }
}

/// What the catalogue calls a metal: Mitsuba's "Ni_palik" is nickel.
pub(in crate::scene) fn in_catalogue(name: &str) -> &str {
    name.strip_suffix("_palik").filter(|_| MITSUBA.contains(&name)).unwrap_or(name)
}

/// The tables of a folder; `None` where it has none of that name.
fn tables(reader: &Reader, place: &Place, folder: &Path, name: &str) -> Option<ConductorIndex> {
    let paths = ENDINGS.map(|ending| folder.join(format!("{name}{ending}")));
    if !paths.iter().any(|path| path.exists()) {
        return None;
    }
    let [n, k] = [("eta", &paths[0]), ("k", &paths[1])].map(|(role, path)| {
        let source = table(path, place).unwrap_or_else(|error| {
            reader.error(error);
            spectra::constant(place, 1.0)
        });
        if spectra::check(reader, &source, role, Use::ConductorIndex) {
            reader.held(&format!("material \"{name}\", {role}"), &source);
        }
        source
    });
    reader.assumption(place, format!("material \"{name}\": n and k are those of the folder of --ior-tables"));
    Some(ConductorIndex::Complex { n, k })
}

fn table(path: &Path, place: &Place) -> Result<SpectrumSource, SceneError> {
    let wrong = |problem: String| {
        let problem = format!("The table {} cannot be read: {problem}", path.display());
        SceneError::at(place, problem, "expected a file with a wavelength and a value on each line")
    };
    let bytes = files::read(path, spd::LARGEST_FILE, place)?;
    let text = String::from_utf8(bytes).map_err(|_| wrong("it is not text".to_owned()))?;
    let columns = parse_spd(&text).map_err(|error| match error.problem {
        TextProblem::NotNanometres(_) => wrong(error.to_string()).with_remedy(TO_NANOMETRES),
        _ => wrong(error.to_string()),
    })?;
    // What absorbs nothing has tables of zeros.
    if columns.values.iter().all(|&value| value == 0.0) {
        return Ok(spectra::constant(place, 0.0));
    }
    let kind =
        SpectrumKind::Irregular { nm: columns.nodes, values: columns.values, file: Some(path.to_owned()) };
    Ok(SpectrumSource { place: place.clone(), kind, scale: 1.0 })
}
