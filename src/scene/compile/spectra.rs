use crate::geometry::{Transform, UvTransform};
use crate::scene::description::{
    BitmapSource, IndexKind, IndexSource, PatternSpace, ProceduralSource, RgbRole, SpectrumKind,
    SpectrumSource, VolumeSource,
};
use crate::scene::source::{Place, SceneError};
use crate::spectrum::{Extrapolation, NormalReflectance, Spectrum, SpectrumError, catalogue, upsample};
use crate::texture::{
    Attribute, Bitmap, Checkerboard, Ground, Placing, Procedural, Texture, Volume, from_box,
};
use crate::units::WavelengthRange;

/// A spectrum that can be looked up. Tables of a file are zero beyond their ends, as in Mitsuba 3; measured
/// ones of the catalogue follow their own rule.
pub(super) fn spectrum(source: &SpectrumSource) -> Result<Spectrum, SceneError> {
    let wrong = |error: &dyn std::fmt::Display| {
        SceneError::at(
            &source.place,
            error.to_string(),
            "a spectrum of finite values over ascending wavelengths",
        )
    };
    let unscaled = match &source.kind {
        SpectrumKind::Constant(value) => Spectrum::Constant(*value),
        SpectrumKind::Irregular { nm, values, .. } => {
            Spectrum::irregular(nm, values, Extrapolation::Zero).map_err(|error| wrong(&error))?
        }
        SpectrumKind::Regular { min_nm, max_nm, values } => {
            Spectrum::regular(*min_nm, *max_nm, values, Extrapolation::Zero).map_err(|error| wrong(&error))?
        }
        SpectrumKind::D65 => d65(&source.place)?,
        SpectrumKind::Blackbody { kelvin, min_nm, max_nm } => {
            thermal(*kelvin, WavelengthRange { min: *min_nm, max: *max_nm }).map_err(|error| wrong(&error))?
        }
        SpectrumKind::Named(name) => named(&source.place, name)?,
        SpectrumKind::Rgb { rgb, role } => colour(&source.place, *rgb, *role)?,
        SpectrumKind::Daylit(nested) => product(&spectrum(nested)?, &d65(&source.place)?),
        _ => {
            return Err(SceneError::at(
                &source.place,
                "A texture stands where nothing can vary over a surface",
                "expected a spectrum, a colour or a number",
            ));
        }
    };
    Ok(if source.scale == 1.0 { unscaled } else { unscaled.scaled(source.scale) })
}

/// The same for an index, or for what one follows from: held beyond the ends of its table, where zero would
/// be no index.
pub(super) fn held(source: &SpectrumSource) -> Result<Spectrum, SceneError> {
    Ok(spectrum(source)?.with_extrapolation(Extrapolation::Hold))
}

/// A quantity that may vary over a surface. `shift` leads from the coordinates of the file to those of the
/// scene.
pub(super) fn texture(source: &SpectrumSource, shift: &Transform) -> Result<Texture, SceneError> {
    quantity(source, shift, Quantity::Spectrum)
}

/// A number that may vary over a surface. An image in colour gives its luminance, as in the RGB variants of
/// Mitsuba 3; its spectral variants stop there.
pub(super) fn number(source: &SpectrumSource, shift: &Transform) -> Result<Texture, SceneError> {
    quantity(source, shift, Quantity::Number)
}

/// What a texture is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Quantity {
    Spectrum,
    Number,
}

fn quantity(source: &SpectrumSource, shift: &Transform, asked: Quantity) -> Result<Texture, SceneError> {
    let unscaled = match &source.kind {
        SpectrumKind::Bitmap(bitmap) => Texture::Bitmap(Box::new(image(bitmap, asked))),
        SpectrumKind::Checkerboard(board) => {
            let [first, second] = &board.colours;
            Texture::Checkerboard(Box::new(Checkerboard {
                colours: [quantity(first, shift, asked)?, quantity(second, shift, asked)?],
                to_uv: to_uv(&board.to_uv),
            }))
        }
        SpectrumKind::MeshAttribute { name } => {
            return Ok(Texture::Attribute(Attribute { name: name.clone(), scale: source.scale }));
        }
        SpectrumKind::Volume(volume) => Texture::Volume(Box::new(grid(volume, &source.place, shift)?)),
        SpectrumKind::Procedural(source) => Texture::Procedural(Box::new(procedural(source, shift, asked)?)),
        SpectrumKind::Daylit(nested) => match texture(nested, shift)? {
            Texture::Uniform(_) => return spectrum(source).map(Texture::Uniform),
            texture => Texture::Filtered { texture: Box::new(texture), by: d65(&source.place)? },
        },
        _ => return spectrum(source).map(Texture::Uniform),
    };
    Ok(match source.scale {
        1.0 => unscaled,
        scale => Texture::Filtered { texture: Box::new(unscaled), by: Spectrum::Constant(scale) },
    })
}

