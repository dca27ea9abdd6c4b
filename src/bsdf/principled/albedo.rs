//! What principled surfaces return of an even light, for those that must not make energy.
//!
//! The lobes of a principled surface are added without regard to one another: together they may return more
//! than they get. With the directional albedo E(v), the power that leaves for that which arrives along v, a
//! value f becomes
//!
//! `f'(v, l) = f(v, l) / max(1, E(v), E(l))`.
//!
//! It stays reciprocal, since v and l stand there alike; `E'(v) ≤ E(v) / max(1, E(v)) ≤ 1`; and it changes
//! nothing where nothing is made. To divide by the greater of two functions of either direction is how
//! Neumann, Neumann and Szirmay-Kalos bound metals ("Compact Metallic Reflectance Models", Computer Graphics
//! Forum 18(3), 1999).
//!
//! E is linear in the weights of the lobes, which depend on the wavelength. The lobes' own albedos depend on
//! the direction and on a roughness, and are kept in tables.

use super::clear_coat::ClearCoat;
use super::{COAT_REFLECTANCE, PrincipledBase, interface, mix, schlick_cosine, schlick_weight, thin};
use crate::bsdf::kept::Kept;
use crate::bsdf::{flipped, reflected, refracted};
use crate::geometry::{Vec3, angle};
use crate::sampling::quadrature::gauss_legendre;
use crate::sampling::warp;
use crate::spectrum::Sampled;
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

/// Albedos of the lobes of all surfaces of one index.
#[derive(Debug)]
pub struct Albedo {
    facets: Table<4, 4>,
    coat: Table<2, 1>,
}

/// What the tables are made for. A quantity that is the same all over a surface needs one place in them.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Whether the surface has no body ([`super::PrincipledThin`]).
    pub thin: bool,
    /// The index below over that above.
    pub eta: f64,
    /// The square root of the facets' α, 0–1; `None` where it varies.
    pub roughness: Option<f64>,
    /// 0–1; `None` where it varies.
    pub anisotropic: Option<f64>,
    /// Gloss of the clear coat, 0–1; `None` where it varies.
    pub gloss: Option<f64>,
}

/// Albedos of facets met from one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacetAlbedos {
    /// Albedo of facets that reflect everything.
    pub mirror: f64,
    /// Albedo of facets that reflect by Schlick's weight.
    pub schlick: f64,
    /// Albedo of facets that reflect as the interface does.
    pub interface: f64,
    /// Fraction of the light that gets through the interface.
    pub transmitted: f64,
}

/// What the sums over facets that the tables are made of may fall short of the truth by.
const SLACK: f64 = 2e-3;

/// The divisor of a value for light between two directions, from their albedos.
pub(super) fn divisor<const C: usize>(eye: Sampled<C>, light: Sampled<C>) -> Sampled<C> {
    eye.zip(light, |eye, light| (eye.max(light) * (1.0 + SLACK)).max(1.0))
}

