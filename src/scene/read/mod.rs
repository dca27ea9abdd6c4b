//! Reading scene files: Mitsuba 3's XML, with extensions, or the same as JSON, into a [`Description`].
//!
//! `xml` and `json` turn the text into a tree of objects with typed properties. The declarations of
//! [`super::plugins`] then ask those objects for what they know, and what is left over is reported. Errors
//! are collected, so that one run tells of all that are independent of one another.

mod ahead;
pub(super) mod aovs;
pub(super) mod attributes;
mod facing;
pub(super) mod files;
mod groups;
pub(super) mod hints;
mod json;
pub(super) mod meshes;
pub(super) mod metals;
pub(super) mod names;
mod obj;
mod parsed;
mod ply;
pub(super) mod query;
mod serialized;
pub(super) mod solids;
pub(super) mod spd;
pub(super) mod spectra;
pub(super) mod textures;
mod transforms;
mod tree;
mod whole;
mod xml;

use super::description::{Bsdf, Description, Note, Sensor, ShapeGroup, Solid, SpectrumKind, SpectrumSource};
use super::plugins::{self, bsdfs, integrators, lights, media, phases, sensors};
use super::source::{Place, SceneError, SceneErrors, Sources};
use crate::raster::{Grid, Image};
use crate::shape::MeshData;
use crate::spectrum::catalogue;
use crate::units::WavelengthRange;
use files::{Loaded, Search};
use parsed::Parsed;
pub(super) use query::Query;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
pub(super) use tree::{Class, Entry, ObjectId, Value};
use tree::{Object, Tree};

/// What the command line adds to a scene file.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Values for `$name`, which come before the file's `<default>`.
    pub defines: Vec<(String, String)>,
    /// Which of the scene's sensors is rendered, counted from 0.
    pub sensor: usize,
    /// A folder with the files `NAME.eta.spd` and `NAME.k.spd` of metals, which come before the built-in
    /// tables.
    pub ior_tables: Option<PathBuf>,
}

/// Reads the scene file at `path`. Files that it names are sought relative to its folder.
///
/// # Errors
/// Everything that is wrong with the file or the files that it names, with places.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Description, SceneErrors> {
    let unreadable = |problem: String| SceneErrors {
        sources: Sources::default(),
        errors: vec![SceneError {
            place: None,
            problem,
            expected: "expected the path of a scene file, Mitsuba 3's XML or JSON".to_owned(),
            remedy: None,
        }],
    };
    let text = files::scene_text(path).map_err(unreadable)?;
    read_str(text, path, options)
}

/// Reads a scene from `text`, as if it stood in a file at `path`.
///
/// # Errors
/// Everything that is wrong with the text or the files that it names, with places.
pub fn read_str(
    text: impl Into<String>,
    path: &Path,
    options: &ReadOptions,
) -> Result<Description, SceneErrors> {
    if let Some(folder) = &options.ior_tables {
        metals::check_folder(folder)?;
    }
    let text = files::without_mark(text.into());
    let mut sources = Sources::default();
    let file = sources.add(path, text.clone());
    let search = Search::new(path.parent().unwrap_or(Path::new("")));
    let parsed = if json::is_json(&text) {
        json::parse(&text, file, search, &options.defines, &mut sources)
    } else {
        xml::parse(&text, file, path, search, &options.defines, &mut sources)
    };
    let fatal = parsed.tree.objects.is_empty();
    let reader = Reader::new(parsed, options);
    let description = if fatal { None } else { reader.scene() };
    let mut errors = reader.errors.into_inner();
    match description {
        Some(description) if errors.is_empty() => Ok(Description {
            sources,
            files: [path.to_owned()].into_iter().chain(reader.search.found()).collect(),
            extensions: in_order(reader.extensions.into_inner()),
            assumptions: in_order(reader.assumptions.into_inner()),
            remarks: in_order(reader.remarks.into_inner()),
            ..description
        }),
        _ => {
            errors.sort_by_key(|error| error.place.as_ref().map(|place| (place.file, place.span.start)));
            errors.dedup();
            Err(SceneErrors { sources, errors })
        }
    }
}

/// Notes as the file's reader meets them, each once.
fn in_order(mut notes: Vec<Note>) -> Vec<Note> {
    notes.sort_by(|a, b| {
        (a.place.file, a.place.span.start, &a.text).cmp(&(b.place.file, b.place.span.start, &b.text))
    });
    notes.dedup_by(|a, b| a.place == b.place && a.text == b.text);
    notes
}

