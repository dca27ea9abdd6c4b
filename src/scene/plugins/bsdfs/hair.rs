//! Hair and fur.

use crate::scene::description::{FibreAbsorption, SpectrumSource};
use crate::scene::plugins::fields::Float;
use crate::scene::plugins::indices::Index;
use crate::scene::plugins::spectral::{OptionalSpectral, required};
use crate::scene::plugins::{Field, Parameter, Range, Simple, float};
use crate::scene::read::Query;
use crate::scene::read::spectra::Use;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};

/// Mitsuba 3's default.
pub const INDEX: Index =
    Index { name: "int_ior", default: 1.55, default_name: "amber", doc: "index of the fibre" };

pub const SCALE_TILT: Simple<Float> =
    float("scale_tilt", 2.0, "angle of the scales to the surface of the fibre")
        .within(Range::between(-45.0, 45.0))
        .unit("degrees");

/// A smooth fibre sends light on in single directions, which the model has no lobes for.
pub const fn roughness(name: &'static str, doc: &'static str) -> Simple<Float> {
    float(name, 0.3, doc).within(Range::between(0.001, 1.0))
}

/// `sigma_a`, or the pigments.
pub struct Absorption;

impl Absorption {
    const COEFFICIENT: OptionalSpectral = OptionalSpectral(required(
        "sigma_a",
        Use::Absorption,
        "instead of the pigments, what is absorbed per radius of the fibre; a texture fits",
    ));
    const SCALE: Simple<Float> = float("scale", 1.0, "factor on `sigma_a`").not_negative();
    const EUMELANIN: Simple<Float> =
        float("eumelanin", 1.3, "concentration of the pigment of brown and black hair").not_negative();
    const PHEOMELANIN: Simple<Float> =
        float("pheomelanin", 0.2, "concentration of the pigment of red hair").not_negative();
}

impl Field for Absorption {
    type Value = FibreAbsorption;

    fn parameters(&self) -> Vec<Parameter> {
        let pigments = [Self::EUMELANIN.parameters(), Self::PHEOMELANIN.parameters()].concat();
        [pigments, Self::COEFFICIENT.parameters(), Self::SCALE.parameters()].concat()
    }

    fn read(&self, query: &Query<'_>) -> Option<FibreAbsorption> {
        let (eumelanin, pheomelanin) = (Self::EUMELANIN.read(query), Self::PHEOMELANIN.read(query));
        let (sigma_a, scale) = (Self::COEFFICIENT.read(query)?, Self::SCALE.read(query));
        if !query.has("sigma_a") {
            if query.has("scale") {
                let note = "scale changes nothing: it multiplies `sigma_a`, which is not given";
                query.reader.remark(&query.place("scale"), note.to_owned());
            }
            return Some(FibreAbsorption::Pigments { eumelanin: eumelanin?, pheomelanin: pheomelanin? });
        }
        if let Some(pigment) = ["eumelanin", "pheomelanin"].into_iter().find(|name| query.has(name)) {
            let problem = "The absorption is given twice";
            let expected = "expected either `sigma_a`, or pigments";
            query.error(SceneError::at(&query.place(pigment), problem, expected));
        }
        let sigma_a = sigma_a?;
        Some(FibreAbsorption::Coefficient(SpectrumSource { scale: sigma_a.scale * scale?, ..sigma_a }))
    }

    fn write(&self, node: Node, absorption: &FibreAbsorption, writer: &mut Writer) -> Node {
        match absorption {
            FibreAbsorption::Pigments { eumelanin, pheomelanin } => {
                let node = Self::EUMELANIN.write(node, eumelanin, writer);
                Self::PHEOMELANIN.write(node, pheomelanin, writer)
            }
            FibreAbsorption::Coefficient(source) => {
                let node = node.spectrum("sigma_a", &SpectrumSource { scale: 1.0, ..source.clone() });
                Self::SCALE.write(node, &source.scale, writer)
            }
        }
    }
}
