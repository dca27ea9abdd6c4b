//! From what a file says to what can be traced. Whatever can be wrong with a scene that reading it did not show is
//! found here, before the first ray.
//!
//! The whole scene is moved so that its centre lies at the origin before meshes are rounded to single precision: how
//! far a scene lies from the origin of its file makes no difference.

mod contact;
mod groups;
mod layered;
mod lights;
mod materials;
mod sensors;
mod spectra;

use super::description::{self, Description, IntegratorKind, ShapeKind};
use super::source::{Place, SceneError, SceneErrors};
use super::traceable::{Needs, Scene, Surface};
use crate::geometry::{Bounds, Transform};
use crate::integrator::{Coverage, Integrator, Limits};
use crate::light::Light;
use crate::material::Material;
use crate::shape::{
    Cylinder, Disk, Figure, Mesh, Quadric, Shape, ShapeError, Sphere, Torus, compute_vertex_normals,
};
use crate::spectrum::Spectrum;
use crate::spectrum::colour::Observer;
use crate::units::WavelengthRange;
use groups::Groups;
use materials::MaterialCompiler;

/// What a scene is compiled for.
#[derive(Clone, Copy, Debug)]
pub struct CompileOptions {
    pub range: WavelengthRange,
    pub observer: &'static Observer,
    /// Whether spectral bins are measured too: then wavelengths that the observer hardly sees count as well.
    pub spectral: bool,
}

impl Default for CompileOptions {
    fn default() -> Self {
        Self { range: WavelengthRange::VISIBLE, observer: Observer::cie1931(), spectral: false }
    }
}

/// Makes a description traceable.
///
/// # Errors
/// All that is wrong and independent of one another: shapes that cannot be placed, spectra that are no physics over
/// the range of wavelengths, a walk in a scene whose lights it can't find.
pub fn compile(description: &Description, options: &CompileOptions) -> Result<Scene, SceneErrors> {
    Compiler { description, options, shift: Transform::IDENTITY, errors: Vec::new() }.run()
}

struct Compiler<'a> {
    description: &'a Description,
    options: &'a CompileOptions,
    /// From the coordinates of the file to those of the scene.
    shift: Transform,
    errors: Vec<SceneError>,
}

