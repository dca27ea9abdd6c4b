//! From what a file says to what can be traced. Whatever can be wrong with a scene that reading it did not
//! show is found here, before the first ray.
//!
//! The whole scene is moved so that its centre lies at the origin before meshes are rounded to single
//! precision: how far a scene lies from the origin of its file makes no difference.

mod contact;
mod groups;
mod hair;
mod light_tracing;
mod lights;
mod materials;
mod media;
mod numbers;
mod plastic;
mod principled;
mod seclusion;
mod sensors;
mod shapes;
mod solids;
mod spectra;

pub(super) use shapes::{bounds as bounds_of_shape, place as place_shape};
pub(super) use spectra::index as index_of_source;

use super::description::{self, Description, IntegratorKind, Note, ShapeKind};
use super::features::Features;
use super::lanes::{EvenSurfaces, KnownSurface};
use super::scene::{Scene, Surface};
use super::source::{Place, SceneError, SceneErrors};
use crate::accel::{Accel, NO_FACET};
use crate::bsdf::Specular;
use crate::film::Region;
use crate::geometry::{Bounds, Placed, Transform, Vec3};
use crate::light::{self, Environment, Light, Lights};
use crate::material::Material;
use crate::medium::Emission;
use crate::scene::{Coverage, FilmPlan, Integrator, Limits, Techniques};
use crate::shape::{Opening, Shape, ShapeError};
use crate::spectrum::Spectrum;
use crate::spectrum::colour::Observer;
use crate::texture::Texture;
use crate::units::WavelengthRange;
use contact::Nearness;
use groups::{Assembled, Groups, MOST_INSTANCES, Traced};
use materials::MaterialCompiler;
use seclusion::Seclusion;
use std::cell::LazyCell;
use std::collections::HashMap;

/// What a scene is compiled for.
#[derive(Clone, Copy, Debug)]
pub struct CompileOptions {
    /// Wavelengths that are simulated, nm.
    pub range: WavelengthRange,
    /// The colour matching functions.
    pub observer: &'static Observer,
    /// Whether spectral bins are measured too: then wavelengths that the observer hardly sees count as well.
    pub spectral: bool,
    /// The crop that is rendered. `None` is all that the film exposes.
    pub part: Option<Crop>,
}

/// A crop of the picture. Its bits are those of the whole picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Within the window that the film exposes.
    pub shown: Region,
    /// Pixels around it, as far as the window goes, that are measured too. What is measured holds whole
    /// squares of pixels of an edge of `square`, each with that margin.
    pub margin: u32,
    /// Columns, and rows, of such a square, at least 1.
    pub square: u32,
}

impl Default for CompileOptions {
    fn default() -> Self {
        Self { range: WavelengthRange::VISIBLE, observer: Observer::cie1931(), spectral: false, part: None }
    }
}

/// Makes a description traceable.
///
/// # Errors
/// All that is wrong and independent of one another: shapes that cannot be placed, spectra that are no
/// physics over the range of wavelengths, a walk in a scene whose lights it can't find.
pub fn compile(description: &Description, options: &CompileOptions) -> Result<Scene, SceneErrors> {
    let colours = HashMap::new();
    let (warnings, errors) = (Vec::new(), Vec::new());
    Compiler { description, options, shift: Transform::IDENTITY, colours, warnings, errors }.run()
}

struct Compiler<'a> {
    description: &'a Description,
    options: &'a CompileOptions,
    /// From the coordinates of the file to those of the scene.
    shift: Transform,
    /// What has been made of colours, by their numbers, scale and role: many lights may have the same.
    colours: HashMap<([u64; 4], u8), Texture>,
    warnings: Vec<Note>,
    errors: Vec<SceneError>,
}

/// What a file states, made part by part, and checked.
struct Stated<'a> {
    groups: Groups<'a>,
    materials: MaterialCompiler,
    shapes: Vec<Shape>,
    /// Those of the shapes, by their numbers.
    surfaces: Vec<Surface>,
    lights: Vec<Light>,
    environment: Option<Environment>,
    /// By the numbers of those among the lights that move.
    moving_lights: Vec<(usize, Placed)>,
    camera_medium: Option<u32>,
    film: FilmPlan,
}