impl Albedo {
    /// Kept for the rest of the program, once for all materials that ask for the same.
    pub fn shared(extent: Extent) -> &'static Self {
        type Key = (bool, u64, [Option<u64>; 3]);
        static ALBEDOS: Kept<Key, Albedo> = Kept::new();
        let Extent { thin, eta, roughness, anisotropic, gloss } = extent;
        let key =
            (thin, eta.to_bits(), [roughness, anisotropic, gloss].map(|fraction| fraction.map(f64::to_bits)));
        ALBEDOS.get(key, || Self::new(extent))
    }

    fn new(extent: Extent) -> Self {
        let Extent { thin, eta, roughness, anisotropic, gloss } = extent;
        let turned = if anisotropic == Some(0.0) { Axis::One(0.0) } else { Axis::Even(7) };
        // Where light passes to the faster side, all is reflected beyond the critical angle, up to which
        // reflection rises with an infinite slope.
        let cosines = Axis::Cosine { critical: (1.0 - eta * eta).max(0.0).sqrt() };
        let axis = |fraction: Option<f64>, nodes| fraction.map_or(Axis::Even(nodes), Axis::One);
        let axes = [cosines, turned, axis(roughness, 13), axis(anisotropic, 5)];
        // The more places there are, the fewer facets are looked at in each.
        let count = if axes[2..].iter().any(|axis| axis.nodes() > 1) { 16 } else { 32 };
        let (rule, finer) = (rule(count), rule(64));
        Self {
            facets: Table::new(axes, |[cosine, turn, roughness, anisotropic]| {
                let base = PrincipledBase { roughness, anisotropic, ..PrincipledBase::<1>::WHITE };
                facets(&base, from(cosine, turn * FRAC_PI_2), eta, thin, &rule)
            }),
            coat: Table::new([cosines, axis(gloss, 9)], |[cosine, gloss]| {
                [coat(gloss, from(cosine, 0.0), eta, &finer)]
            }),
        }
    }

    /// Albedos of facets with the roughness of `base`, met along `eye`, which is above.
    pub(super) fn facets<const C: usize>(&self, base: &PrincipledBase<C>, eye: Vec3) -> FacetAlbedos {
        let turn =
            if eye.x == 0.0 && eye.y == 0.0 { 0.0 } else { eye.y.abs().atan2(eye.x.abs()) / FRAC_PI_2 };
        let [mirror, schlick, interface, transmitted] =
            self.facets.at([eye.z, turn, base.roughness, base.anisotropic]);
        FacetAlbedos { mirror, schlick, interface, transmitted }
    }

    /// Albedo of a clear coat of strength 1.
    pub(super) fn coat(&self, gloss: f64, eye: Vec3) -> f64 {
        let [coat] = self.coat.at([eye.z, gloss]);
        coat
    }
}

/// Albedo of a white diffuse base.
pub(super) fn diffuse<const C: usize>(base: &PrincipledBase<C>, eye: Vec3) -> f64 {
    let [smooth, half, rough, flat_smooth, flat_half, flat_rough, _] = bases().at([eye.z]);
    // What is tabulated is a parabola in the roughness.
    let r = base.roughness;
    let at = |smooth: f64, half: f64, rough: f64| {
        smooth * (1.0 - r) * (1.0 - 2.0 * r) + 4.0 * half * r * (1.0 - r) + rough * r * (2.0 * r - 1.0)
    };
    mix(at(smooth, half, rough), at(flat_smooth, flat_half, flat_rough), base.flatness)
}

/// Albedo of white sheen of strength 1.
pub(super) fn sheen(eye: Vec3) -> f64 {
    bases().at([eye.z])[6]
}

/// Diffuse bases of roughness 0, 1/2 and 1, the same flat, and sheen.
fn bases() -> &'static Table<1, 7> {
    static BASES: OnceLock<Table<1, 7>> = OnceLock::new();
    BASES.get_or_init(|| {
        let rule = rule(48);
        Table::new([Axis::Cosine { critical: 0.0 }], |[cosine]| {
            let eye = from(cosine, 0.0);
            let mut sums = [0.0; 7];
            for &(first, first_weight) in &rule {
                for &(second, second_weight) in &rule {
                    let light = Vec3::from(warp::cosine_hemisphere([first, second]));
                    let Some(m) = (eye + light).try_normalize() else { continue };
                    let cos_half = eye.dot(m).clamp(0.0, 1.0);
                    let weight = first_weight * second_weight;
                    for (kind, sum) in sums[..6].iter_mut().enumerate() {
                        let (roughness, flatness) = (0.5 * (kind % 3) as f64, (kind / 3) as f64);
                        let base = PrincipledBase { roughness, flatness, ..PrincipledBase::<1>::WHITE };
                        *sum += weight * base.diffuse(eye.z, light.z, cos_half);
                    }
                    // Sheen has no factor 1/π.
                    sums[6] += weight * std::f64::consts::PI * schlick_weight(cos_half);
                }
            }
            sums
        })
    })
}

