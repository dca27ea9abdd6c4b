use super::super::description::{Medium, Phase, PhaseKind, SpectrumKind, SpectrumSource};
use super::super::read::Class;
use super::{Node, spectra};

pub(super) fn write(medium: &Medium) -> Node {
    // The factor is written by itself: multiplied into the values it could round to others.
    let unscaled = SpectrumSource { scale: 1.0, ..medium.extinction.clone() };
    let plugin = if medium.varies { "heterogeneous" } else { "homogeneous" };
    let node = Node::new(Class::Medium, plugin, &medium.place).id(&medium.id);
    let node = quantity(node, "sigma_t", &unscaled).float("scale", medium.extinction.scale);
    quantity(node, "albedo", &medium.albedo).child(phase(&medium.phase))
}

/// A spectrum, or a grid by itself: the texture `volume` around it is for surfaces.
fn quantity(node: Node, name: &'static str, source: &SpectrumSource) -> Node {
    match &source.kind {
        SpectrumKind::Volume(volume) => node.named(name, spectra::volume(&source.place, volume)),
        _ => node.spectrum(name, source),
    }
}

fn phase(phase: &Phase) -> Node {
    let node = |plugin| Node::new(Class::Phase, plugin, &phase.place);
    match &phase.kind {
        PhaseKind::Isotropic => node("isotropic"),
        PhaseKind::HenyeyGreenstein { g } => node("hg").float("g", *g),
        PhaseKind::Rayleigh => node("rayleigh"),
        PhaseKind::Tabulated { values } => node("tabphase").numbers("values", values),
        PhaseKind::Blend { weight, nested } => {
            let [first, second] = &**nested;
            let [first, second] = [first, second].map(self::phase);
            quantity(node("blendphase"), "weight", weight).child(first).child(second)
        }
    }
}
