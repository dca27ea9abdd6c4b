//! Which name stands for which column of which table.

use super::Kind;
use crate::spectrum::data;
use crate::spectrum::table_file::TableFile;
use std::sync::OnceLock;

/// One name of the catalogue.
#[derive(Debug)]
pub(super) struct Record {
    pub kind: Kind,
    pub name: String,
    pub aliases: Vec<String>,
    pub file: &'static str,
    pub column: String,
    pub reading: Reading,
}

/// How a record's table is read.
#[derive(Clone, Copy, Debug)]
pub(super) enum Reading {
    /// One column as it is.
    Column,
    /// A published daylight table, continued by formula for this nominal temperature (K).
    Daylight { nominal: f64 },
    /// Columns n and k.
    ComplexIndex,
    /// One column as an index.
    Index,
    /// A row of the table of dispersion formulas.
    Formula,
    /// A row of the table of dispersion formulas as the complex index of a body that absorbs nothing: k = 0.
    Clear,
    /// A molar extinction of haemoglobin, converted to whole blood.
    Blood,
}

impl Record {
    /// The name and its aliases.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        std::iter::once(self.name.as_str()).chain(self.aliases.iter().map(String::as_str))
    }
}

/// Every record, in the order in which they are listed to a user.
pub(super) fn all() -> &'static [Record] {
    static RECORDS: OnceLock<Vec<Record>> = OnceLock::new();
    RECORDS.get_or_init(|| {
        let kinds = [illuminants, reflectances, conductors, dielectrics, absorptions, sensitivities];
        kinds.into_iter().flat_map(|records| records()).collect()
    })
}

/// A record that reads one column.
fn column(kind: Kind, name: impl Into<String>, aliases: &[&str], file: &'static str, column: &str) -> Record {
    let aliases = aliases.iter().map(|alias| (*alias).to_owned()).collect();
    Record { kind, name: name.into(), aliases, file, column: column.to_owned(), reading: Reading::Column }
}

/// The columns of values of a built-in table.
fn columns(file: &str) -> Vec<String> {
    let table = TableFile::parse(data::text(file)).expect("the built-in tables are well formed");
    table.columns[1..].to_vec()
}

const LAMPS: [(&str, &str, &[&str]); 10] = [
    ("60_A_W_Soft_White", "60W-soft-white", &[]),
    ("Cool_White_FL", "cool-white-fluorescent", &[]),
    ("Triphosphor_FL", "triphosphor-fluorescent", &[]),
    ("Mercury", "mercury", &[]),
    ("HPS", "high-pressure-sodium", &["HPS"]),
    ("LPS", "low-pressure-sodium", &["LPS"]),
    ("Metal_Halide", "metal-halide", &[]),
    ("Neodimium_Incandescent", "neodymium-incandescent", &[]),
    ("Phosphor_LED_YAG", "phosphor-LED-YAG", &[]),
    ("C100S54_HPS", "C100S54-HPS", &[]),
];

fn illuminants() -> Vec<Record> {
    const CIE: &str = "illuminants/cie_a_c_daylight_5nm";
    let illuminant = |name: &str, aliases: &[&str], file| column(Kind::Illuminant, name, aliases, file, name);
    let mut records = vec![
        illuminant("A", &[], "illuminants/cie_a_formula_1nm"),
        column(Kind::Illuminant, "A/5nm", &[], CIE, "A"),
        illuminant("C", &[], CIE),
    ];
    for (name, nominal) in [("D50", 5000.0), ("D55", 5500.0), ("D65", 6500.0), ("D75", 7500.0)] {
        records.push(Record { reading: Reading::Daylight { nominal }, ..illuminant(name, &[], CIE) });
    }
    records.push(illuminant("E", &["equal-energy"], "illuminants/cie_e"));
    for file in ["illuminants/cie_fl1_fl12_5nm", "illuminants/cie_fl3_series_5nm"] {
        for name in columns(file) {
            records.push(illuminant(&name, &[&name.replace("FL", "F")], file));
        }
    }
    for file in
        ["illuminants/cie_hp1_hp5_5nm", "illuminants/cie_indoor_daylight_5nm", "illuminants/cie_led_5nm"]
    {
        records.extend(columns(file).iter().map(|name| illuminant(name, &[], file)));
    }
    records.extend(LAMPS.iter().map(|(col, name, aliases)| {
        let file = "illuminants/light_sources_380_780_5nm";
        column(Kind::Illuminant, format!("lamp/{name}"), aliases, file, col)
    }));
    records
}

