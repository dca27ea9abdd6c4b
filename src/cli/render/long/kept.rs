use super::super::super::{Failure, print_message};
use super::super::cannot_write;
use super::LongOptions;
use abbe::output::checkpoint::{self, Description, Header};
use abbe::render::{Auxiliary, Work};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// What is kept of a render on the way.
pub struct Kept {
    /// `None` where nothing is.
    pub path: Option<PathBuf>,
    pub identity: Vec<(String, String)>,
    pub picture: Description,
    pub samples_per_pixel: u64,
    pub threads: usize,
}

impl Kept {
    /// Where the render begins: at the checkpoint that it is to go on from, or with nothing done.
    pub fn begin(&self, work: Work, options: &LongOptions, quiet: bool) -> Result<Work, Failure> {
        let Some(path) = self.path.as_ref().filter(|_| options.resume) else {
            return match &self.path {
                Some(path) if path.exists() => Err(Failure::Input(format!(
                    "error: {} is there already\nhelp: --resume goes on from it; remove it to begin anew",
                    path.display()
                ))),
                _ => Ok(work),
            };
        };
        if !path.exists() {
            if !quiet {
                print_message(&format!("there is no {}: beginning anew", path.display()));
            }
            return Ok(work);
        }
        let failed = |error| cannot_read_content(path, &error, "remove it to begin anew");
        let opened = checkpoint::open(path).map_err(failed)?;
        let wrong = |what: &str, [there, here]: [&str; 2]| {
            Failure::Input(format!(
                "error: {} is of another picture: {what} is {there} there and {here} here\n\
                 help: resume it as it was begun, or give another -o",
                path.display()
            ))
        };
        if let Some([what, there, here]) = opened.header.mismatch(&self.identity) {
            return Err(wrong(&what, [&there, &here]));
        }
        let own = Header::of(&work, &self.identity, &self.picture, self.samples_per_pixel, &[]).render;
        let (Some((there, _)), Some((here, _))) = (&opened.header.render, &own) else {
            return Err(Failure::Input(format!(
                "error: {} was put together from parts: no render goes on from it",
                path.display()
            )));
        };
        if there != here {
            return Err(wrong("the part", [&there.to_string(), &here.to_string()]));
        }
        let resumed = opened.resumed(work).map_err(failed)?;
        Ok(resumed)
    }

    /// Keeps what is done.
    pub fn write(&self, work: &Work, images: &[Auxiliary]) -> Result<(), Failure> {
        let Some(path) = &self.path else { return Ok(()) };
        self.try_to_write(path, work, images).map_err(|error| cannot_write(path, &error))
    }

    pub(super) fn try_to_write(&self, path: &Path, work: &Work, images: &[Auxiliary]) -> std::io::Result<()> {
        let header = Header::of(work, &self.identity, &self.picture, self.samples_per_pixel, images);
        checkpoint::write(path, &header, work.film(), images, self.threads)
    }
}

/// A file that cannot be read. `remedy`: what to do where it is its content that is wrong.
pub fn cannot_read_content(path: &Path, error: &std::io::Error, remedy: &str) -> Failure {
    match error.kind() {
        ErrorKind::InvalidData => {
            Failure::Input(format!("error: cannot read {}: {error}\nhelp: {remedy}", path.display()))
        }
        _ => cannot_read(path, error),
    }
}

/// A file that cannot be read.
pub fn cannot_read(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Input(format!("error: cannot read {}: {error}", path.display()))
}