impl<'a> Compiler<'a> {
    fn run(mut self) -> Result<Scene, SceneErrors> {
        let stated = self.stated()?;
        let Stated { groups, materials, shapes, mut surfaces, mut lights, .. } = stated;
        let Stated { environment, moving_lights, camera_medium, film, .. } = stated;
        let MaterialCompiler { materials, bodies, mut media, .. } = materials;
        let (description, shift) = (self.description, self.shift);

        // Where everything is, and what is next to what.
        let (accel, solids) = self.accel(&groups, &shapes)?;
        make_parts(&groups, &solids, &surfaces, &mut lights);
        let camera = self.camera(&shift, accel.bounds());
        self.check()?;
        let Some(camera) = camera else { return Err(self.failure()) };
        let solids_of = contact::solids_of(&groups, &shapes, &solids);
        let boxes = contact::boxes(&shapes, &solids_of);
        let Nearness { contacts, adjoin, overlap, one_way } =
            contact::nearness(&groups, &shift, &shapes, &boxes, &solids_of, &surfaces, &bodies, &accel);
        let contact = !contacts.of.is_empty();
        let shutter = description.sensor.shutter;
        let during = shutter.during();
        let sensor_within = contact::body_boxes(&groups, &shift, &shapes, &boxes, &surfaces, &bodies)
            .any(|around| around.overlaps(camera.origins(during)));

        // What is between surfaces.
        let boxes_of = |is_meant: &dyn Fn(usize) -> bool| -> Vec<Bounds> {
            contact::boxes_of(&groups, &shift, &shapes, &boxes, is_meant).collect()
        };
        let seclusion = Seclusion {
            bodies: &bodies,
            surfaces: &surfaces,
            camera_medium,
            boxes_of,
            lamps: LazyCell::new(|| {
                let mut lamps = boxes_of(&|shape| surfaces[shape].light.is_some());
                lamps.extend(lights.iter().filter_map(Light::place).map(|place| Bounds::of([place])));
                lamps.retain(|lamp| !lamp.is_empty());
                lamps.extend((!moving_lights.is_empty()).then_some(contact::EVERYWHERE));
                lamps
            }),
        };
        seclusion.apply(&mut media);
        let absorption = media.iter().any(Option::is_some);
        let emitting: Vec<&Emission> =
            media.iter().flatten().filter_map(|medium| medium.emission.as_ref()).collect();
        let scattering =
            !emitting.is_empty() || media.iter().flatten().any(|medium| medium.scattering.is_some());

        // Wavelengths, and the choice among lights by them.
        let lit_bounds = match scattering {
            false => accel.bounds(),
            // Fog is seen where there is no surface, too.
            true => {
                let lamps = lights::places(&lights, &moving_lights, during);
                accel.bounds().union(camera.origins(during)).union(lamps)
            }
        };
        let scene_radius = lights::radius(lit_bounds);
        let integrator = self.integrator();
        let responses = self.responses(&camera, &film);
        let wavelengths = match integrator {
            // A distance is the same at all wavelengths, whatever shines on what is there.
            Integrator::Depth => self.wavelengths(&responses, &[], None, &[], scene_radius),
            Integrator::Path | Integrator::Walk => {
                self.wavelengths(&responses, &lights, environment.as_ref(), &emitting, scene_radius)
            }
        };
        let lights_move = !moving_lights.is_empty() || camera.is_moving();
        let choice = light::Setting { during, density: &wavelengths };
        let mut lights = Lights::new(lights, environment, moving_lights, &choice);
        let lit = lights::Lit {
            accel: &accel,
            shapes: &shapes,
            bounds: lit_bounds,
            eyes: camera.origins(during),
            time: shutter.time(0.5),
        };
        lights.set_flush(|place| lit.surfaces_through(place));
        lights.set_facets(|light| {
            let shape = surfaces.iter().position(|surface| surface.light == Some(light as u32));
            shape.map_or(NO_FACET, |shape| accel.facet_of(shape as u32, 0))
        });

        // The parts of the renderer that the scene needs.
        let limits = self.limits(&lights, scattering);
        let has_nulls = surfaces.iter().any(|surface| surface.null_transmission);
        // Light samples then compete with paths that pass the same surfaces.
        let passes_nulls = !scattering && limits.techniques == Techniques::Both && limits.max_depth > 2;
        let mut features = Features {
            dispersion: materials.iter().any(Material::disperses),
            absorption,
            scattering,
            medium_stack: absorption || contact || adjoin || sensor_within,
            precedence: overlap,
            contact,
            sensor_within,
            lens: camera.uses_lens(),
            motion: groups.move_while_open() || lights_move && shutter.open < shutter.close,
            light_samples: !lights.is_empty(),
            rough_surfaces: materials.iter().any(Material::is_rough),
            choices: materials.iter().any(Material::chooses),
            transparent_shadows: has_nulls && (!limits.null_is_a_segment || passes_nulls),
            textures: surfaces.iter().any(|surface| surface.parametrised),
            caustics: false,
            visible_lamps: false,
        };
        for shape in one_way {
            surfaces[shape].specular = Specular::Nothing;
        }
        let setting = light_tracing::Setting {
            groups: &groups,
            shift: &shift,
            shapes: &shapes,
            boxes: &boxes,
            bodies: &bodies,
            lights: &lights,
            bounds: accel.bounds(),
            camera: &camera,
            camera_medium,
            during,
            time: shutter.time(0.5),
            limits,
            features,
            range: self.options.range,
            film: film.extent,
        };
        let light_tracing = match integrator {
            // A pixel has no samples of its own of the light that subpaths bring.
            // Nor do they know of what scatters them between surfaces.
            Integrator::Path if !film.moments && !scattering => setting.light_tracing(&mut surfaces),
            Integrator::Path | Integrator::Walk | Integrator::Depth => None,
        };
        features.caustics = light_tracing.as_ref().is_some_and(|tracing| tracing.caustics.is_some());
        features.visible_lamps =
            light_tracing.as_ref().is_some_and(|tracing| tracing.visible_lamps.is_some());

        let reference_radiance = match integrator {
            Integrator::Depth => accel.bounds().union(lit.eyes).diameter(),
            Integrator::Path | Integrator::Walk => {
                let reference = self.reference(&film, &lights, &emitting, &lit);
                self.warnings.extend(self.dark(reference, &lights));
                reference
            }
        };
        Ok(Scene {
            counters: None,
            known: KnownSurface::all(&accel, &shapes, &surfaces),
            even: EvenSurfaces::new(&materials, &surfaces),
            observer: self.options.observer,
            integrator,
            limits,
            wavelengths,
            warnings: self.warnings,
            reference_radiance,
            numbers: numbers::of(description, &groups),
            shift: shift.point(Vec3::ZERO),
            camera,
            shutter,
            film,
            lights,
            light_tracing,
            features,
            accel,
            shapes,
            surfaces,
            materials,
            bodies,
            contacts,
            media,
            camera_medium,
        })
    }

