//! The same scene as small as 10⁻⁶, as large as 10⁶ and as far away as 10⁵ times its size is the same
//! picture, and so it is with something in it that is 10⁶ units away.

use super::common::stress;
use super::renders::{compiled, description, expose, mean, radiances};
use super::table::{Table, seconds};
use abbe::stats::{Estimate, welch};
use std::time::Instant;

/// False alarms of one picture.
const LEVEL: f64 = 0.001;

/// The scene is so large that `1` means 1 of its units.
const SIZE: f64 = 6.0;

/// Where everything is put: scaled, then moved by as much along two axes.
#[derive(Clone, Copy, Debug)]
struct World {
    scale: f64,
    away: f64,
    /// Whether there is a dark ball so far away that nothing sees it.
    far_ball: bool,
}

impl World {
    /// The transform of a shape, which does `steps` in the scene's own units first.
    fn place(self, steps: &str) -> String {
        format!(r#"<transform name="to_world">{}</transform>"#, self.steps(steps))
    }

    fn steps(self, steps: &str) -> String {
        let offset = self.away * SIZE * self.scale;
        format!(
            r#"{steps}<scale value="{:e}"/><translate x="{:e}" y="{:e}" z="{:e}"/>"#,
            self.scale,
            offset,
            -0.6 * offset,
            0.3 * offset
        )
    }

    /// What changes nothing but the box around the scene.
    fn far_ball(self) -> String {
        if !self.far_ball {
            return String::new();
        }
        let place = self.place(r#"<translate x="-1e6" y="2e5" z="1e5"/>"#);
        format!(
            r#"<shape type="sphere">{place}<bsdf type="diffuse"><float name="reflectance" value="0"/></bsdf></shape>"#
        )
    }

    /// A length, or to the power of −1 an absorption, of 2 an intensity.
    fn times(self, value: f64, power: i32) -> String {
        format!("{:e}", value * self.scale.powi(power))
    }
}

fn camera(world: World, plugin: &str, more: &str) -> String {
    let offset = world.away * SIZE * world.scale;
    let [x, y, z] = [offset, -0.6 * offset, 0.3 * offset];
    let s = world.scale;
    format!(
        r#"<sensor type="{plugin}"><float name="fov" value="42"/>{more}
           <float name="near_clip" value="{:e}"/><float name="far_clip" value="{:e}"/>
           <transform name="to_world">
             <lookat origin="{:e}, {:e}, {:e}" target="0, 0, {:e}" up="0, 0, 1"/>
             <translate x="{x:e}" y="{y:e}" z="{z:e}"/></transform>
           <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="16"/><rfilter type="box"/></film>
           </sensor>"#,
        1e-2 * s,
        1e3 * s,
        4.0 * s,
        -3.0 * s,
        2.5 * s,
        0.6 * s,
    )
}

/// Solids, meshes and instances in paint and metal under lamps.
fn solids(world: World) -> String {
    let floor = world.place(r#"<scale value="3"/>"#);
    let ball = world.place(r#"<scale value="0.5"/><translate x="-0.6" y="0.8" z="0.5"/>"#);
    let cube =
        world.place(r#"<scale value="0.4"/><rotate z="1" angle="25"/><translate x="1.1" y="0.6" z="0.4"/>"#);
    let mesh = world.place(r#"<scale value="0.3"/><translate x="0.2" y="-1.1" z="0.3"/>"#);
    let cone = world.place(r#"<scale value="0.5"/><translate x="-1.3" y="-0.4"/>"#);
    let torus =
        world.place(r#"<scale value="0.4"/><rotate x="1" angle="60"/><translate x="0.3" y="0.1" z="0.45"/>"#);
    let tube = world.place(r#"<scale x="0.2" y="0.2" z="0.8"/><translate x="1.4" y="-0.7"/>"#);
    let lamp = world.place(r#"<scale value="0.25"/><translate x="0.5" y="1.5" z="2.2"/>"#);
    let panel =
        world.place(r#"<scale value="0.6"/><rotate x="1" angle="180"/><translate x="-1" y="-1" z="3"/>"#);
    let first = world.place(r#"<scale value="0.5"/><translate x="1.9" y="0.1" z="0.25"/>"#);
    let second =
        world.place(r#"<scale value="0.4"/><rotate z="1" angle="70"/><translate x="-1.6" y="1.7" z="0.2"/>"#);
    let point = format!(
        r#"<emitter type="point"><spectrum name="intensity" value="{}"/>{}</emitter>"#,
        world.times(4.0, 2),
        world.place(r#"<translate x="-2" y="-2" z="2"/>"#)
    );
    format!(
        r#"{}{point}{}
        <bsdf type="diffuse" id="grey"><spectrum name="reflectance" value="0.6"/></bsdf>
        <bsdf type="roughconductor" id="metal"><string name="material" value="Au"/><float name="alpha" value="0.2"/></bsdf>
        <bsdf type="roughplastic" id="plastic"><float name="alpha" value="0.1"/></bsdf>
        <shape type="rectangle">{floor}<ref id="grey"/></shape>
        <shape type="sphere">{ball}<ref id="metal"/></shape>
        <shape type="cube">{cube}<ref id="grey"/></shape>
        <shape type="ply"><string name="filename" value="../validation/mitsuba/scenes/meshes/pyramid.ply"/>{mesh}<ref id="plastic"/></shape>
        <shape type="cone">{cone}<ref id="plastic"/></shape>
        <shape type="torus">{torus}<ref id="metal"/></shape>
        <shape type="cylinder">{tube}<bsdf type="twosided"><ref id="grey"/></bsdf></shape>
        <shape type="shapegroup" id="group">
          <shape type="cube"><transform name="to_world"><scale value="0.5"/></transform><ref id="grey"/></shape>
          <shape type="sphere"><float name="radius" value="0.4"/><point name="center" x="0" y="0" z="0.9"/><ref id="metal"/></shape>
        </shape>
        <shape type="instance">{first}<ref id="group"/></shape>
        <shape type="instance">{second}<ref id="group"/></shape>
        <shape type="sphere">{lamp}<emitter type="area"><spectrum name="radiance" value="12"/></emitter></shape>
        <shape type="rectangle">{panel}<emitter type="area"><spectrum name="radiance" value="5"/></emitter></shape>"#,
        camera(world, "perspective", ""),
        world.far_ball()
    )
}

/// Coloured glass, clear glass and what moves, by a lens with an aperture.
fn glass(world: World) -> String {
    let lens = format!(
        r#"<float name="aperture_radius" value="{}"/><float name="focus_distance" value="{}"/>
           <float name="shutter_open" value="0"/><float name="shutter_close" value="1"/>"#,
        world.times(0.08, 1),
        world.times(5.0, 1)
    );
    let floor = world.place(r#"<scale value="3"/>"#);
    let ball = world.place(r#"<scale value="0.6"/><translate x="-0.5" y="0.6" z="0.65"/>"#);
    let block = world
        .place(r#"<scale value="0.4"/><rotate z="1" angle="40"/><translate x="0.9" y="-0.3" z="0.45"/>"#);
    let rough = world.place(r#"<scale value="0.35"/><translate x="0" y="-1.2" z="0.4"/>"#);
    let [start, end] = ["0.2", "0.9"]
        .map(|x| world.steps(&format!(r#"<scale value="0.3"/><translate x="{x}" y="1.6" z="0.3"/>"#)));
    let panel =
        world.place(r#"<scale value="1.2"/><rotate x="1" angle="180"/><translate x="0" y="0" z="3"/>"#);
    format!(
        r#"{}{}
        <bsdf type="diffuse" id="grey"><spectrum name="reflectance" value="0.6"/></bsdf>
        <bsdf type="dielectric" id="glass"/>
        <shape type="rectangle">{floor}<ref id="grey"/></shape>
        <shape type="sphere">{ball}<ref id="glass"/><medium type="homogeneous" name="interior">
          <spectrum name="sigma_t" value="400:{}, 700:{}"/><float name="albedo" value="0"/></medium></shape>
        <shape type="cube">{block}<ref id="glass"/><medium type="homogeneous" name="interior">
          <spectrum name="sigma_t" value="{}"/><float name="albedo" value="0"/></medium></shape>
        <shape type="sphere">{rough}<bsdf type="roughdielectric"><float name="alpha" value="0.15"/></bsdf></shape>
        <shape type="sphere"><animation name="to_world"><transform time="0">{start}</transform>
          <transform time="1">{end}</transform></animation><ref id="grey"/></shape>
        <shape type="rectangle">{panel}<emitter type="area"><spectrum name="radiance" value="6"/></emitter></shape>
        <emitter type="constant"><spectrum name="radiance" value="0.5"/></emitter>"#,
        camera(world, "thinlens", &lens),
        world.far_ball(),
        world.times(3.0, -1),
        world.times(0.2, -1),
        world.times(0.7, -1),
    )
}

/// The smallest p-value over pairs of pixels, corrected for their number.
fn smallest_p(a: &[Estimate], b: &[Estimate]) -> f64 {
    let varying = a.iter().zip(b).filter(|(a, b)| a.variance + b.variance > 0.0);
    let p: Vec<f64> = varying.map(|(a, b)| welch(a, b).p_value).collect();
    let smallest = p.iter().copied().fold(1.0, f64::min);
    1.0 - (1.0 - smallest).powi(p.len() as i32)
}

#[test]
fn pictures_do_not_depend_on_scale_and_place() {
    let samples = stress::count(32, 1024);
    let world = |scale, away, far_ball| World { scale, away, far_ball };
    let worlds = [
        world(1.0, 0.0, false),
        world(1e-6, 0.0, false),
        world(1e6, 0.0, false),
        world(1.0, 1e5, false),
        world(1e-6, 1e5, false),
        world(1e6, 1e5, false),
        world(1.0, 0.0, true),
        world(1e-6, 1e5, true),
    ];
    let mut table = Table::new(
        "The same scene at other scales and places",
        &[
            "scene",
            "scale",
            "away / size",
            "ball",
            "mean",
            "error",
            "p of the mean",
            "p of pixels",
            "bad",
            "s",
        ],
    );
    type Text = fn(World) -> String;
    let scenes: [(&str, Text); 2] = [("solids", solids), ("glass", glass)];
    let mut failures = Vec::new();
    for (name, scene) in scenes {
        let mut reference = None;
        for (seed, world) in (1u64..).zip(worlds) {
            let began = Instant::now();
            // All others are set against the first.
            let samples = if reference.is_none() { 4 * samples } else { samples };
            let film = expose(&compiled(&description(&scene(world))), samples, seed);
            let found = radiances(&film);
            let whole = mean(&found);
            let reference = reference.get_or_insert_with(|| found.clone());
            let p_mean = welch(&whole, &mean(reference)).p_value;
            let p_pixels = smallest_p(&found, reference);
            table.row(&[
                name.to_owned(),
                format!("{:.0e}", world.scale),
                format!("{:.0e}", world.away),
                if world.far_ball { "10⁶ away" } else { "" }.to_owned(),
                format!("{:.5}", whole.mean),
                format!("{:.5}", whole.variance.sqrt()),
                format!("{p_mean:.3}"),
                format!("{p_pixels:.3}"),
                film.bad.total().to_string(),
                seconds(began),
            ]);
            // Seen alone, each is a picture: black everywhere would be the same at all scales.
            let is_picture = whole.mean > 0.05 && whole.variance.sqrt() < 0.05 * whole.mean;
            if film.bad.total() > 0 || p_mean < LEVEL || p_pixels < LEVEL || !is_picture {
                failures.push(format!("{name}, {world:?}"));
            }
        }
    }
    table.print();
    assert!(failures.is_empty(), "{failures:?}");
}