/// Columns of the USGS table and the names that they get.
const USGS: [(&str, &str); 11] = [
    ("Engelmann-Spruce_ES-Needls-1_ASDFRa_AREF", "engelmann-spruce-needles"),
    ("Lodgepole-Pine_LP-Needles-2_ASDFRa_AREF", "lodgepole-pine-needles"),
    ("Grass_Golden_Dry_GDS480_ASDFRa_AREF", "golden-dry-grass"),
    ("Melting_snow_mSnw01a_ASDFRa_AREF", "melting-snow"),
    ("Calcite_WS272_BECKa_AREF", "calcite"),
    ("Dolomite_HS102.3B_BECKb_AREF", "dolomite"),
    ("Siderite_HS271.3B_BECKa_AREF", "siderite"),
    ("Chlorite_SMR-13.a_104-150um_BECKa_AREF", "chlorite"),
    ("Antigorite_NMNH96917.a_gt250_BECKb_AREF", "antigorite"),
    ("Chalcedony_CU91-6A_BECKa_AREF", "chalcedony"),
    ("Topaz_HS184.3B_BECKb_AREF", "topaz"),
];

fn reflectances() -> Vec<Record> {
    let mut records = Vec::new();
    let charts = [
        ("colorchecker", "reflectance/colorchecker_babelcolor_average_10nm"),
        ("colorchecker-ohta", "reflectance/colorchecker_ohta1997_5nm"),
    ];
    for (chart, file) in charts {
        for patch in columns(file) {
            // The greys carry their density: `white_9.5_(.05_D)`.
            let name = patch.split("_(").next().unwrap_or(&patch).replace('_', "-");
            let short = match name.split('-').next() {
                Some(word @ ("white" | "black")) => vec![format!("{chart}/{word}")],
                _ => Vec::new(),
            };
            let name = format!("{chart}/{name}");
            records.push(Record { aliases: short, ..column(Kind::Reflectance, name, &[], file, &patch) });
        }
    }
    let tcs = "reflectance/cie13_3_tcs_5nm";
    records.extend(
        columns(tcs)
            .iter()
            .map(|name| column(Kind::Reflectance, format!("cie13.3/{name}"), &[name], tcs, name)),
    );
    records.extend(USGS.iter().map(|(col, name)| {
        let file = "reflectance/usgs_splib07a_minerals_vegetation_2nm";
        column(Kind::Reflectance, format!("usgs/{name}"), &[], file, col)
    }));
    let derived = "reflectance/derived_normal_incidence_metals_5nm";
    let stems = columns(derived);
    for metal in METALS.iter().filter(|metal| stems.iter().any(|stem| stem == metal.stem())) {
        let name = format!("derived/{}/{}", metal.symbol, metal.author);
        records.push(column(Kind::Reflectance, name, &[], derived, metal.stem()));
    }
    let basis = "rgb_upsampling/mallett_yuksel_2019_srgb_5nm";
    records.extend(
        columns(basis)
            .iter()
            .map(|name| column(Kind::Reflectance, format!("mallett-yuksel/{name}"), &[], basis, name)),
    );
    records
}

struct Metal {
    file: &'static str,
    symbol: &'static str,
    english: &'static str,
    author: &'static str,
    /// Whether the symbol and the English name alone mean this set.
    default: bool,
}

impl Metal {
    /// The table's name without its folder, which is the column's name in the table of derived reflectances.
    fn stem(&self) -> &'static str {
        self.file.trim_start_matches("metals/")
    }
}

const fn metal(
    file: &'static str,
    symbol: &'static str,
    english: &'static str,
    author: &'static str,
    default: bool,
) -> Metal {
    Metal { file, symbol, english, author, default }
}

