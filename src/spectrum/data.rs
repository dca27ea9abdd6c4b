//! The published tables of `data/`, compiled into the program so that it needs no files at run time.

macro_rules! tables {
    ($($name:literal),* $(,)?) => {
        /// Name (path below `data/` without `.csv`) and text of every table.
        pub(super) const FILES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../data/", $name, ".csv")))),*];
    };
}

tables! {
    "absorption/blood_hemoglobin_prahl",
    "absorption/dye_rhodamine6g_film",
    "absorption/filter_glass_isuzu_ieb470_blue",
    "absorption/filter_glass_isuzu_iec578_light_blue",
    "absorption/filter_glass_isuzu_ila400_amber_light_balancing",
    "absorption/filter_glass_isuzu_isk167_heat_absorbing",
    "absorption/filter_glass_isuzu_ity430_uv_cut_yellowish",
    "absorption/filter_glass_isuzu_ivg540_green",
    "absorption/glass_schott_f2",
    "absorption/glass_schott_n-bk7",
    "absorption/glass_schott_n-sf66",
    "absorption/glass_schott_sf11",
    "absorption/ice_warren2008",
    "absorption/soda_lime_bronze_rubin1985",
    "absorption/soda_lime_clear_rubin1985",
    "absorption/soda_lime_green_rubin1985",
    "absorption/soda_lime_grey_rubin1985",
    "absorption/soda_lime_lowiron_rubin1985",
    "absorption/water_hale_querry1973",
    "absorption/water_pure_williamson2022",
    "absorption/water_segelstein1981",
    "cie/cmf_cie1931_2deg_1nm",
    "cie/cmf_cie1964_10deg_1nm",
    "cie/cmf_cie2015_10deg_1nm",
    "cie/cmf_cie2015_2deg_1nm",
    "cie/cone_fundamentals_stockman_sharpe_2deg_1nm",
    "dielectrics/dispersion_formulas",
    "illuminants/cie_a_c_daylight_5nm",
    "illuminants/cie_a_formula_1nm",
    "illuminants/cie_daylight_basis_s0_s1_s2_5nm",
    "illuminants/cie_e",
    "illuminants/cie_fl1_fl12_5nm",
    "illuminants/cie_fl3_series_5nm",
    "illuminants/cie_hp1_hp5_5nm",
    "illuminants/cie_indoor_daylight_5nm",
    "illuminants/cie_led_5nm",
    "illuminants/light_sources_380_780_5nm",
    "metals/aluminium_Al_mcpeak2015",
    "metals/aluminium_Al_rakic1995",
    "metals/aluminium_antimonide_AlSb_zollner",
    "metals/aluminium_arsenide_AlAs_rakic1996",
    "metals/beryllium_Be_rakic1998_bb",
    "metals/brass_Cu70Zn30_querry",
    "metals/brass_Cu90Zn10_querry",
    "metals/carbon_amorphous_C_arakawa",
    "metals/chromium_Cr_johnson_christy",
    "metals/cobalt_Co_johnson_christy",
    "metals/copper_Cu_johnson_christy",
    "metals/copper_Cu_mcpeak2015",
    "metals/gold_Au_johnson_christy",
    "metals/gold_Au_mcpeak2015",
    "metals/iridium_Ir_schmitt",
    "metals/iron_Fe_johnson_christy",
    "metals/lithium_Li_mathewson",
    "metals/manganese_Mn_johnson_christy",
    "metals/mercury_Hg_inagaki",
    "metals/molybdenum_Mo_querry",
    "metals/nickel_Ni_johnson_christy",
    "metals/niobium_Nb_weaver",
    "metals/palladium_Pd_johnson_christy",
    "metals/platinum_Pt_rakic1998_bb",
    "metals/potassium_K_smith",
    "metals/rhodium_Rh_weaver",
    "metals/silicon_Si_schinke",
    "metals/silver_Ag_johnson_christy",
    "metals/silver_Ag_mcpeak2015",
    "metals/sodium_Na_smith",
    "metals/stainless_steel_austenitic_karlsson",
    "metals/tellurium_Te_e_guo",
    "metals/tellurium_Te_o_guo",
    "metals/titanium_Ti_johnson_christy",
    "metals/titanium_carbide_TiC_pfluger",
    "metals/titanium_nitride_TiN_pfluger",
    "metals/tungsten_W_rakic1998_bb",
    "metals/tungsten_W_weaver",
    "metals/vanadium_V_johnson_christy",
    "metals/vanadium_carbide_VC_pfluger",
    "metals/vanadium_nitride_VN_pfluger",
    "metals/zinc_Zn_querry",
    "photons/photons_per_joule",
    "reflectance/cie13_3_tcs_5nm",
    "reflectance/colorchecker_babelcolor_average_10nm",
    "reflectance/colorchecker_ohta1997_5nm",
    "reflectance/derived_normal_incidence_metals_5nm",
    "reflectance/usgs_splib07a_minerals_vegetation_2nm",
    "rgb_upsampling/mallett_yuksel_2019_srgb_5nm",
    "sky/hosek_wilkie_limb_darkening",
    "sky/hosek_wilkie_sky",
    "sky/hosek_wilkie_sun",
    "sky/mitsuba_sun_irradiance",
}

/// The text of one table; empty if there is none of that name.
pub(crate) fn text(name: &str) -> &'static str {
    FILES.iter().find(|(file, _)| *file == name).map_or("", |(_, text)| text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_table_of_the_folder_is_here() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
        let mut found = Vec::new();
        for folder in std::fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path()) {
            for path in std::fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path()) {
                if path.extension().is_some_and(|extension| extension == "csv") {
                    let relative = path.strip_prefix(&root).unwrap().with_extension("");
                    found.push(relative.to_str().unwrap().replace('\\', "/"));
                }
            }
        }
        found.sort();
        assert_eq!(found, FILES.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    }
}
