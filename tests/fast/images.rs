//! Images and grids that scenes name: what is read from each format, and what damaged files do.

use crate::common::mutation::mutated;
use crate::common::stress;
use abbe::raster::{Grid, Image};
use image::{DynamicImage, ImageFormat};
use std::io::Cursor;

fn pfm(header: &str, values: &[f32]) -> Vec<u8> {
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn png(image: DynamicImage) -> Vec<u8> {
    encoded(&image, ImageFormat::Png)
}

fn exr(channels: &[(&str, f32)]) -> Vec<u8> {
    use exr::prelude::*;
    let channels = channels
        .iter()
        .map(|&(name, value)| AnyChannel::new(name, FlatSamples::F32(vec![value, 2.0 * value])));
    let image = exr::prelude::Image::from_channels((2, 1), AnyChannels::sort(channels.collect()));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn float_maps_stand_on_their_heads() {
    let image = Image::decode(&pfm("Pf\n2 2\n-1.0\n", &[3.0, 4.0, 1.0, 2.0]), None).unwrap();
    assert_eq!((image.width, image.height, image.channels, image.encoded), (2, 2, 1, false));
    assert_eq!(image.values, [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn integers_are_encoded_and_floats_are_not() {
    let pixels = image::RgbaImage::from_raw(1, 1, vec![255, 128, 0, 7]).unwrap();
    let image = Image::decode(&png(pixels.into()), None).unwrap();
    assert!(image.encoded && image.channels == 3);
    assert_eq!(image.values, [1.0, 128.0 / 255.0, 0.0]);
    // IEC 61966-2-1: 128 of 255 is 0.21586 of the light.
    assert!((image.linear().texel(0, 0)[1] - 0.215_861).abs() < 1e-6);
    let grey = image::ImageBuffer::<image::Luma<u16>, _>::from_raw(1, 1, vec![65535]).unwrap();
    let image = Image::decode(&png(grey.into()), None).unwrap();
    assert!(image.encoded && image.channels == 1 && image.values == [1.0]);
}

#[test]
fn radiance_files_of_either_name_are_read() {
    for name in ["RADIANCE", "RGBE"] {
        let mut bytes = format!("#?{name}\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n").into_bytes();
        // The greatest mantissa is 230 of 256, at exponent 0.
        bytes.extend([230, 25, 128, 128]);
        let image = Image::decode(&bytes, None).unwrap();
        assert_eq!(image.values, [0.898_437_5, 25.0 / 256.0, 0.5]);
    }
}

#[test]
fn exr_channels_are_found_by_name() {
    let values = |channels| Image::decode(&exr(channels), None).map(|image| image.values);
    assert_eq!(
        values(&[("A", 9.0), ("B", 3.0), ("G", 2.0), ("R", 1.0)]).unwrap(),
        [1.0, 2.0, 3.0, 2.0, 4.0, 6.0]
    );
    assert_eq!(values(&[("layer.y", 0.5)]).unwrap(), [0.5, 1.0]);
    // Mitsuba 3.9.1 refuses what is none of its pixel formats.
    assert!(values(&[("Z", 0.5)]).unwrap_err().problem.contains("channels Z"));
    assert!(values(&[("B", 3.0), ("G", 2.0), ("R", 1.0), ("Z", 0.5)]).is_err());
}

/// Primaries and white of ACES (SMPTE ST 2065-1): from them to XYZ, and from there to BT.709, as Mitsuba 3.9
/// does, without adapting white. Those of BT.709 change nothing.
#[test]
fn exr_chromaticities_count() {
    use exr::meta::attribute::Chromaticities;
    use exr::prelude::*;
    let values = |chromaticities: [(f32, f32); 4]| {
        let [red, green, blue, white] = chromaticities.map(|(x, y)| Vec2(x, y));
        let channels = [("B", 0.3), ("G", 0.5), ("R", 0.2)];
        let channels = channels.map(|(name, value)| AnyChannel::new(name, FlatSamples::F32(vec![value])));
        let mut image =
            exr::prelude::Image::from_channels((1, 1), AnyChannels::sort(channels.into_iter().collect()));
        image.attributes.chromaticities = Some(Chromaticities { red, green, blue, white });
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        abbe::raster::Image::decode(&bytes.into_inner(), None).unwrap().values
    };
    let found = values([(0.7347, 0.2653), (0.0, 1.0), (0.0001, -0.077), (0.32168, 0.33767)]);
    let expected = [-0.165_601_7, 0.599_364_7, 0.246_606_7];
    assert!(found.iter().zip(expected).all(|(found, wanted)| (found - wanted).abs() < 1e-5), "{found:?}");
    assert_eq!(values([(0.64, 0.33), (0.3, 0.6), (0.15, 0.06), (0.3127, 0.329)]), [0.2, 0.5, 0.3]);
}

#[test]
fn sizes_are_checked_before_memory_is_asked_for() {
    let mut huge = png(image::GrayImage::new(1, 1).into());
    // Width and height stand in the header chunk; its checksum follows.
    huge[16..24].copy_from_slice(&[0, 0, 0x80, 0, 0, 0, 0x80, 0]);
    assert!(Image::decode(&huge, None).is_err());
    let error = Image::decode(&pfm("PF\n100000 1000\n-1\n", &[0.0; 3]), None).unwrap_err();
    assert!(error.problem.contains("too short"), "{error:?}");
    let error = Image::decode(&pfm("PF\n18446744073709551615 3\n-1\n", &[0.0; 3]), None).unwrap_err();
    assert!(error.problem.contains("too large"), "{error:?}");
    assert!(
        Image::decode(&pfm("Pf\n2 1\n-1\n", &[0.0, f32::NAN]), None).unwrap_err().problem.contains("1, 0")
    );
}

#[test]
fn damaged_files_are_refused() {
    let whole = [
        png(image::RgbImage::new(9, 7).into()),
        exr(&[("B", 3.0), ("G", 2.0), ("R", 1.0)]),
        pfm("PF\n1 1\n-1\n", &[1.0, 2.0, 3.0]),
    ];
    for bytes in whole {
        assert!(Image::decode(&bytes, None).is_ok());
        for length in 0..bytes.len() - 1 {
            // A PNG may lack its last chunk; all else is an error, and nothing panics.
            let _ = Image::decode(&bytes[..length], None);
        }
        assert!(Image::decode(&bytes[..bytes.len() / 2], None).is_err());
    }
    assert!(Image::decode(b"GIF89a", Some("tga")).is_err());
    assert!(Image::decode(b"", None).is_err());
}

#[test]
fn changed_files_do_no_harm() {
    let pixels = DynamicImage::ImageRgb8(image::RgbImage::from_fn(9, 7, |x, y| {
        image::Rgb([20 * x as u8, 30 * y as u8, 99])
    }));
    let mut radiance = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 9\n".to_vec();
    radiance.extend([2, 2, 0, 9, 137, 5, 137, 6, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 137, 7].repeat(2));
    let files = [
        encoded(&pixels, ImageFormat::Png),
        encoded(&pixels, ImageFormat::Jpeg),
        encoded(&pixels, ImageFormat::Bmp),
        encoded(&pixels, ImageFormat::Pnm),
        encoded(&pixels, ImageFormat::Tga),
        radiance,
        exr(&[("B", 3.0), ("G", 2.0), ("R", 1.0)]),
        pfm("PF\n2 1\n-1\n", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        [b"VOL\x03\x01\0\0\0\x02\0\0\0\x01\0\0\0\x01\0\0\0\x01\0\0\0".to_vec(), vec![0; 32]].concat(),
    ];
    let mut state = 1;
    for (index, file) in files.iter().enumerate() {
        for _ in 0..stress::count(200, 20_000) {
            let bytes = mutated(file, &mut state);
            if index == 8 {
                let _ = Grid::decode(&bytes);
            } else if let Ok(image) = Image::decode(&bytes, Some("tga")) {
                assert_eq!(image.values.len(), image.width * image.height * image.channels);
            }
        }
    }
}
