//! The scene and the rays, the same to the bit for all that are to answer them, and the file that carries
//! them.
//!
//! A closed room with a sphere in its middle that bears bumps of all sizes and 500 small spheres around it.
//! How finely the spheres are cut into triangles is all that the number of triangles changes.

use abbe::accel::Accel;
use abbe::geometry::{Frame, Ray, Transform, Vec3};
use abbe::shape::{Mesh, MeshData, Shape, ShapeError};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

/// Half an edge of the room.
const ROOM: f64 = 5.0;
const SMALL_SPHERES: usize = 500;
/// The share of the triangles that the sphere in the middle gets.
const MIDDLE: f64 = 0.64;
/// How far origins are moved off the surfaces that they are on: far more than single precision rounds in this
/// room.
const OFFSET: f64 = 1e-4;
const MAGIC: &[u8; 8] = b"abberays";

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The nearest hit of rays from a pinhole, row after row.
    Primary,
    /// The nearest hit of diffuse bounces off places all over the room, in random order.
    Bounce,
    /// Whether there is any hit between such places and a patch of the ceiling.
    Shadow,
}

impl Kind {
    pub const ALL: [Self; 3] = [Self::Primary, Self::Bounce, Self::Shadow];

    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Bounce => "bounce",
            Self::Shadow => "shadow",
        }
    }
}

/// In single precision, as Embree takes it: origin, direction and length.
pub type PackedRay = [f32; 7];

pub struct Scene {
    pub mesh: MeshData,
    /// In the order of [`Kind::ALL`], as many of each.
    pub rays: [Vec<PackedRay>; 3],
}

impl Scene {
    /// A scene of about that many triangles, and that many rays of each kind.
    pub fn new(triangles: usize, rays: usize) -> Result<Self, ShapeError> {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut mesh = Mesh::cube(&Transform::scale(ROOM), true)?.data().clone();
        mesh = MeshData { positions: mesh.positions, indices: mesh.indices, ..MeshData::default() };
        let cuts = |triangles: f64| ((triangles / 8.0).sqrt().round() as u32).max(1);
        add_sphere(&mut mesh, cuts(MIDDLE * triangles as f64), |n| n * (3.0 + bumps(n)));
        let small = cuts((1.0 - MIDDLE) * triangles as f64 / SMALL_SPHERES as f64);
        for _ in 0..SMALL_SPHERES {
            let radius = random.random_range(0.03..0.2);
            let centre = in_room(&mut random) * (1.0 - radius / ROOM);
            add_sphere(&mut mesh, small, |n| centre + n * radius);
        }
        let shape = Shape::Mesh(Mesh::new(mesh.clone())?);
        let accel = Accel::build(std::slice::from_ref(&shape));
        let [bounces, shadows] = incoherent_rays(&accel, &shape, rays, &mut random);
        Ok(Self { mesh, rays: [primary_rays(rays), bounces, shadows] })
    }

    pub fn rays(&self, kind: Kind) -> &[PackedRay] {
        &self.rays[kind as usize]
    }

    /// Little-endian: the magic, the numbers of vertices, triangles and rays of each kind as `u64`, then all
    /// of them.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        file.write_all(MAGIC)?;
        for count in [self.mesh.positions.len(), self.mesh.indices.len(), self.rays[0].len()] {
            file.write_all(&(count as u64).to_le_bytes())?;
        }
        let floats = self.mesh.positions.iter().flatten();
        for bytes in floats.map(|x| x.to_le_bytes()) {
            file.write_all(&bytes)?;
        }
        for bytes in self.mesh.indices.iter().flatten().map(|i| i.to_le_bytes()) {
            file.write_all(&bytes)?;
        }
        for bytes in self.rays.iter().flatten().flatten().map(|x| x.to_le_bytes()) {
            file.write_all(&bytes)?;
        }
        file.flush()
    }

    pub fn read(path: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        let mut magic = [0; 8];
        file.read_exact(&mut magic)?;
        if &magic != MAGIC {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "not a file of rays"));
        }
        let mut counts = [0; 3];
        for count in &mut counts {
            let mut bytes = [0; 8];
            file.read_exact(&mut bytes)?;
            *count = u64::from_le_bytes(bytes) as usize;
        }
        let positions = read(&mut file, counts[0], f32::from_le_bytes)?;
        let indices = read(&mut file, counts[1], u32::from_le_bytes)?;
        let mut rays = || read(&mut file, counts[2], f32::from_le_bytes);
        let rays = [rays()?, rays()?, rays()?];
        Ok(Self { mesh: MeshData { positions, indices, ..MeshData::default() }, rays })
    }
}

fn read<T, const N: usize>(
    file: &mut impl Read,
    count: usize,
    of_bytes: impl Fn([u8; 4]) -> T,
) -> io::Result<Vec<[T; N]>> {
    let mut bytes = vec![0; 4 * N * count];
    file.read_exact(&mut bytes)?;
    let number = |words: &[u8], i: usize| of_bytes(std::array::from_fn(|byte| words[4 * i + byte]));
    Ok(bytes.chunks_exact(4 * N).map(|words| std::array::from_fn(|i| number(words, i))).collect())
}