/// A tree being understood, with what has been said about it so far.
pub(super) struct Reader {
    pub(super) tree: Tree,
    wanted_sensor: usize,
    ior_tables: Option<PathBuf>,
    pub(super) search: Search,
    errors: RefCell<Vec<SceneError>>,
    extensions: RefCell<Vec<Note>>,
    assumptions: RefCell<Vec<Note>>,
    remarks: RefCell<Vec<Note>>,
    /// What several objects may refer to is read once.
    pub(super) bsdfs: RefCell<BTreeMap<ObjectId, Arc<Bsdf>>>,
    spectra: RefCell<BTreeMap<ObjectId, Option<SpectrumSource>>>,
    pub(super) images: Loaded<PathBuf, Image>,
    pub(super) grids: Loaded<PathBuf, Grid>,
    meshes: Loaded<meshes::MeshKey, MeshData>,
    groups: RefCell<BTreeMap<ObjectId, Arc<ShapeGroup>>>,
    /// The `merge` shapes and the solids that were read already.
    merges: RefCell<BTreeSet<ObjectId>>,
    pub(super) ahead: RefCell<ahead::Ahead>,
}

impl Reader {
    fn new(parsed: Parsed, options: &ReadOptions) -> Self {
        Self {
            tree: parsed.tree,
            wanted_sensor: options.sensor,
            ior_tables: options.ior_tables.clone(),
            search: parsed.search,
            errors: RefCell::new(parsed.errors),
            extensions: RefCell::default(),
            assumptions: RefCell::new(parsed.assumptions),
            remarks: RefCell::default(),
            bsdfs: RefCell::default(),
            spectra: RefCell::default(),
            meshes: Loaded::default(),
            images: Loaded::default(),
            grids: Loaded::default(),
            groups: RefCell::default(),
            merges: RefCell::default(),
            ahead: RefCell::default(),
        }
    }

    pub(super) fn error(&self, error: SceneError) {
        self.errors.borrow_mut().push(error);
    }

    /// Whether the scene has an animation anywhere.
    pub(super) fn anything_moves(&self) -> bool {
        let mut entries = self.tree.objects.iter().flat_map(|object| &object.entries);
        entries.any(|entry| matches!(entry.value, tree::Value::Animation(_)))
    }

    pub(super) fn extension(&self, place: &Place, text: String) {
        self.extensions.borrow_mut().push(Note::new(place, text));
    }

    pub(super) fn assumption(&self, place: &Place, text: String) {
        self.assumptions.borrow_mut().push(Note::new(place, text));
    }

    pub(super) fn remark(&self, place: &Place, text: String) {
        self.remarks.borrow_mut().push(Note::new(place, text));
    }

    /// Tells of tables of an index, or of what one follows from, that end values are held beyond.
    pub(super) fn held(&self, name: &str, source: &SpectrumSource) {
        for part in source.parts() {
            if let Some(known) = part.domain() {
                self.holds(&part.place, name, known);
            }
        }
    }

    /// Tells that a table ends where a range does, for renders that ask for more.
    fn holds(&self, place: &Place, name: &str, known: WavelengthRange) {
        let text = format!("{name}: {}", catalogue::held(known));
        self.assumptions.borrow_mut().push(Note { beyond: Some(known), ..Note::new(place, text) });
    }

    /// Tells of a table of a reflectance that a surface is black beyond, unless the table ends in black.
    fn ends(&self, title: &str, source: &SpectrumSource) {
        let ends_in_black = match &source.kind {
            SpectrumKind::Irregular { values, .. } | SpectrumKind::Regular { values, .. } => {
                [values.first(), values.last()].iter().all(|value| value.is_none_or(|&value| value == 0.0))
            }
            _ => return,
        };
        let Some(known) = source.domain().filter(|_| !ends_in_black) else { return };
        let text = format!(
            "{title}: the table covers {}–{} nm; it is 0 beyond, as in Mitsuba 3: for other values there, add its ends \
             at the ends of the range that is rendered",
            known.min, known.max
        );
        self.remarks.borrow_mut().push(Note { beyond: Some(known), ..Note::new(&source.place, text) });
    }

    /// The answer to a question that is asked again when its turn comes, and told of then.
    fn quietly<T>(&self, ask: impl FnOnce() -> T) -> T {
        let errors = self.errors.borrow().len();
        let notes = [&self.extensions, &self.assumptions, &self.remarks];
        let told = notes.map(|notes| notes.borrow().len());
        let answer = ask();
        self.errors.borrow_mut().truncate(errors);
        notes.iter().zip(told).for_each(|(notes, told)| notes.borrow_mut().truncate(told));
        answer
    }

    pub(super) fn unknown_plugin(&self, object: &Object) {
        self.error(hints::unknown_plugin(object.class, &object.plugin, &object.plugin_place));
    }

