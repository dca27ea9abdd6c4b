use super::Failure;
use abbe::scene::{self, Description, ReadOptions};
use std::path::PathBuf;

/// Which scene, and what its file leaves open.
#[derive(clap::Args)]
pub struct SceneOptions {
    /// Scene file: Mitsuba 3's XML, or JSON as abbe info --json writes it
    pub scene: PathBuf,

    /// Give a value to a parameter that the scene declares with <default>; may be repeated
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = parse_define)]
    pub defines: Vec<(String, String)>,

    /// Which of the scene's sensors is meant, counted from 0
    #[arg(short = 's', long, value_name = "N", default_value = "0")]
    pub sensor: usize,

    /// Read the n and k of metals from NAME.eta.spd and NAME.k.spd in a folder, such as mitsuba/data/ior of an
    /// installed Mitsuba; names that it lacks are abbe's own
    #[arg(long, value_name = "DIR")]
    pub ior_tables: Option<PathBuf>,
}

impl SceneOptions {
    pub fn read(&self) -> Result<Description, Failure> {
        self.read_with(&self.defines)
    }

    /// With other values for the parameters.
    pub fn read_with(&self, defines: &[(String, String)]) -> Result<Description, Failure> {
        let (sensor, ior_tables) = (self.sensor, self.ior_tables.clone());
        let options = ReadOptions { defines: defines.to_vec(), sensor, ior_tables };
        scene::read(&self.scene, &options).map_err(|errors| Failure::Input(errors.to_string()))
    }
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("expected NAME=VALUE, for example spp=64".to_owned()),
    }
}
