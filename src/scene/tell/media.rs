use super::super::description::{Medium, Phase, PhaseKind, SpectrumKind, SpectrumSource};
use super::super::read::Class;
use super::{Told, spectra};

pub(super) fn tell(medium: &Medium) -> Told {
    // The factor is told by itself: multiplied into the values it could round to others.
    let unscaled = SpectrumSource { scale: 1.0, ..medium.extinction.clone() };
    let plugin = if medium.varies { "heterogeneous" } else { "homogeneous" };
    let told = Told::new(Class::Medium, plugin, &medium.place).id(&medium.id);
    let told = quantity(told, "sigma_t", &unscaled).float("scale", medium.extinction.scale);
    quantity(told, "albedo", &medium.albedo).child(phase(&medium.phase))
}

/// A spectrum, or a grid by itself: the texture `volume` around it is for surfaces.
fn quantity(told: Told, name: &'static str, source: &SpectrumSource) -> Told {
    match &source.kind {
        SpectrumKind::Volume(volume) => told.named(name, spectra::volume(&source.place, volume)),
        _ => told.spectrum(name, source),
    }
}

fn phase(phase: &Phase) -> Told {
    let told = |plugin| Told::new(Class::Phase, plugin, &phase.place);
    match &phase.kind {
        PhaseKind::Isotropic => told("isotropic"),
        PhaseKind::HenyeyGreenstein { g } => told("hg").float("g", *g),
        PhaseKind::Rayleigh => told("rayleigh"),
        PhaseKind::Tabulated { values } => told("tabphase").numbers("values", values),
        PhaseKind::Blend { weight, nested } => {
            let [first, second] = &**nested;
            let [first, second] = [first, second].map(self::phase);
            quantity(told("blendphase"), "weight", weight).child(first).child(second)
        }
    }
}