const METALS: [Metal; 42] = [
    metal("metals/gold_Au_johnson_christy", "Au", "gold", "johnson-christy", true),
    metal("metals/gold_Au_mcpeak2015", "Au", "gold", "mcpeak", false),
    metal("metals/silver_Ag_johnson_christy", "Ag", "silver", "johnson-christy", true),
    metal("metals/silver_Ag_mcpeak2015", "Ag", "silver", "mcpeak", false),
    metal("metals/copper_Cu_johnson_christy", "Cu", "copper", "johnson-christy", true),
    metal("metals/copper_Cu_mcpeak2015", "Cu", "copper", "mcpeak", false),
    metal("metals/aluminium_Al_rakic1995", "Al", "aluminium", "rakic", true),
    metal("metals/aluminium_Al_mcpeak2015", "Al", "aluminium", "mcpeak", false),
    metal("metals/chromium_Cr_johnson_christy", "Cr", "chromium", "johnson-christy", true),
    metal("metals/nickel_Ni_johnson_christy", "Ni", "nickel", "johnson-christy", true),
    metal("metals/titanium_Ti_johnson_christy", "Ti", "titanium", "johnson-christy", true),
    metal("metals/iron_Fe_johnson_christy", "Fe", "iron", "johnson-christy", true),
    metal("metals/cobalt_Co_johnson_christy", "Co", "cobalt", "johnson-christy", true),
    metal("metals/palladium_Pd_johnson_christy", "Pd", "palladium", "johnson-christy", true),
    metal("metals/vanadium_V_johnson_christy", "V", "vanadium", "johnson-christy", true),
    metal("metals/manganese_Mn_johnson_christy", "Mn", "manganese", "johnson-christy", true),
    metal("metals/tungsten_W_weaver", "W", "tungsten", "weaver", true),
    metal("metals/tungsten_W_rakic1998_bb", "W", "tungsten", "rakic", false),
    metal("metals/platinum_Pt_rakic1998_bb", "Pt", "platinum", "rakic", true),
    metal("metals/zinc_Zn_querry", "Zn", "zinc", "querry", true),
    metal("metals/mercury_Hg_inagaki", "Hg", "mercury", "inagaki", true),
    metal("metals/brass_Cu70Zn30_querry", "Cu70Zn30", "brass", "querry", true),
    metal("metals/brass_Cu90Zn10_querry", "Cu90Zn10", "red-brass", "querry", true),
    metal("metals/stainless_steel_austenitic_karlsson", "stainless-steel", "steel", "karlsson", true),
    metal("metals/titanium_nitride_TiN_pfluger", "TiN", "titanium-nitride", "pfluger", true),
    metal("metals/silicon_Si_schinke", "Si", "silicon", "schinke", true),
    metal("metals/beryllium_Be_rakic1998_bb", "Be", "beryllium", "rakic", true),
    metal("metals/iridium_Ir_schmitt", "Ir", "iridium", "schmitt", true),
    metal("metals/lithium_Li_mathewson", "Li", "lithium", "mathewson", true),
    metal("metals/molybdenum_Mo_querry", "Mo", "molybdenum", "querry", true),
    metal("metals/niobium_Nb_weaver", "Nb", "niobium", "weaver", true),
    metal("metals/potassium_K_smith", "K", "potassium", "smith", true),
    metal("metals/rhodium_Rh_weaver", "Rh", "rhodium", "weaver", true),
    metal("metals/sodium_Na_smith", "Na", "sodium", "smith", true),
    metal("metals/tellurium_Te_o_guo", "Te", "tellurium", "guo", true),
    metal("metals/tellurium_Te_e_guo", "Te-e", "tellurium-e", "guo", true),
    metal("metals/carbon_amorphous_C_arakawa", "a-C", "amorphous-carbon", "arakawa", true),
    metal("metals/titanium_carbide_TiC_pfluger", "TiC", "titanium-carbide", "pfluger", true),
    metal("metals/vanadium_carbide_VC_pfluger", "VC", "vanadium-carbide", "pfluger", true),
    metal("metals/vanadium_nitride_VN_pfluger", "VN", "vanadium-nitride", "pfluger", true),
    metal("metals/aluminium_arsenide_AlAs_rakic1996", "AlAs", "aluminium-arsenide", "rakic", true),
    metal("metals/aluminium_antimonide_AlSb_zollner", "AlSb", "aluminium-antimonide", "zollner", true),
];