    /// `None` where something without which there is no scene is missing or wrong.
    fn scene(&self) -> Option<Description> {
        let ahead = ahead::decode(self);
        *self.ahead.borrow_mut() = ahead;
        let query = Query::new(self, Tree::ROOT);
        let integrator = integrators::of_scene(&query);
        let sensor = self.sensor(&query);
        let groups::Found { shapes, solids, instances, .. } = groups::read(self, &query);
        let lights = self.lights(&query);
        self.definitions(&query);
        query.finish();
        let groups = groups::shown(&instances);
        let grouped = groups.iter().flat_map(|group| &group.shapes);
        let grouped_solids = groups.iter().flat_map(|group| &group.solids);
        self.inside_out(&shapes);
        for group in self.groups.borrow().values() {
            self.inside_out(&group.shapes);
        }
        let parts = solids.iter().chain(grouped_solids).flat_map(Solid::leaves);
        let all: Vec<_> = shapes.iter().chain(grouped).chain(parts).collect();
        whole::check(self, &integrator, &all);
        Some(Description {
            sources: Sources::default(),
            files: BTreeSet::new(),
            integrator,
            sensor: sensor?,
            shapes,
            solids,
            instances,
            lights,
            extensions: Vec::new(),
            assumptions: Vec::new(),
            remarks: Vec::new(),
        })
    }

    /// The sensor that is asked for, by default the first, as in Mitsuba 3. The others are read for their
    /// errors.
    fn sensor(&self, query: &Query<'_>) -> Option<Sensor> {
        let mut sensors = sensors::of_scene(query);
        query.objects(Class::Sensor);
        let place = &query.object.place;
        let broken = || query.object.entries.iter().any(|entry| matches!(entry.value, tree::Value::Broken));
        if sensors.is_empty() {
            if !broken() {
                self.error(
                    SceneError::at(place, "The scene has no sensor", "expected a <sensor> in here")
                        .with_remedy("add <sensor type=\"perspective\">...</sensor>"),
                );
            }
            return None;
        }
        if self.wanted_sensor >= sensors.len() {
            let problem = format!("There is no sensor {}", self.wanted_sensor);
            let expected = match sensors.len() {
                1 => "the scene has one sensor, number 0".to_owned(),
                count => format!("the scene has {count} sensors, numbers 0 to {}", count - 1),
            };
            self.error(SceneError::at(place, problem, expected));
            return None;
        }
        let (_, wanted) = sensors.swap_remove(self.wanted_sensor);
        for (place, _) in &sensors {
            let text = format!("this sensor is not used: number {} is", self.wanted_sensor);
            self.remark(place, text);
        }
        wanted
    }

    fn lights(&self, query: &Query<'_>) -> Vec<super::description::Light> {
        let mut lights: Vec<super::description::Light> = Vec::new();
        for (entry, id) in query.objects(Class::Emitter) {
            if lights::belongs_to_shapes(self, entry, id) {
                continue;
            }
            let Some(light) = lights::of_scene(self, id) else { continue };
            let around = lights.iter().filter(|light| light.kind.is_environment()).count();
            if light.kind.is_environment() && around == 1 {
                self.error(
                    SceneError::at(
                        &entry.place,
                        "The scene has two lights from all around",
                        "expected one at most, as in Mitsuba 3",
                    )
                    .with_remedy("leave one out, or add them up in one picture"),
                );
            }
            lights.push(light);
        }
        lights
    }

    /// Objects that are defined for others to refer to, checked whether or not one does.
    fn definitions(&self, query: &Query<'_>) {
        for (_, id) in query.objects(Class::Bsdf) {
            bsdfs::read_once(self, id);
        }
        for (_, id) in query.objects(Class::Medium) {
            media::of_object(self, id);
        }
        for (_, id) in query.objects(Class::Phase) {
            phases::of_object(self, id);
        }
        for class in [Class::Film, Class::Sampler, Class::Filter] {
            query.objects(class);
        }
        for (_, id) in query.objects(Class::Volume) {
            plugins::textures::volumes::of_object(self, id);
        }
        for (entry, id) in query.objects(Class::Spectrum) {
            if entry.name.is_some() {
                self.error(
                    SceneError::at(
                        &entry.name_place,
                        "The scene has no spectra of its own",
                        "expected an id here, not a name",
                    )
                    .with_remedy("give it an id and refer to it with <ref id=\"...\" name=\"...\"/>"),
                );
            }
            if !plugins::textures::FORMULAS.contains(&self.tree.get(id).plugin.as_str()) {
                spectra::plugin(self, id);
            }
        }
    }
}
