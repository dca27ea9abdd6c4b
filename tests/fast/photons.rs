//! Light counted in photons: by a film, and by `abbe spectrum`.

use crate::common::folder::{Folder, stderr, stdout};
use abbe::units::{PLANCK, SPEED_OF_LIGHT};

/// A uniform sky of 1 W·m⁻²·sr⁻¹·nm⁻¹ has ∫ λ / (h c) dλ photons.
#[test]
fn a_film_counts_photons() {
    let folder = Folder::new("photons");
    folder.write(
        "scene.xml",
        r#"<scene version="3.0.0"><integrator type="path"/><sensor type="perspective">
           <film type="specfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/>
           <spectrum name="photons" type="measured"><string name="name" value="photons"/></spectrum></film></sensor>
           <emitter type="constant"><spectrum name="radiance" value="1"/></emitter></scene>"#,
    );
    folder.ends(0, &["render", "scene.xml", "--spp=64", "--range=500:600", "-q", "-o", "x.exr"]);
    let picture = folder.picture("x.exr");
    let of = |wanted: &str| {
        let (_, values) = picture.channels.iter().find(|(name, _)| name == wanted).expect("a channel");
        values.iter().map(|&value| f64::from(value)).collect::<Vec<_>>()
    };
    let (photons, errors) = (of("photons"), of("error.photons"));
    let mean = photons.iter().sum::<f64>() / photons.len() as f64;
    let error = errors.iter().map(|error| error * error).sum::<f64>().sqrt() / errors.len() as f64;
    let expected = 0.5 * (600.0f64.powi(2) - 500.0f64.powi(2)) * 1e-9 / (PLANCK * SPEED_OF_LIGHT) / 1e18;
    assert!((mean - expected).abs() < 4.0 * error + 1e-5 * expected, "{mean} ± {error}, not {expected}");
    assert!(error < 1e-3 * expected, "{error}: too noisy to tell anything");
}

#[test]
fn a_spectrum_is_told_in_photons() {
    let folder = Folder::new("photons-spectrum");
    folder.write("flat.spd", "400 1\n700 1\n");
    let told = stdout(&folder.run(&["spectrum", "flat.spd", "--photons", "--at", "555"]));
    // 1 / 3.579e-19 J.
    assert!(told.contains("photons") && told.contains("2.79393e18"), "{told}");
    assert!(!stdout(&folder.run(&["spectrum", "flat.spd", "--at", "555"])).contains("photons"));
    let output = folder.run(&["spectrum", "gold", "--photons"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("only light"), "{}", stderr(&output));
}