fn conductors() -> Vec<Record> {
    let record = |metal: &Metal| {
        let mut aliases = vec![format!("{}/{}", metal.english, metal.author)];
        if metal.default {
            aliases.extend([metal.symbol.to_owned(), metal.english.to_owned()]);
        }
        if metal.symbol == "Al" {
            aliases.extend(
                aliases.clone().iter().filter(|a| a.contains("minium")).map(|a| a.replace("minium", "minum")),
            );
        }
        let name = format!("{}/{}", metal.symbol, metal.author);
        let plain = column(Kind::Conductor, name, &[], metal.file, "n");
        Record { aliases, reading: Reading::ComplexIndex, ..plain }
    };
    let clear = CLEAR.map(|(row, name, aliases)| Record {
        reading: Reading::Clear,
        ..column(Kind::Conductor, name, aliases, FORMULAS, row)
    });
    METALS.iter().map(record).chain(clear).collect()
}

/// Clear bodies that Mitsuba 3 has among its metals.
const CLEAR: [(&str, &str, &[&str]); 7] = [
    ("CsI", "CsI/li", &["CsI"]),
    ("MgO", "MgO/stephens", &["MgO"]),
    ("ThF4", "ThF4/heitmann", &["ThF4"]),
    ("SiC_6H_o", "SiC/wang", &["SiC"]),
    ("rutile_TiO2_o", "TiO2/devore-o", &["TiO2"]),
    ("rutile_TiO2_e", "TiO2/devore-e", &["TiO2-e"]),
    ("diamond", "d-C/peter", &["d-C"]),
];

const FORMULAS: &str = "dielectrics/dispersion_formulas";

/// Rows of the table of formulas whose name here is not simply theirs, and further names.
const GLASSES: [(&str, &str, &[&str]); 21] = [
    ("BK7", "BK7", &["N-BK7", "crown-glass"]),
    ("LASF9N", "LASFN9", &["LASF9N"]),
    ("fused_silica", "fused-silica", &["silica", "quartz-glass", "SiO2"]),
    ("sapphire_o", "sapphire-o", &["sapphire"]),
    ("diamond", "diamond", &["C"]),
    ("water_20C", "water-20C", &["water"]),
    ("carbon_disulfide", "carbon-disulfide", &["carbon-disulphide", "CS2"]),
    ("methylene_iodide", "methylene-iodide", &["diiodomethane", "CH2I2"]),
    ("MgF2_o", "MgF2-o", &["MgF2"]),
    ("quartz_o", "quartz-o", &["quartz"]),
    ("calcite_o", "calcite-o", &["calcite"]),
    ("rutile_TiO2_o", "rutile-o", &["rutile", "TiO2", "rutile-TiO2-o"]),
    ("rutile_TiO2_e", "rutile-e", &["rutile-TiO2-e"]),
    ("NaCl", "NaCl", &["salt"]),
    ("PMMA", "PMMA", &["acrylic", "acrylic-glass"]),
    ("polycarbonate", "polycarbonate", &["PC"]),
    ("polystyrene", "polystyrene", &["PS"]),
    ("soda_lime_clear", "soda-lime", &["soda-lime-clear", "window-glass"]),
    ("air_15C_ciddor", "air-15C", &["air"]),
    ("spinel_MgAl2O4", "spinel", &["MgAl2O4"]),
    ("SiC_6H_o", "SiC-6H-o", &["SiC"]),
];

fn dielectrics() -> Vec<Record> {
    let table = TableFile::parse(data::text(FORMULAS)).expect("the built-in tables are well formed");
    let rows = table.texts("name").expect("the formulas have names");
    let formula = |row: &str| {
        let plain = row.replace('_', "-");
        let known = GLASSES.iter().find(|(known, ..)| *known == row);
        let (name, aliases) = known.map_or((plain.as_str(), &[][..]), |(_, name, aliases)| (*name, *aliases));
        Record { reading: Reading::Formula, ..column(Kind::Dielectric, name, aliases, FORMULAS, row) }
    };
    let tables = [
        ("ice", &["ice/warren"][..], "absorption/ice_warren2008"),
        ("water/hale-querry", &[], "absorption/water_hale_querry1973"),
        ("water/segelstein", &[], "absorption/water_segelstein1981"),
        ("rhodamine-6G", &[], "absorption/dye_rhodamine6g_film"),
    ];
    let tabulated = tables.map(|(name, aliases, file)| Record {
        reading: Reading::Index,
        ..column(Kind::Dielectric, name, aliases, file, "n")
    });
    rows.into_iter().map(formula).chain(tabulated).collect()
}