impl Compiler<'_> {
    fn run(mut self) -> Result<Scene, SceneErrors> {
        let description = self.description;
        let groups = Groups::new(description);
        let shift = Transform::translation(-groups::centre(groups.scene_bounds()));
        self.shift = shift;
        let mut materials = MaterialCompiler::new(self.options.range, shift);
        let (mut shapes, mut surfaces, mut lights) = (Vec::new(), Vec::new(), Vec::new());
        let mut precedence = false;
        for (shape, to_world, carried) in groups.shapes(&shift) {
            precedence |= shape.priority.is_some();
            let Some(geometry) = self.keep(&shape.place, place(shape, &to_world)) else {
                continue;
            };
            let surface = match materials.surface(shape, &geometry) {
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
            surfaces.push(Surface { light, parametrised: surface.parametrised || textured, ..surface });
        }
        let (environment, moving_lights) = self.other_lights(&mut lights, &shift);
        let camera_medium = description
            .sensor
            .medium
            .as_ref()
            .and_then(|medium| materials.medium(medium).map_err(|error| self.errors.push(error)).ok());
        if description.integrator.kind == IntegratorKind::Walk {
            self.refuse_lights_that_a_walk_misses();
        }
        let film = self.film();
        if !self.errors.is_empty() {
            return Err(SceneErrors { sources: description.sources.clone(), errors: self.errors });
        }
        let MaterialCompiler { materials, bodies, media, .. } = materials;
        let accel = groups.accel(&shapes, &shift).map_err(|places| {
            for place in places {
                self.cannot_be_made(place, &ShapeError::Placement);
            }
            SceneErrors { sources: description.sources.clone(), errors: std::mem::take(&mut self.errors) }
        })?;
        let Some(camera) = self.camera(&shift, accel.bounds()).filter(|_| self.errors.is_empty()) else {
            return Err(SceneErrors { sources: description.sources.clone(), errors: self.errors });
        };
        let contacts = contact::contacts(&groups, &shift, &shapes, &surfaces, &bodies);
        let contact = !contacts.of.is_empty();
        let during = description.sensor.shutter.during();
        let sensor_within = contact::body_boxes(&groups, &shift, &shapes, &surfaces, &bodies)
            .any(|around| around.overlaps(camera.origins(during)));
        let scene_radius = 0.5 * accel.bounds().diameter();
        let own = groups.own();
        let bodies_may_nest = may_nest(&shapes[..own], &surfaces[..own]) || groups.hold_bodies(&surfaces);
        let absorption = media.iter().any(Option::is_some);
        let volumetric = description.integrator.kind == IntegratorKind::VolPath;
        let shutter = description.sensor.shutter;
        let lights_move = !moving_lights.is_empty() || camera.is_moving();
        let lights = self.weighed(lights, environment, scene_radius).with_motion(moving_lights);
        let needs = Needs {
            dispersion: materials.iter().any(Material::disperses),
            absorption,
            medium_stack: absorption || bodies_may_nest || contact || precedence || sensor_within,
            precedence,
            contact,
            sensor_within,
            lens: camera.uses_lens(),
            motion: groups.move_while_open() || lights_move && shutter.open < shutter.close,
            light_samples: !lights.is_empty(),
            rough_surfaces: materials.iter().any(Material::is_rough),
            choices: materials.iter().any(Material::chooses),
            clear_shadows: volumetric && surfaces.iter().any(|surface| surface.may_pass),
            textures: surfaces.iter().any(|surface| surface.parametrised),
        };
        Ok(Scene {
            observer: self.options.observer,
            integrator: match description.integrator.kind {
                IntegratorKind::Path | IntegratorKind::Direct | IntegratorKind::VolPath => Integrator::Path,
                IntegratorKind::Walk => Integrator::Walk,
            },
            limits: Limits {
                max_depth: description.integrator.max_depth.unwrap_or(u32::MAX),
                rr_depth: description.integrator.rr_depth,
                hide_emitters: description.integrator.hide_emitters,
                passing_counts: !volumetric,
                techniques: description.integrator.techniques,
                coverage: match description.integrator.kind {
                    IntegratorKind::Direct => Coverage::Surface,
                    _ => Coverage::Obstacle,
                },
            },
            wavelengths: self.wavelengths(&self.responses(&camera, &film), &lights, scene_radius),
            reference_radiance: self.reference(&film, &lights, scene_radius),
            camera,
            shutter,
            film,
            lights,
            needs,
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
    fn check_attributes(&mut self, shape: &description::Shape, geometry: &Shape, wanted: &[&str]) {
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

    fn cannot_be_made(&mut self, place: &Place, error: &ShapeError) {
        self.errors.push(SceneError::at(
            place,
            format!("this shape cannot be made: {error}"),
            "a shape of finite size that is not flattened by its transform",
        ));
    }
}

/// A shape where its transform puts it.
fn place(shape: &description::Shape, to_world: &Transform) -> Result<Shape, ShapeError> {
    let flip = shape.flip_normals;
    Ok(match &shape.kind {
        ShapeKind::Sphere { centre, radius } => Shape::Sphere(Sphere::new(to_world, *centre, *radius, flip)?),
        ShapeKind::Disk => Shape::Disk(Disk::new(to_world, flip)?),
        ShapeKind::Cylinder { from, to, radius } => {
            Shape::Cylinder(Cylinder::new(to_world, *from, *to, *radius, flip)?)
        }
        ShapeKind::Quadric { kind, capped } => {
            Shape::Quadric(Box::new(Quadric::of_kind(to_world, kind, *capped, flip)?))
        }
        ShapeKind::Torus { major_radius, minor_radius } => {
            Shape::Torus(Box::new(Torus::new(to_world, *major_radius, *minor_radius, flip)?))
        }
        ShapeKind::Figure(kind) => Shape::Figure(Box::new(Figure::new(to_world, kind, flip)?)),
        ShapeKind::Rectangle => Shape::Mesh(Mesh::rectangle(to_world, flip)?),
        ShapeKind::Cube => Shape::Mesh(Mesh::cube(to_world, flip)?),
        ShapeKind::Mesh { mesh, compute_normals, .. } => {
            let mut placed = mesh.transformed(to_world);
            if *compute_normals {
                placed.normals = Some(compute_vertex_normals(&placed.positions, &placed.indices));
            }
            placed.flip_normals ^= flip;
            Shape::Mesh(Mesh::new(placed)?)
        }
    })
}

/// Whether a ray may be within two bodies at once, going by their boxes.
fn may_nest(shapes: &[Shape], surfaces: &[Surface]) -> bool {
    let boxes: Vec<Bounds> = shapes
        .iter()
        .zip(surfaces)
        .filter(|(_, surface)| surface.body.is_some())
        .map(|(shape, _)| shape.bounds())
        .collect();
    boxes.iter().enumerate().any(|(i, a)| boxes[..i].iter().any(|b| a.overlaps(*b)))
}