fn in_room(random: &mut impl Rng) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.random_range(-ROOM..ROOM)))
}

/// The faces of an octahedron, each cut into `cuts`² triangles, moved to where `place` takes unit vectors.
fn add_sphere(mesh: &mut MeshData, cuts: u32, place: impl Fn(Vec3) -> Vec3) {
    for octant in 0..8 {
        let side = |axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let corners = [Vec3::X * side(0), Vec3::Y * side(1), Vec3::Z * side(2)];
        let first = mesh.positions.len() as u32;
        for row in 0..=cuts {
            for column in 0..=cuts - row {
                let weights = Vec3::new(f64::from(row), f64::from(column), f64::from(cuts - row - column));
                let point = corners[0] * weights.x + corners[1] * weights.y + corners[2] * weights.z;
                mesh.positions.push(place(point.normalize()).as_vec3().to_array());
            }
        }
        // Rows have one vertex less each.
        let at = |row: u32, column: u32| first + row * (cuts + 1) - row * row.saturating_sub(1) / 2 + column;
        for row in 0..cuts {
            for column in 0..cuts - row {
                mesh.indices.push([at(row, column), at(row + 1, column), at(row, column + 1)]);
                if column + 1 < cuts - row {
                    mesh.indices.push([at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)]);
                }
            }
        }
    }
}

/// From waves as wide as the sphere down to those of a hundredth.
fn bumps(n: Vec3) -> f64 {
    let wave = |f: f64| ((f * n.x).sin() * (f * n.y + 1.0).sin() * (f * n.z + 2.0).sin()) / f;
    2.0 * (wave(5.0) + wave(17.0) + wave(61.0) + wave(203.0))
}

fn primary_rays(count: usize) -> Vec<PackedRay> {
    let side = (count as f64).sqrt();
    let columns = side as usize;
    let frame = Frame::around(Vec3::new(-1.0, -0.8, -0.4).normalize());
    let eye = Vec3::new(4.5, 4.0, 1.5);
    let film = |pixel: usize| (pixel as f64 + 0.5) / side * 2.0 - 1.0;
    let ray = |i: usize| {
        let direction = frame.to_world(Vec3::new(film(i % columns), film(i / columns), 1.0).normalize());
        pack(&Ray::new(eye, direction))
    };
    (0..count).map(ray).collect()
}

/// Diffuse bounces from random places, and shadow rays from there to a patch of the ceiling.
fn incoherent_rays(accel: &Accel, shape: &Shape, count: usize, random: &mut impl Rng) -> [Vec<PackedRay>; 2] {
    let (mut bounces, mut shadows) = (Vec::with_capacity(count), Vec::with_capacity(count));
    while bounces.len() < count {
        let ray = Ray::new(in_room(random), uniform(random));
        let Some(hit) = accel.closest(&ray, 0.0) else { continue };
        let point = shape.surface(&hit, &ray).point;
        let normal = if point.normal.dot(ray.direction) > 0.0 { -point.normal } else { point.normal };
        let origin = point.position + normal * OFFSET;
        bounces.push(pack(&Ray::new(origin, cosine(normal, random))));
        let light = Vec3::new(random.random_range(-1.0..1.0), random.random_range(-1.0..1.0), ROOM - OFFSET);
        let toward = light - origin;
        shadows.push(pack(&Ray { origin, direction: toward.normalize(), t_max: toward.length() }));
    }
    [bounces, shadows]
}

fn pack(ray: &Ray) -> PackedRay {
    let ([ox, oy, oz], [dx, dy, dz]) = (ray.origin.as_vec3().to_array(), ray.direction.as_vec3().to_array());
    [ox, oy, oz, dx, dy, dz, ray.t_max as f32]
}

pub fn unpack([ox, oy, oz, dx, dy, dz, t_max]: PackedRay) -> Ray {
    let vector = |x: f32, y: f32, z: f32| Vec3::new(x.into(), y.into(), z.into());
    Ray { origin: vector(ox, oy, oz), direction: vector(dx, dy, dz), t_max: t_max.into() }
}

fn uniform(random: &mut impl Rng) -> Vec3 {
    let (z, azimuth) = (random.random_range(-1.0..1.0f64), random.random_range(0.0..TAU));
    let r = (1.0 - z * z).sqrt();
    Vec3::new(r * azimuth.cos(), r * azimuth.sin(), z)
}

fn cosine(normal: Vec3, random: &mut impl Rng) -> Vec3 {
    let (r2, azimuth) = (random.random::<f64>(), random.random_range(0.0..TAU));
    let local = Vec3::new(r2.sqrt() * azimuth.cos(), r2.sqrt() * azimuth.sin(), (1.0 - r2).sqrt());
    Frame::around(normal).to_world(local)
}
