use super::Failure;
use super::whole::whole;
use abbe::film::Region;
use abbe::scene::description::IntegratorKind;
use abbe::scene::{self, Crop, Description, ReadOptions};
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
    #[arg(short = 's', long, value_name = "N", default_value = "0", value_parser = whole::<usize>(0..=usize::MAX as u64))]
    pub sensor: usize,

    /// Read the n and k of metals from NAME.eta.spd and NAME.k.spd in a folder, such as mitsuba/data/ior of
    /// an installed Mitsuba; names that it lacks are abbe's own
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

/// Which picture of a scene is made, in place of what its file says.
#[derive(clap::Args)]
pub struct PictureOptions {
    /// Size of the picture in pixels [default: what the scene says]
    #[arg(long, value_name = "WxH", value_parser = parse_size, allow_hyphen_values = true)]
    pub size: Option<[u32; 2]>,

    /// Only these pixels: as many across and down from column X and row Y on, counted from the corner of the
    /// whole film. Each is what it is in the whole picture, bit by bit
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop, allow_hyphen_values = true)]
    pub crop: Option<Region>,

    /// Longest path, in segments from the camera to the light: 1 shows lights alone, 2 direct light, -1 has
    /// no limit [default: what the scene says]
    #[arg(long, value_name = "N", value_parser = parse_depth)]
    pub max_depth: Option<u32>,
}

impl PictureOptions {
    /// What the command line says goes over what the file says.
    pub fn apply_to(&self, description: &mut Description) {
        if let Some([width, height]) = self.size {
            // A crop is in pixels of the size that the file gives: another size is of the whole picture.
            let film = &mut description.sensor.film;
            (film.width, film.height, film.crop) = (width, height, None);
        }
        if let Some(wanted) = self.max_depth {
            let integrator = &mut description.integrator;
            let wanted = Some(wanted).filter(|&wanted| wanted != ANY_DEPTH);
            integrator.max_depth = match integrator.kind {
                // It is made for short paths alone.
                IntegratorKind::Direct => integrator.max_depth.into_iter().chain(wanted).min(),
                _ => wanted,
            };
        }
    }

    /// The part that is asked for, with a margin for what its pixels depend on.
    pub fn part(&self, margin: u32, square: u32) -> Option<Crop> {
        self.crop.map(|shown| Crop { shown, margin, square })
    }
}

/// Segments of a path that has as many as it happens to have.
const ANY_DEPTH: u32 = u32::MAX;

fn parse_depth(text: &str) -> Result<u32, String> {
    if text == "-1" {
        return Ok(ANY_DEPTH);
    }
    text.parse().map_err(|_| "expected a number of segments, or -1 for any number".to_owned())
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let size = text.split_once(['x', '×']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match size {
        Some(size) if size.iter().all(|&edge| (1..=65_536).contains(&edge)) => Ok(size),
        _ => Err("expected WIDTHxHEIGHT in pixels, each 1 to 65536, for example 640x360".to_owned()),
    }
}

fn parse_crop(text: &str) -> Result<Region, String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => {
            Ok(Region { offset: [x, y], size: [width, height] })
        }
        _ => Err("expected X,Y,WIDTH,HEIGHT in pixels of the whole film, for example 100,0,64,32".to_owned()),
    }
}

fn parse_define(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err("expected NAME=VALUE, for example spp=64".to_owned()),
    }
}