fn facets(base: &PrincipledBase<1>, eye: Vec3, eta: f64, thin: bool, rule: &[(f64, f64)]) -> [f64; 4] {
    let microfacets = base.microfacets(1.0);
    let behind = if thin { base.microfacets(thin::spread(eta)) } else { microfacets };
    let mut sums = [0.0; 4];
    for &(first, first_weight) in rule {
        for &(second, second_weight) in rule {
            let weight = first_weight * second_weight;
            let m = microfacets.sample_visible(eye, [first, second]);
            let cos = eye.dot(m).clamp(0.0, 1.0);
            let met = interface(cos, eta);
            let mirrored = reflected(eye, m);
            if mirrored.z > 0.0 && met.reflectance > 0.0 {
                let seen = weight * microfacets.g1(mirrored, m);
                sums[0] += seen;
                sums[1] += seen * schlick_weight(schlick_cosine(cos, eta, met));
                sums[2] += seen * met.reflectance;
            }
            if thin {
                let m = behind.sample_visible(eye, [first, second]);
                let mirrored = reflected(eye, m);
                if mirrored.z > 0.0 && !thin::is_cut(flipped(mirrored), m) {
                    let met = interface(eye.dot(m).clamp(0.0, 1.0), eta);
                    sums[3] += weight * (1.0 - met.reflectance) * behind.g1(mirrored, m);
                }
            } else {
                let refracted = refracted(eye, m, eta, met);
                if refracted.z < 0.0 {
                    sums[3] += weight * (1.0 - met.reflectance) * microfacets.g1(-refracted, m);
                }
            }
        }
    }
    sums
}

fn coat(gloss: f64, eye: Vec3, eta: f64, rule: &[(f64, f64)]) -> f64 {
    let lacquer = ClearCoat::new(gloss);
    let mut sum = 0.0;
    for &(first, first_weight) in rule {
        for &(second, second_weight) in rule {
            let m = lacquer.sample([first, second]);
            let (light, cos) = (reflected(eye, m), eye.dot(m));
            if light.z > 0.0 && cos > 0.0 {
                let met = interface(cos, eta);
                let fresnel = mix(COAT_REFLECTANCE, 1.0, schlick_weight(schlick_cosine(cos, eta, met)));
                // The density D cos θ of m, which turns into that of the light by 1 / (4 cos).
                sum +=
                    first_weight * second_weight * fresnel * lacquer.g(eye, light, m) * light.z * cos / m.z;
            }
        }
    }
    sum
}

/// A rule for integrals over [0, 1].
fn rule(count: usize) -> Vec<(f64, f64)> {
    gauss_legendre(count).map(|(x, weight)| (0.5 + 0.5 * x, 0.5 * weight)).collect()
}

fn from(cosine: f64, turn: f64) -> Vec3 {
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    let (sin_turn, cos_turn) = angle::sin_cos(turn);
    Vec3::new(sine * cos_turn, sine * sin_turn, cosine)
}

/// Where the nodes of a table lie along one of its quantities.
#[derive(Clone, Copy, Debug)]
enum Axis {
    /// One value, whatever is asked for.
    One(f64),
    /// Equal steps from 0 to 1.
    Even(usize),
    /// At cosines. Nodes crowd where albedos change fast: near the horizon, and on both sides of a critical
    /// angle's cosine, which is 0 where there is none.
    Cosine { critical: f64 },
}

impl Axis {
    /// Nodes up to a critical cosine, and from there on.
    const TOTAL: usize = 20;
    const PARTIAL: usize = 40;

    fn nodes(self) -> usize {
        match self {
            Self::One(_) => 1,
            Self::Even(nodes) => nodes,
            Self::Cosine { critical: 0.0 } => Self::PARTIAL,
            Self::Cosine { .. } => Self::TOTAL + Self::PARTIAL - 1,
        }
    }

    /// The value at a node, or between two of them.
    fn value(self, node: f64) -> f64 {
        match self {
            Self::One(value) => value,
            Self::Even(nodes) => node / (nodes - 1) as f64,
            Self::Cosine { critical } => {
                let total = if critical > 0.0 { (Self::TOTAL - 1) as f64 } else { 0.0 };
                let cosine = if node < total {
                    let fraction = node / total;
                    critical * fraction * fraction * (3.0 - 2.0 * fraction)
                } else {
                    let fraction = (node - total) / (Self::PARTIAL - 1) as f64;
                    critical + (1.0 - critical) * fraction * fraction
                };
                // At 0 itself nothing is visible.
                cosine.clamp(1e-5, 1.0)
            }
        }
    }