fn procedural(
    source: &ProceduralSource,
    shift: &Transform,
    asked: Quantity,
) -> Result<Procedural, SceneError> {
    let to_periods = Transform::scale(1.0 / source.period);
    Ok(Procedural {
        pattern: source.pattern,
        ground: match &source.space {
            PatternSpace::Uv(transform) => Ground::Uv(to_uv(&transform.then(&to_periods))),
            PatternSpace::World(to_world) => {
                let to_pattern = shift.inverse().then(&to_world.inverse()).then(&to_periods);
                Ground::Solid(glam::DAffine3::from_mat4(to_pattern.matrix()))
            }
        },
        colours: source
            .colours
            .iter()
            .map(|colour| quantity(colour, shift, asked))
            .collect::<Result<_, _>>()?,
        range: source.range,
        mixed: source.mixed,
    })
}

fn image(source: &BitmapSource, asked: Quantity) -> Bitmap {
    let placing = Placing { to_uv: to_uv(&source.to_uv), filter: source.filter, wrap: source.wrap };
    if asked == Quantity::Number && !source.raw && source.image.channels == 3 {
        return Bitmap::new(&source.image.luminance(), placing, false, source.half);
    }
    Bitmap::new(&source.image, placing, source.raw, source.half)
}

fn grid(source: &VolumeSource, place: &Place, shift: &Transform) -> Result<Volume, SceneError> {
    let in_file = shift.inverse().then(&source.to_world.inverse());
    let to_local = if source.use_grid_bbox {
        let normalise = from_box(source.grid.corners).ok_or_else(|| {
            SceneError::at(place, "The box of the grid is flat", "expected a box with a volume")
        })?;
        in_file.then(&normalise)
    } else {
        in_file
    };
    Ok(Volume::new(&source.grid, to_local, source.filter, source.wrap, source.raw))
}

/// Mitsuba 3 takes of a transform in space what it does to x and y.
fn to_uv(transform: &Transform) -> UvTransform {
    let matrix = transform.matrix();
    UvTransform([0, 1].map(|row| {
        let row = matrix.row(row);
        [row.x, row.y, row.w]
    }))
}

/// The spectrum of a colour.
fn colour(place: &Place, rgb: [f64; 3], role: RgbRole) -> Result<Spectrum, SceneError> {
    let reflectance = |rgb: [f64; 3]| match rgb {
        [r, g, b] if r == g && g == b => Spectrum::Constant(r.clamp(0.0, 1.0)),
        _ => Spectrum::Sigmoid { shape: upsample(rgb), factor: 1.0 },
    };
    match role {
        RgbRole::Reflectance | RgbRole::Clipped => Ok(reflectance(rgb)),
        RgbRole::Illuminant => {
            let scale = 2.0 * rgb.into_iter().fold(0.0, f64::max);
            if scale == 0.0 {
                return Ok(Spectrum::ZERO);
            }
            let daylight = d65(place)?;
            Ok(match reflectance(rgb.map(|component| component / scale)) {
                Spectrum::Constant(grey) => daylight.scaled(grey * scale),
                smooth => product(&smooth, &daylight).scaled(scale),
            })
        }
    }
}

/// A function times a table, as a table of the same extent, so fine that it makes no difference.
fn product(function: &Spectrum, table: &Spectrum) -> Spectrum {
    let Some(range) = table.domain() else { return function.clone() };
    let at = |nm: f64| function.at(nm) * table.at(nm);
    Spectrum::tabulated(range, STEP, &[function, table], Extrapolation::Zero, at)
        .unwrap_or_else(|_| function.clone())
}

/// D65 as Mitsuba 3 scales it.
fn d65(place: &Place) -> Result<Spectrum, SceneError> {
    named(place, "D65").map(|published| published.scaled(1.0 / MITSUBA_D65_SCALE))
}

/// Planck's law, cut off at the ends of a range unless that holds all that can be seen.
fn thermal(kelvin: f64, range: WavelengthRange) -> Result<Spectrum, SpectrumError> {
    let whole = Spectrum::blackbody(kelvin)?;
    if range.min <= WavelengthRange::VISIBLE.min && range.max >= WavelengthRange::VISIBLE.max {
        return Ok(whole);
    }
    let range = range.common(WavelengthRange::WIDEST);
    if range.min >= range.max {
        return Ok(Spectrum::ZERO);
    }
    Spectrum::tabulated(range, STEP, &[], Extrapolation::Zero, |nm| whole.at(nm))
}

/// A refractive index over the range.
pub(in crate::scene) fn index(source: &IndexSource, range: WavelengthRange) -> Result<Spectrum, SceneError> {
    let wrong = |error: &dyn std::fmt::Display| {
        SceneError::at(&source.place, error.to_string(), "a finite, positive refractive index")
    };
    match &source.kind {
        IndexKind::Constant(value) => Ok(Spectrum::Constant(*value)),
        IndexKind::Named(name) => match catalogue::dielectric(name) {
            Ok(index) => index.to_spectrum(range).map_err(|error| wrong(&error)),
            Err(unknown) => Err(SceneError::at(
                &source.place,
                unknown.to_string(),
                "the name of a dielectric in the catalogue",
            )),
        },
        IndexKind::Formula(formula) => formula.to_spectrum(range).map_err(|error| wrong(&error)),
        IndexKind::Tabulated(table) => held(table),
        IndexKind::NormalReflectance { reflectance, slab } => {
            let reflectance = held(reflectance)?;
            let optics = match slab {
                true => NormalReflectance::slab(reflectance, range),
                false => NormalReflectance::dielectric(reflectance, range),
            };
            let optics = optics.map_err(|error| wrong(&error))?;
            let (n, _) = complex_index(&optics, range).map_err(|error| wrong(&error))?;
            Ok(n)
        }
    }
}

