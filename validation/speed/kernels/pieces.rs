//! Sample values, spectra, wavelengths, the film and the choice of lights.

use super::paths::compiled;
use super::{BATCH, Kernel};
use abbe::film::{Extras, Film, FilterKind, FilterSampler, FixedPoint, Region};
use abbe::geometry::{SurfacePoint, Vec3};
use abbe::light::Receiver;
use abbe::sampling::{Dimensions, Sampler, SamplerKind};
use abbe::spectrum::colour::Observer;
use abbe::spectrum::table_file::TableFile;
use abbe::spectrum::{Emission, Extrapolation, Response, Spectrum, WavelengthDensity, Wavelengths, upsample};
use abbe::units::WavelengthRange;
use std::cell::RefCell;

/// Samples of a sequence, and indices that are drawn of it.
const SEQUENCE: u32 = 64;

/// All sets of a path with four vertices.
const PATH: [Dimensions; 9] = [
    Dimensions::Camera,
    Dimensions::Light(0),
    Dimensions::Scattering(0),
    Dimensions::Light(1),
    Dimensions::Scattering(1),
    Dimensions::Light(2),
    Dimensions::Scattering(2),
    Dimensions::Light(3),
    Dimensions::Scattering(3),
];

/// The sample values of a whole path.
pub fn samplers() -> Vec<Kernel> {
    let kernel = |(name, kind)| {
        let sampler = Sampler::new(kind, 1, SEQUENCE);
        Kernel::batch(name, move |index| {
            let stream = sampler.stream([index as u32, 7], 3, index as u32 % SEQUENCE);
            PATH.map(|dimensions| stream.draw(dimensions))
        })
    };
    SamplerKind::NAMES.into_iter().map(kernel).collect()
}

/// The fluorescent lamp F11, at 5 nm.
fn fluorescent() -> Spectrum {
    TableFile::parse(include_str!("../../../data/illuminants/cie_fl1_fl12_5nm.csv"))
        .ok()
        .and_then(|table| table.numbers("FL11").ok())
        .and_then(|values| Spectrum::regular(380.0, 780.0, &values, Extrapolation::Zero).ok())
        .expect("the table of lamps has F11 from 380 to 780 nm")
}

fn irregular() -> Spectrum {
    let nodes = [380.0, 410.0, 455.0, 480.0, 500.0, 512.0, 540.0, 580.0, 630.0, 655.0, 700.0, 731.0];
    let values = [0.05, 0.06, 0.09, 0.2, 0.3, 0.4, 0.5, 0.6, 0.4, 0.3, 0.2, 0.1];
    Spectrum::irregular(&nodes, &values, Extrapolation::Zero).expect("nodes that ascend")
}

/// Shares of (0, 1), in no order.
fn fraction(index: usize) -> f64 {
    (0.5 + index as f64 * 0.618_033_988_749_894_9).fract()
}

fn density(emission: &Spectrum) -> WavelengthDensity {
    let curves = Observer::cie1931().spectra();
    let sensor = curves.each_ref().map(|spectrum| Response { spectrum, weight: 1.0 });
    WavelengthDensity::new(WavelengthRange::VISIBLE, &sensor, &[Emission { spectrum: emission, weight: 1.0 }])
}

/// Look-ups at the four wavelengths of a path.
pub fn spectra() -> Vec<Kernel> {
    let flat = density(&Spectrum::ONE);
    let at: Vec<Wavelengths<4>> = (0..BATCH).map(|index| flat.sample(fraction(index))).collect();
    let sigmoid = Spectrum::Sigmoid { shape: upsample([0.7, 0.3, 0.1]), factor: 1.0 };
    let blackbody = Spectrum::blackbody(2856.0).expect("a temperature above 0");
    let named = [
        ("constant", Spectrum::ONE),
        ("regular table", fluorescent()),
        ("irregular table", irregular()),
        ("black body", blackbody),
        ("upsampled colour", sigmoid),
    ];
    let mut kernels: Vec<Kernel> = named
        .into_iter()
        .map(|(name, spectrum)| {
            let of = at.clone();
            Kernel::batch(name, move |index| spectrum.sample(&of[index].nm))
        })
        .collect();
    let observer = Observer::cie1931();
    kernels.push(Kernel::batch("observer", move |index| observer.sample(&at[index].nm)));
    kernels
}

/// The choice of a path's four wavelengths.
pub fn wavelengths() -> Vec<Kernel> {
    let lines =
        Spectrum::irregular(&[588.5, 589.0, 589.6, 590.1], &[0.0, 2.0, 1.0, 0.0], Extrapolation::Zero);
    let lines = lines.expect("nodes that ascend");
    let kernel = |(name, emission): (&str, Spectrum)| {
        let density = density(&emission);
        Kernel::batch(name, move |index| density.sample::<4>(fraction(index)))
    };
    [("flat", Spectrum::ONE), ("F11", fluorescent()), ("sodium lines", lines)].map(kernel).into()
}

/// Adding samples and pixels to a film, and where samples fall on it.
pub fn films() -> Vec<Kernel> {
    let scale = FixedPoint::for_reference(1.0);
    let film = RefCell::new(Film::new(16, 16, 8, Extras::default(), scale));
    let pixel = film.borrow().extras.tile([3, 4], [1, 1], 0..8);
    let sums = RefCell::new(pixel.clone());
    let sample = Kernel::batch("a sample's X, Y, Z", move |index| {
        let mut sums = sums.borrow_mut();
        sums.begin(index as u64, [3, 4]);
        (0..3).for_each(|channel| sums.add(0, index as u32 % 8, channel, fraction(index), scale));
    });
    let pixels = Kernel::batch("a pixel of 8 replicates", move |_| film.borrow_mut().add(&pixel));
    let mut kernels = vec![sample, pixels];
    for (name, kind) in [("box", FilterKind::Box), ("gaussian", FilterKind::Gaussian { stddev: 0.5 })] {
        let filter = FilterSampler::new(kind, Region::whole([16, 16]), false);
        kernels.push(Kernel::batch(format!("filter: {name}"), move |index| {
            filter.sample([5, 7], [fraction(index), fraction(index + 9)])
        }));
    }
    kernels
}

/// The choice of a light and of a point on it.
pub fn lights() -> Vec<Kernel> {
    let kernel = |(name, scene)| {
        let scene = compiled(scene);
        Kernel::batch(name, move |index| {
            let position = Vec3::new(fraction(index) - 0.5, fraction(index + 5) - 0.5, -0.5);
            let point = SurfacePoint { position, normal: Vec3::Z, error: 1e-9 };
            let from = Receiver { point, facing: Vec3::Z };
            let wavelengths = scene.wavelengths.sample::<4>(fraction(index + 9));
            let u = [fraction(index + 2), fraction(index + 3)];
            scene.lights.sample(&from, 0.0, &wavelengths, u)
        })
    };
    [("one lamp", "cornell"), ("lamp and sky", "absorber")].map(kernel).into()
}