    /// The node before a value, and the fraction of the way to the next.
    fn place(self, value: f64) -> (usize, f64) {
        let steps = |fraction: f64, nodes: usize| fraction.clamp(0.0, 1.0) * (nodes - 1) as f64;
        let place = match self {
            Self::One(_) => return (0, 0.0),
            Self::Even(nodes) => steps(value, nodes),
            Self::Cosine { critical } if value < critical => {
                // The inverse of 3 s² − 2 s³.
                let fraction = 0.5 - ((1.0 - 2.0 * value / critical).clamp(-1.0, 1.0).asin() / 3.0).sin();
                steps(fraction, Self::TOTAL)
            }
            Self::Cosine { critical } => {
                let below = if critical > 0.0 { Self::TOTAL - 1 } else { 0 };
                let fraction = ((value - critical) / (1.0 - critical)).max(0.0).sqrt();
                below as f64 + steps(fraction, Self::PARTIAL)
            }
        };
        let node = (place as usize).min(self.nodes() - 2);
        (node, place - node as f64)
    }
}

/// N functions of D quantities, linear between nodes. Nodes are lifted where the functions rise above that in
/// between, so that what is told is not less than the truth.
#[derive(Debug)]
struct Table<const D: usize, const N: usize> {
    axes: [Axis; D],
    values: Vec<[f64; N]>,
}

impl<const D: usize, const N: usize> Table<D, N> {
    fn new(axes: [Axis; D], function: impl Fn([f64; D]) -> [f64; N]) -> Self {
        /// Where each cell is looked into, along the first quantity.
        const WITHIN: [f64; 3] = [0.25, 0.5, 0.75];
        let nodes = |counts: [usize; D]| {
            (0..counts.iter().product()).map(move |mut rest: usize| {
                counts.map(|count| {
                    let node = rest % count;
                    rest /= count;
                    node as f64
                })
            })
        };
        let place = |nodes: [f64; D]| std::array::from_fn(|i| axes[i].value(nodes[i]));
        let values = nodes(axes.map(Axis::nodes)).map(|node| function(place(node))).collect();
        let mut table = Self { axes, values };
        // A quantity of one value has one cell, which is its node.
        for cell in nodes(axes.map(|axis| (axis.nodes() - 1).max(1))) {
            for fraction in WITHIN {
                let within = std::array::from_fn(|i| match (axes[i].nodes(), i) {
                    (1, _) => cell[i],
                    (_, 0) => cell[i] + fraction,
                    _ => cell[i] + 0.5,
                });
                let (found, told) = (function(place(within)), table.at(place(within)));
                let corners = table.corners(place(within));
                for (index, _) in corners.filter(|(_, weight)| *weight > 0.0) {
                    for lane in 0..N {
                        table.values[index][lane] += (found[lane] - told[lane]).max(0.0);
                    }
                }
            }
        }
        table
    }

    /// The nodes around a place, each with its weight.
    fn corners(&self, place: [f64; D]) -> impl Iterator<Item = (usize, f64)> + use<D, N> {
        let mut around = [(0, 0, 0.0); D];
        let mut stride = 1;
        for (axis, (place, around)) in self.axes.iter().zip(place.into_iter().zip(&mut around)) {
            let (node, fraction) = axis.place(place);
            *around = (node * stride, stride, fraction);
            stride *= axis.nodes();
        }
        (0..1u32 << D).map(move |corner| {
            around.iter().enumerate().fold((0, 1.0), |(index, weight), (bit, &(node, stride, fraction))| {
                match corner >> bit & 1 == 1 {
                    true => (index + node + stride, weight * fraction),
                    false => (index + node, weight * (1.0 - fraction)),
                }
            })
        })
    }

    fn at(&self, place: [f64; D]) -> [f64; N] {
        let mut sums = [0.0; N];
        for (index, weight) in self.corners(place).filter(|(_, weight)| *weight > 0.0) {
            for (sum, value) in sums.iter_mut().zip(&self.values[index]) {
                *sum += weight * value;
            }
        }
        sums
    }
}