/// Steps (nm) so fine that to interpolate what was computed there makes no difference to a render.
const STEP: f64 = 0.5;

/// n and k as tables over the range.
pub(super) fn complex_index(
    optics: &NormalReflectance,
    range: WavelengthRange,
) -> Result<(Spectrum, Spectrum), SpectrumError> {
    let measured = optics.measured();
    let table =
        |at: &dyn Fn(f64) -> f64| Spectrum::tabulated(range, STEP, &measured, Extrapolation::Hold, at);
    Ok((table(&|nm| optics.at(nm).0)?, table(&|nm| optics.at(nm).1)?))
}

/// What Mitsuba 3 divides the CIE's table of D65 by.
const MITSUBA_D65_SCALE: f64 = 98.9974;

/// A measured reflectance, illuminant or absorption: no name stands for two of them.
fn named(place: &Place, name: &str) -> Result<Spectrum, SceneError> {
    catalogue::reflectance(name)
        .or_else(|_| catalogue::illuminant(name))
        .or_else(|_| catalogue::absorption(name))
        .or_else(|_| catalogue::sensitivity(name))
        .map_err(|unknown| SceneError::at(place, unknown.to_string(), "the name of a measured spectrum"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::raster::Image;
    use crate::scene::fixture::PLACE;
    use crate::texture::{Filter, TexturePoint, Wrap};
    use std::sync::Arc;

    fn table(nm: &[f64], values: &[f64]) -> SpectrumSource {
        let kind = SpectrumKind::Irregular { nm: nm.to_vec(), values: values.to_vec(), file: None };
        SpectrumSource { place: PLACE, kind, scale: 1.0 }
    }

    /// A line of the trapezoid 589.1, 589.2, 589.3, 589.4 nm and height 300 under D65, which is linear there.
    #[test]
    fn a_line_between_steps_is_lit_by_daylight() {
        let line = table(&[589.1, 589.2, 589.3, 589.4], &[0.0, 300.0, 300.0, 0.0]);
        let kind = SpectrumKind::Daylit(Arc::new(line));
        let daylit = SpectrumSource { place: PLACE, kind, scale: 1.0 };
        let found = spectrum(&daylit).unwrap().integral(WavelengthRange::VISIBLE);
        let exact = 60.0 * d65(&PLACE).unwrap().at(589.25);
        assert!((found / exact - 1.0).abs() < 1e-6, "{found}, not {exact}");
    }

    #[test]
    fn a_metal_has_what_its_reflectance_has_between_steps() {
        let nm = [400.0, 589.1, 589.2, 589.3, 700.0];
        let measured = Spectrum::irregular(&nm, &[0.5, 0.5, 0.9, 0.5, 0.5], Extrapolation::Hold).unwrap();
        let range = WavelengthRange::VISIBLE;
        let optics = NormalReflectance::conductor(measured, Spectrum::ONE, range).unwrap();
        let (n, k) = complex_index(&optics, range).unwrap();
        for nm in [589.1, 589.17, 589.2, 589.24] {
            let (exact_n, exact_k) = optics.at(nm);
            assert!((k.at(nm) / exact_k - 1.0).abs() < 2e-3, "{nm} nm: {}, not {exact_k}", k.at(nm));
            assert_eq!(n.at(nm), exact_n, "{nm} nm");
        }
    }

    /// Mitsuba 3.9.1, `scalar_rgb`: a mask with an 8-bit image of (200, 100, 50) as its opacity lets 0.783725
    /// through, 0.538593 where the image is raw.
    #[test]
    fn an_image_in_colour_gives_its_luminance_where_a_number_is_asked() {
        let image = Image::new(1, 1, 3, [200.0, 100.0, 50.0].map(|value| value / 255.0).to_vec(), true);
        let image = Arc::new(image);
        let source = |raw| SpectrumSource {
            place: PLACE,
            kind: SpectrumKind::Bitmap(Arc::new(BitmapSource {
                file: "colour.png".into(),
                image: image.clone(),
                filter: Filter::Linear,
                wrap: Wrap::Repeat,
                raw,
                half: false,
                to_uv: Transform::IDENTITY,
            })),
            scale: 1.0,
        };
        for (raw, passes) in [(false, 0.783_725), (true, 0.538_593)] {
            let opacity = number(&source(raw), &Transform::IDENTITY).unwrap();
            let found = 1.0 - opacity.value(&TexturePoint::in_space(Vec3::ZERO));
            assert!((found - passes).abs() < 1e-6, "{found} {passes}");
        }
    }
}
