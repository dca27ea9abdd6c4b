use super::{Request, Run, RunId};
use crate::output::{refuse_unwritable, write_whole};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io;
use std::path::{Path, PathBuf};

/// Where a study keeps what it has found. Every file is written beside its place and moved there when it is
/// whole.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

/// Why a folder is not that of this study.
#[derive(Debug)]
pub enum ForeignStudy {
    /// It has files and none is a study's.
    NotAStudy,
    /// What says whose it is, a file in it, is damaged.
    Damaged(PathBuf),
    /// Another study's: what differs, as far as it can be told.
    Another(Vec<String>),
    /// A file cannot be read or written.
    Io(io::Error),
}

/// The part of `study.json` by which a study is known again.
#[derive(Deserialize, Serialize)]
struct Header {
    study: Value,
}

const STUDY: &str = "study.json";

impl Folder {
    /// Begins a study, or continues the same one. Changes nothing in a foreign folder.
    pub fn open(path: &Path, request: &Request) -> Result<Self, ForeignStudy> {
        let folder = Self { path: path.to_owned() };
        let wanted = serde_json::to_value(request).map_err(|error| ForeignStudy::Io(error.into()))?;
        match std::fs::read(folder.file(STUDY)) {
            Ok(bytes) => {
                let header: Header =
                    serde_json::from_slice(&bytes).map_err(|_| ForeignStudy::Damaged(folder.file(STUDY)))?;
                if header.study != wanted {
                    return Err(ForeignStudy::Another(differences(&header.study, &wanted)));
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                if path.is_dir() && std::fs::read_dir(path).map_err(ForeignStudy::Io)?.next().is_some() {
                    return Err(ForeignStudy::NotAStudy);
                }
            }
            Err(error) => return Err(ForeignStudy::Io(error)),
        }
        Ok(folder)
    }

    /// Makes the folder and says in it whose it is, where that has not been done.
    pub fn prepare(&self, request: &Request) -> io::Result<()> {
        for part in ["runs", "plots"] {
            std::fs::create_dir_all(self.file(part))?;
        }
        if self.file(STUDY).exists() {
            return refuse_unwritable(&self.file(STUDY));
        }
        let header = Header { study: serde_json::to_value(request)? };
        self.write(STUDY, &serde_json::to_vec_pretty(&header)?)
    }

    /// The path of a file in it.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// The path of the reference picture of a case.
    pub fn reference(&self, case: usize) -> PathBuf {
        self.file(&format!("reference-case{case}.exr"))
    }

    /// Writes a file as a whole or not at all.
    pub fn write(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        write_whole(&self.file(name), bytes)
    }

    fn run_file(id: &RunId) -> String {
        format!("runs/{}.json", id.name())
    }

    /// A run that has been finished before. One that cannot be read is as good as none.
    pub fn run(&self, id: &RunId) -> Option<Run> {
        let run: Run = serde_json::from_slice(&std::fs::read(self.file(&Self::run_file(id))).ok()?).ok()?;
        (run.id == *id).then_some(run)
    }

    /// Keeps what a run has found.
    pub fn keep(&self, run: &Run) -> io::Result<()> {
        self.write(&Self::run_file(&run.id), &serde_json::to_vec(run)?)
    }
}

/// What two requests do not have in common.
fn differences(found: &Value, wanted: &Value) -> Vec<String> {
    let (Value::Object(found), Value::Object(wanted)) = (found, wanted) else { return Vec::new() };
    let short = |value: &Value| {
        let text = value.to_string();
        if text.chars().count() > 60 { text.chars().take(57).collect::<String>() + "..." } else { text }
    };
    wanted
        .iter()
        .filter(|&(name, value)| found.get(name) != Some(value))
        .map(|(name, value)| match found.get(name) {
            Some(had) if short(had) != short(value) => {
                format!("{name}: {} there, {} asked for", short(had), short(value))
            }
            _ => format!("{name} differs"),
        })
        .collect()
}