    /// What the file states, once all of it can be made.
    fn stated(&mut self) -> Result<Stated<'a>, SceneErrors> {
        let groups = self.groups();
        let shift = Transform::translation(-groups::centre(groups.scene_bounds()));
        self.shift = shift;
        let mut materials = MaterialCompiler::new(self.options.range, shift);
        let (shapes, mut surfaces, mut lights) = self.surfaces(&groups, &mut materials);
        let (environment, moving_lights) = self.other_lights(&mut lights, &shift);
        let medium = self.description.sensor.medium.as_ref();
        let camera_medium =
            medium.and_then(|medium| materials.medium(medium).map_err(|error| self.errors.push(error)).ok());
        self.errors.extend(materials.unreachable_media());
        if self.description.integrator.kind == IntegratorKind::Walk {
            self.refuse_lights_that_a_walk_misses();
        }
        if self.errors.is_empty() {
            self.join_bodies(&groups, &materials, &mut surfaces);
        }
        let film = self.film();
        self.check()?;
        Ok(Stated {
            groups,
            materials,
            shapes,
            surfaces,
            lights,
            environment,
            moving_lights,
            camera_medium,
            film,
        })
    }

    /// The groups of shapes. Those that cannot be shown are reported.
    fn groups(&mut self) -> Groups<'a> {
        let mut groups = Groups::new(self.description);
        self.errors = groups.errors();
        if let Some(place) = groups.beyond_numbers() {
            let problem = "the scene shows more instances than hits can tell apart";
            let expected =
                format!("fewer than {MOST_INSTANCES}, those within groups counted as often as shown");
            let error = SceneError::at(place, problem, expected);
            self.errors
                .push(error.with_remedy("put more shapes into the innermost group, and show it less often"));
        }
        groups
    }

    /// The shapes, their surfaces, and the lights that some of these are. What cannot be made is left out.
    fn surfaces(
        &mut self,
        groups: &Groups<'_>,
        materials: &mut MaterialCompiler,
    ) -> (Vec<Shape>, Vec<Surface>, Vec<Light>) {
        let (mut shapes, mut surfaces, mut lights) = (Vec::new(), Vec::new(), Vec::new());
        for Traced { shape, to_traced, part, facing, carried } in groups.shapes(&self.shift) {
            let geometry =
                shapes::place_facing(shape, &to_traced, facing, part).and_then(shapes::within_reach);
            let Some(geometry) = self.keep(&shape.place, geometry) else { continue };
            if part {
                self.refuse_open(shape, &geometry);
            }
            let surface = match materials.surface(shape, &geometry, part) {
                Ok(surface) => surface,
                Err(error) => {
                    self.errors.push(error);
                    continue;
                }
            };
            self.check_attributes(shape, &geometry, &materials.materials.attributes(surface.material));
            let light = match &shape.emission {
                None => None,
                Some(source) => {
                    if geometry.area() == 0.0 {
                        let text = "the lamp has no area, so it gives no light".to_owned();
                        self.warnings.push(Note::new(&shape.place, text));
                    }
                    let light = self.area_light(&geometry, carried, source);
                    if let Light::Area { radiance, .. } = &light {
                        self.check_attributes(shape, &geometry, &radiance.attributes());
                    }
                    lights.push(light);
                    Some(lights.len() as u32 - 1)
                }
            };
            shapes.push(geometry);
            let textured = light.is_some_and(|light| lights[light as usize].is_textured());
            let part = part && surfaces.len() < groups.own();
            let parametrised = surface.parametrised || textured;
            surfaces.push(Surface { light, part, parametrised, ..surface });
        }
        (shapes, surfaces, lights)
    }

    /// What rays are traced through, and the solids in it.
    fn accel(
        &mut self,
        groups: &Groups<'_>,
        shapes: &[Shape],
    ) -> Result<(Accel, Vec<Assembled>), SceneErrors> {
        groups.accel(shapes, &self.shift).map_err(|places| {
            for place in places {
                self.cannot_be_made(place, &ShapeError::Placement);
            }
            self.failure()
        })
    }

    fn integrator(&self) -> Integrator {
        match self.description.integrator.kind {
            IntegratorKind::Path | IntegratorKind::Direct | IntegratorKind::VolPath => Integrator::Path,
            IntegratorKind::Walk => Integrator::Walk,
            IntegratorKind::Depth => Integrator::Depth,
        }
    }

    fn limits(&self, lights: &Lights, scattering: bool) -> Limits {
        let stated = &self.description.integrator;
        Limits {
            max_depth: stated.max_depth.unwrap_or(u32::MAX),
            rr_depth: stated.rr_depth,
            hide_emitters: stated.hide_emitters,
            null_is_a_segment: stated.kind != IntegratorKind::VolPath,
            techniques: stated.techniques,
            aims_at_lamps: lights.can_aim(),
            // A path through media that scatter is so long that a second one costs more than it brings.
            splits_at_glass: !scattering,
            coverage: match stated.kind {
                IntegratorKind::Direct => Coverage::Surface,
                _ => Coverage::Obstacle,
            },
        }
    }

    /// Whether nothing has been found wrong so far.
    fn check(&mut self) -> Result<(), SceneErrors> {
        if self.errors.is_empty() { Ok(()) } else { Err(self.failure()) }
    }

    fn failure(&mut self) -> SceneErrors {
        SceneErrors { sources: self.description.sources.clone(), errors: std::mem::take(&mut self.errors) }
    }

    /// Where no light has a wavelength that the sensor responds to.
    fn dark(&self, reference_radiance: f64, lights: &Lights) -> Option<Note> {
        if reference_radiance > 0.0 {
            return None;
        }
        let text = match lights.iter().next().is_some() || lights.environment().is_some() {
            true => "no light shines at a wavelength that the sensor responds to: the picture is black",
            false => "the scene has no light: the picture is black",
        };
        Some(Note { place: self.description.sensor.place.clone(), text: text.to_owned(), beyond: None })
    }

    fn spectrum(&mut self, source: &description::SpectrumSource) -> Spectrum {
        match spectra::spectrum(source) {
            Ok(spectrum) => spectrum,
            Err(error) => {
                self.errors.push(error);
                Spectrum::ZERO
            }
        }
    }

    /// Textures can only show what a mesh carries.
    fn check_attributes(&mut self, shape: &description::ShapeDescription, geometry: &Shape, wanted: &[&str]) {
        let known: Vec<&str> = match geometry {
            Shape::Mesh(mesh) => {
                mesh.data().attributes.iter().map(|attribute| attribute.name.as_str()).collect()
            }
            _ => Vec::new(),
        };
        for name in wanted.iter().filter(|name| !known.contains(name)) {
            let error = SceneError::at(
                &shape.place,
                format!("A texture asks this shape for \"{name}\", which it does not have"),
                "expected a mesh with this attribute",
            );
            self.errors.push(match known.is_empty() {
                true => error,
                false => error.with_remedy(format!("it has {}", known.join(", "))),
            });
        }
    }

    fn keep(&mut self, place: &Place, shape: Result<Shape, ShapeError>) -> Option<Shape> {
        shape.map_err(|error| self.cannot_be_made(place, &error)).ok()
    }

    /// Solids are made of what has an inside.
    fn refuse_open(&mut self, shape: &description::ShapeDescription, geometry: &Shape) {
        let Err(opening) = geometry.is_closed() else { return };
        let kind = &shape.kind;
        let (problem, remedy) = match (opening, kind) {
            (Opening::Edge(edge), ShapeKind::Mesh { mesh, .. }) => {
                let [a, b] = edge.map(|vertex| {
                    let [x, y, z] = mesh.positions[vertex as usize];
                    format!("({x}, {y}, {z})")
                });
                let problem = format!("this mesh is open at its edge from {a} to {b}");
                (problem, "close it: at each edge as many triangles must lie on one side as on the other")
            }
            (Opening::Caps, _) => {
                ("this surface is open where it is cut off".to_owned(), "give it capped=\"true\"")
            }
            (_, ShapeKind::Cylinder { .. }) => {
                let remedy = "use a `cone` with radius1 equal to radius, which is a cylinder with caps";
                ("this surface is open: Mitsuba's cylinder has no caps".to_owned(), remedy)
            }
            _ => ("this surface encloses nothing".to_owned(), "use a `cube`, or a closed mesh"),
        };
        let error = SceneError::at(&shape.place, problem, "a closed shape as a part of a solid");
        self.errors.push(error.with_remedy(remedy));
    }

    /// All of a solid that lets light through is one body.
    fn join_bodies(&mut self, groups: &Groups<'_>, materials: &MaterialCompiler, surfaces: &mut [Surface]) {
        let places: Vec<&Place> =
            groups.shapes(&Transform::IDENTITY).iter().map(|traced| &traced.shape.place).collect();
        for parts in groups.solids() {
            let of_body = |&part: &usize| Some((part, surfaces[part].body?));
            let clear: Vec<(usize, u32)> = parts.iter().filter_map(of_body).collect();
            let Some(&(_, first)) = clear.first() else { continue };
            for (part, body) in clear {
                if !materials.same_inside(body, first) {
                    let problem = "this part encloses something else than the first that light gets into";
                    let error = SceneError::at(
                        places[part],
                        problem,
                        "the same index, interior and exterior in all parts of a solid",
                    );
                    self.errors.push(error.with_remedy(
                        "bodies of several materials are several shapes: cut one out of the other by a `difference`",
                    ));
                }
                surfaces[part].body = Some(first);
            }
        }
    }

    fn cannot_be_made(&mut self, place: &Place, error: &ShapeError) {
        self.errors.push(SceneError::at(
            place,
            format!("this shape cannot be made: {error}"),
            "a shape of finite size that is not flattened by its transform, and not too far from the others",
        ));
    }
}

/// Tells lights that are parts of solids of these.
fn make_parts(groups: &Groups<'_>, solids: &[Assembled], surfaces: &[Surface], lights: &mut [Light]) {
    for (Assembled { solid, moves }, parts) in solids.iter().zip(groups.solids()) {
        for part in parts {
            let light = surfaces[part].light.map(|light| &mut lights[light as usize]);
            if let Some(Light::Area { geometry, .. }) = light {
                geometry.is_part(solid.clone(), part as u32, *moves);
            }
        }
    }
}
