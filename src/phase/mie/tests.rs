use super::*;
use crate::spectrum::catalogue;

fn water(sizes: Sizes) -> Population {
    let range = WavelengthRange::VISIBLE;
    let index = catalogue::dielectric("water").unwrap().to_spectrum(range).unwrap();
    Population { sizes, index: [index, Spectrum::ZERO], host: Spectrum::Constant(1.0) }
}

/// The angles (degrees) between two at which the density has a local maximum.
fn peaks(table: &SpectralTable, nm: f64, [from, to]: [f64; 2]) -> Vec<f64> {
    let angles: Vec<f64> = (0..=1000).map(|i| from + (to - from) * f64::from(i) / 1000.0).collect();
    let at = |angle: f64| table.density(angle.to_radians().cos(), &[nm])[0];
    let highest = |three: &&[f64]| at(three[1]) > at(three[0]) && at(three[1]) >= at(three[2]);
    angles.windows(3).filter(highest).map(|three| three[1]).collect()
}

/// Cloud drops of 10 µm: a broad bow without colours near 140°, inside of the rainbow's 138°, and the glory
/// around the shadow's head, larger in red than in blue.
#[test]
fn cloud_drops_show_fogbow_and_glory() {
    let optics =
        water(Sizes::Gamma { effective: 10.0, variance: 0.02 }).optics(WavelengthRange::VISIBLE).unwrap();
    let bow = peaks(&optics.phase, 550.0, [136.0, 150.0]);
    assert!(bow.iter().any(|angle| (139.0..146.0).contains(angle)), "{bow:?}");
    let ring = |nm: f64| {
        let glory = peaks(&optics.phase, nm, [170.0, 179.5]);
        180.0 - glory.iter().copied().fold(0.0, f64::max)
    };
    let [blue, red] = [ring(450.0), ring(650.0)];
    assert!(blue > 1.0 && red > blue * 1.2 && red < 5.0, "{blue}, {red}");
    // Large drops take out twice what falls on them, and half of that is diffraction straight ahead.
    let mean_area_over_volume = 3.0 / (4.0 * 10.0);
    let extinction = optics.extinction.at(550.0) / mean_area_over_volume;
    assert!((extinction - 2.0).abs() < 0.2, "{extinction}");
    assert_eq!(optics.extinction.at(500.0), optics.scattering.at(500.0));
}

/// What is small scatters blue by λ⁻⁴, alike forward and back.
#[test]
fn small_spheres_scatter_blue() {
    let sizes = Sizes::LogNormal { median: 0.004, spread: 1.2 };
    let population = Population { index: [Spectrum::Constant(1.5), Spectrum::ZERO], ..water(sizes) };
    let optics = population.optics(WavelengthRange::VISIBLE).unwrap();
    let ratio = optics.scattering.at(400.0) / optics.scattering.at(800.0);
    assert!((ratio / 16.0 - 1.0).abs() < 0.02, "{ratio}");
    for cos in [-1.0, 0.0, 0.5, 1.0] {
        let [density] = optics.phase.density(cos, &[400.0]);
        let expected = 3.0 / 8.0 * (1.0 + cos * cos);
        assert!((density / expected - 1.0).abs() < 0.02, "{cos}: {density}, not {expected}");
    }
}

/// The mean cosine of the table is that of the spheres, weighed by what they scatter, and moments of the
/// sizes are what they should be.
#[test]
fn tables_keep_what_spheres_do() {
    for sizes in [
        Sizes::One(1.3),
        Sizes::LogNormal { median: 0.4, spread: 1.6 },
        Sizes::Gamma { effective: 2.0, variance: 0.1 },
    ] {
        let population =
            Population { index: [Spectrum::Constant(1.45), Spectrum::Constant(0.01)], ..water(sizes) };
        let optics = population.optics(WavelengthRange { min: 500.0, max: 560.0 }).unwrap();
        let per_radius = 2e3 * PI / 500.0;
        let nodes = sizes.nodes(per_radius);
        let number: f64 = nodes.iter().map(|node| node.number).sum();
        let volume: f64 = nodes.iter().map(|node| 4.0 / 3.0 * PI * node.radius.powi(3) * node.number).sum();
        assert!((volume / sizes.mean_volume() - 1.0).abs() < 1e-3, "{sizes:?}: {volume}");
        assert!(number <= 1.0 + 1e-9, "{sizes:?}: {number}");
        let (mut scattered, mut forward) = (0.0, 0.0);
        for node in &nodes {
            let sphere = Sphere::new(node.radius * per_radius, Complex64::new(1.45, 0.01));
            let area = node.radius * node.radius * node.number * sphere.scattering();
            scattered += area;
            forward += area * sphere.mean_cosine();
        }
        let cells = 400_000;
        let mean: f64 = (0..cells)
            .map(|i| {
                let cos = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(cells);
                2.0 / f64::from(cells) * cos * optics.phase.density(cos, &[500.0])[0]
            })
            .sum();
        assert!((mean - forward / scattered).abs() < 1e-3, "{sizes:?}: {mean}, not {}", forward / scattered);
        assert!(optics.scattering.at(520.0) < optics.extinction.at(520.0));
    }
}

/// With the size that they have.
#[test]
fn spheres_too_large_are_refused() {
    let error = water(Sizes::One(1000.0)).optics(WavelengthRange::VISIBLE).unwrap_err();
    assert!(matches!(error, MieError::TooLarge { size } if size > LARGEST), "{error:?}");
    assert!(error.to_string().contains("more than 4000"), "{error}");
    // An index that no material has would take memory in proportion.
    let index = [Spectrum::Constant(1e9), Spectrum::ZERO];
    let dense = Population { index, ..water(Sizes::One(10.0)) };
    let error = dense.optics(WavelengthRange::VISIBLE).unwrap_err();
    assert!(matches!(error, MieError::TooDense { .. }), "{error:?}");
    assert!(error.to_string().contains("more than 400000"), "{error}");
}
