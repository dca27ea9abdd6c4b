//! abbe's part in a comparison. What is asked for on standard input:
//!
//! - `primary`, `bounce` or `shadow`: answers these rays; tells the CPU time of a ray in nanoseconds, and how
//!   many hit;
//! - `answers KIND FILE`: writes what each ray meets: the distance as `f32` (0 for any hit at all, infinite
//!   for none), and the triangle as `u32`.

use super::scene::{Kind, PackedRay, Scene, unpack};
use abbe::accel::Accel;
use abbe::shape::{Mesh, Shape};
use cpu_time::ThreadTime;
use std::error::Error;
use std::hint::black_box;
use std::io::{BufRead, Write};
use std::path::Path;
use std::time::Instant;

pub fn serve(file: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::read(file)?;
    let triangles = scene.mesh.indices.len();
    let shape = Shape::Mesh(Mesh::new(std::mem::take(&mut scene.mesh))?);
    let start = Instant::now();
    let accel = Accel::build(std::slice::from_ref(&shape));
    let bytes = accel.memory() as f64 / triangles as f64;
    say(&format!("built in {:.2} s, {bytes:.0} bytes a triangle", start.elapsed().as_secs_f64()))?;
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let words: Vec<_> = line.split_whitespace().collect();
        let kind = |name: &str| Kind::ALL.into_iter().find(|kind| kind.name() == name).ok_or("no such rays");
        match words[..] {
            [name] => {
                let kind = kind(name)?;
                let rays = scene.rays(kind);
                let start = ThreadTime::now();
                let hits = black_box(count_hits(&accel, kind, rays));
                let nanoseconds = start.elapsed().as_nanos() as f64 / rays.len() as f64;
                say(&format!("{nanoseconds} {hits}"))?;
            }
            ["answers", name, path] => {
                let kind = kind(name)?;
                let answers = scene.rays(kind).iter().flat_map(|ray| answer(&accel, kind, *ray));
                std::fs::write(path, answers.collect::<Vec<u8>>())?;
                say("written")?;
            }
            _ => return Err(format!("not understood: {line}").into()),
        }
    }
    Ok(())
}

fn say(line: &str) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}")?;
    out.flush()
}

fn count_hits(accel: &Accel, kind: Kind, rays: &[PackedRay]) -> usize {
    match kind {
        Kind::Primary | Kind::Bounce => {
            rays.iter().filter(|ray| accel.closest(&unpack(**ray), 0.0).is_some()).count()
        }
        Kind::Shadow => rays.iter().filter(|ray| accel.occluded(&unpack(**ray), 0.0)).count(),
    }
}

fn answer(accel: &Accel, kind: Kind, ray: PackedRay) -> [u8; 8] {
    let ray = unpack(ray);
    let (t, triangle) = match kind {
        Kind::Primary | Kind::Bounce => {
            accel.closest(&ray, 0.0).map_or((f32::INFINITY, u32::MAX), |hit| (hit.t as f32, hit.triangle))
        }
        Kind::Shadow => (if accel.occluded(&ray, 0.0) { 0.0 } else { f32::INFINITY }, u32::MAX),
    };
    let (t, triangle) = (t.to_le_bytes(), triangle.to_le_bytes());
    std::array::from_fn(|i| if i < 4 { t[i] } else { triangle[i - 4] })
}