const ABSORPTIONS: [(&str, &[&str], &str); 20] = [
    ("water/williamson", &["water"], "absorption/water_pure_williamson2022"),
    ("water/segelstein", &[], "absorption/water_segelstein1981"),
    ("water/hale-querry", &[], "absorption/water_hale_querry1973"),
    ("ice", &["ice/warren"], "absorption/ice_warren2008"),
    ("soda-lime-clear", &["soda-lime", "window-glass"], "absorption/soda_lime_clear_rubin1985"),
    ("soda-lime-low-iron", &[], "absorption/soda_lime_lowiron_rubin1985"),
    ("soda-lime-green", &["green-glass"], "absorption/soda_lime_green_rubin1985"),
    ("soda-lime-bronze", &["bronze-glass"], "absorption/soda_lime_bronze_rubin1985"),
    ("soda-lime-grey", &["grey-glass"], "absorption/soda_lime_grey_rubin1985"),
    ("N-BK7", &["BK7"], "absorption/glass_schott_n-bk7"),
    ("F2", &[], "absorption/glass_schott_f2"),
    ("SF11", &[], "absorption/glass_schott_sf11"),
    ("N-SF66", &[], "absorption/glass_schott_n-sf66"),
    ("isuzu-IEB470", &["blue-filter"], "absorption/filter_glass_isuzu_ieb470_blue"),
    ("isuzu-IEC578", &["light-blue-filter"], "absorption/filter_glass_isuzu_iec578_light_blue"),
    ("isuzu-ILA400", &["amber-filter"], "absorption/filter_glass_isuzu_ila400_amber_light_balancing"),
    ("isuzu-ISK167", &["heat-absorbing-filter"], "absorption/filter_glass_isuzu_isk167_heat_absorbing"),
    ("isuzu-ITY430", &["yellow-filter"], "absorption/filter_glass_isuzu_ity430_uv_cut_yellowish"),
    ("isuzu-IVG540", &["green-filter"], "absorption/filter_glass_isuzu_ivg540_green"),
    ("rhodamine-6G", &[], "absorption/dye_rhodamine6g_film"),
];

fn absorptions() -> Vec<Record> {
    let mut records: Vec<Record> = ABSORPTIONS
        .iter()
        .map(|(name, aliases, file)| column(Kind::Absorption, *name, aliases, file, "absorption_per_m"))
        .collect();
    let blood = [
        ("blood-oxygenated", &["blood"][..], "HbO2_molar_extinction"),
        ("blood-deoxygenated", &[], "Hb_molar_extinction"),
    ];
    records.extend(blood.map(|(name, aliases, col)| Record {
        reading: Reading::Blood,
        ..column(Kind::Absorption, name, aliases, "absorption/blood_hemoglobin_prahl", col)
    }));
    records
}

fn sensitivities() -> Vec<Record> {
    let tables = [
        ("cie1931-2deg", "cie/cmf_cie1931_2deg_1nm"),
        ("cie1964-10deg", "cie/cmf_cie1964_10deg_1nm"),
        ("cie2015-2deg", "cie/cmf_cie2015_2deg_1nm"),
        ("cie2015-10deg", "cie/cmf_cie2015_10deg_1nm"),
        ("cone", "cie/cone_fundamentals_stockman_sharpe_2deg_1nm"),
    ];
    let record = |(prefix, file): (&str, &'static str)| {
        let one = move |col: String| {
            let letter = col.chars().take(1).collect::<String>();
            let letter = if prefix == "cone" { letter.to_uppercase() } else { letter };
            column(Kind::Sensitivity, format!("{prefix}/{letter}"), &[], file, &col)
        };
        columns(file).into_iter().map(one).collect::<Vec<_>>()
    };
    let photons = column(Kind::Sensitivity, "photons", &[], "photons/photons_per_joule", "photons");
    tables.into_iter().flat_map(record).chain([photons]).collect()
}
