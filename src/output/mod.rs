//! What is kept of a render: the EXR with everything, and a PNG to look at.

pub mod checkpoint;
pub mod error_bars;
pub mod exr;
pub mod png;
pub mod target;

use crate::film::Film;
use crate::render::Auxiliary;
use crate::spectrum::colour::{self, RgbSpace};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Pixels around a part of a picture that its error bars look at.
pub const MARGIN: u32 = error_bars::REACH;
/// Edge of the squares of pixels that they look at as a whole.
pub const SQUARE: u32 = error_bars::SQUARE;

/// A developed film: what goes into a file.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// What was measured.
    pub film: &'a Film,
    /// What the main channels are.
    pub content: Content,
    /// What the names of the channels begin with that hold the means of X, Y and Z and their second moments,
    /// where the film measures them.
    pub moments: Option<[String; 2]>,
    /// Further images, each with as many values as the film has pixels.
    pub auxiliary: Vec<Auxiliary>,
    /// How it was made: name and text.
    pub attributes: Vec<(String, String)>,
}

/// What the main channels of a file are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Content {
    /// With alpha if the film has it. Colours are those of what the pixel sees, whatever share of it that is:
    /// they need not be multiplied by alpha.
    Colour(Colour),
    /// The names of the film's responses.
    Responses(Vec<String>),
}

/// What the colour channels of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Colour {
    /// Linear, with the primaries and the white point of Rec. ITU-R BT.709.
    Rec709,
    /// CIE X, Y and Z, in the unit of the film.
    Xyz,
    /// CIE Y alone.
    Luminance,
}

impl Colour {
    /// Name and weights of X, Y, Z for each channel.
    pub fn channels(self) -> &'static [(&'static str, [f64; 3])] {
        const RGB: [(&str, [f64; 3]); 3] = [
            ("R", colour::XYZ_TO_REC709[0]),
            ("G", colour::XYZ_TO_REC709[1]),
            ("B", colour::XYZ_TO_REC709[2]),
        ];
        const XYZ: [(&str, [f64; 3]); 3] =
            [("X", [1.0, 0.0, 0.0]), ("Y", [0.0, 1.0, 0.0]), ("Z", [0.0, 0.0, 1.0])];
        match self {
            Self::Rec709 => &RGB,
            Self::Xyz => &XYZ,
            Self::Luminance => &XYZ[1..2],
        }
    }

    /// xy chromaticities of red, green, blue and white.
    fn primaries(self) -> [[f32; 2]; 4] {
        match self {
            Self::Rec709 => {
                let RgbSpace { primaries: [red, green, blue], white } = RgbSpace::REC709;
                [red, green, blue, white].map(|(x, y)| [x as f32, y as f32])
            }
            Self::Xyz | Self::Luminance => [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]],
        }
    }
}

impl Picture<'_> {
    /// Whether there are the two replicates that a standard error needs.
    pub fn has_errors(&self) -> bool {
        self.film.replicates >= 2
    }

    /// What the file would have that no file can have: two channels of one name, or a channel without a name
    /// or with too long a one. `others` are the names of images that are still to come.
    pub fn refused_name(
        content: &Content,
        moments: Option<&[String; 2]>,
        others: &[String],
    ) -> Option<String> {
        let colours = |colour: Colour| colour.channels().iter().map(|(name, _)| (*name).to_owned()).collect();
        let mut names: Vec<String> = match content {
            Content::Colour(colour) => colours(*colour),
            Content::Responses(names) => names.clone(),
        };
        names.extend(["A".to_owned(), "samples".to_owned()]);
        names.extend(
            moments.into_iter().flatten().flat_map(|stem| ["X", "Y", "Z"].map(|xyz| format!("{stem}.{xyz}"))),
        );
        let mut known = BTreeSet::new();
        names.iter().chain(others).find_map(|name| match name.len() {
            0 => Some("a channel without a name".to_owned()),
            length if length > LONGEST_NAME => Some(format!("a channel whose name has {length} bytes")),
            _ => (!known.insert(name)).then(|| format!("two channels \"{name}\"")),
        })
    }
}

/// Bytes of the longest name that a channel may have: OpenEXR takes 255, and `error.` may stand before it.
const LONGEST_NAME: usize = 249;

/// Where a symbolic link leads to: the link stays.
fn followed(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Where a file is made before it is moved to its place.
fn unfinished(path: &Path) -> std::io::Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| std::io::Error::other("the path names no file"))?;
    let mut unfinished = name.to_os_string();
    unfinished.push(".unfinished");
    Ok(path.with_file_name(unfinished))
}

/// Whether [`write_whole`] could write there, as far as can be told before there is anything to write. What
/// is there stays.
///
/// # Errors
/// What it would fail with.
pub fn refuse_unwritable(path: &Path) -> std::io::Result<()> {
    if path.is_dir() {
        return Err(std::io::ErrorKind::IsADirectory.into());
    }
    let unfinished = unfinished(&followed(path))?;
    std::fs::File::create(&unfinished)?;
    std::fs::remove_file(&unfinished)
}

/// Writes a file beside its place and moves it there when it is whole.
pub fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    write_through(path, |file| file.write_all(bytes))
}

/// The same of a file that is made bit by bit. Whatever happens, at its place is either all that was there
/// before or all that is written now. A pipe or a terminal is written to as it is.
fn write_through(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> std::io::Result<()> {
    let path = &followed(path);
    if path.exists() && !path.is_file() && !path.is_dir() {
        let mut file = BufWriter::new(File::options().write(true).open(path)?);
        write(&mut file)?;
        return file.flush();
    }
    let unfinished = unfinished(path)?;
    let written = (|| {
        let mut file = BufWriter::new(File::create(&unfinished)?);
        write(&mut file)?;
        file.into_inner()?.sync_all()?;
        std::fs::rename(&unfinished, path)?;
        // That it has moved is a change of the folder. Where a file system knows of no such thing, it is not
        // in our hands.
        if let Ok(folder) = File::open(folder_of(path)) {
            let _ = folder.sync_all();
        }
        Ok(())
    })();
    if written.is_err() {
        // The first error is the one to report; that nothing could be tidied up either says no more.
        let _ = std::fs::remove_file(&unfinished);
    }
    written
}

/// The folder that a file is in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
