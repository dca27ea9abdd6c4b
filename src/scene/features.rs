//! What a scene asks of the renderer.

/// Features of the renderer that the scene asks for. The renderer branches around the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// Some surface refracts wavelengths into different directions.
    pub dispersion: bool,
    /// Some medium absorbs or scatters.
    pub absorption: bool,
    /// Some medium scatters or sends out light: what is between surfaces is looked at.
    pub scattering: bool,
    /// Some body may lie within another, or holds a medium: paths keep account of what they are inside of.
    pub medium_stack: bool,
    /// Bodies may overlap: surfaces inside the body that takes precedence are ignored.
    pub precedence: bool,
    /// Transparent bodies may have faces in common with other things.
    pub contact: bool,
    /// Rays of the sensor may begin within a body.
    pub sensor_within: bool,
    /// The camera has a lens that is no pinhole.
    pub lens: bool,
    /// Something moves while the shutter is open.
    pub motion: bool,
    /// Lights that are sampled at each vertex.
    pub light_samples: bool,
    /// Some surface is rough without being diffuse.
    pub rough_surfaces: bool,
    /// Some surface chooses between materials at random.
    pub choices: bool,
    /// Shadow rays pass some surfaces by null transmission.
    pub transparent_shadows: bool,
    /// Some surface asks for its coordinates.
    pub textures: bool,
    /// Light tracing finds caustics.
    pub caustics: bool,
    /// Light tracing finds lamps in the picture that few camera rays meet.
    pub visible_lamps: bool,
}

impl Features {
    fn all(&self) -> [(&'static str, bool); 16] {
        [
            ("dispersion", self.dispersion),
            ("absorption", self.absorption),
            ("media that scatter or send out light", self.scattering),
            ("medium stack", self.medium_stack),
            ("precedence", self.precedence),
            ("surfaces in contact", self.contact),
            ("sensor within a body", self.sensor_within),
            ("lens", self.lens),
            ("motion", self.motion),
            ("light samples", self.light_samples),
            ("rough surfaces", self.rough_surfaces),
            ("mixed materials", self.choices),
            ("transparent shadows", self.transparent_shadows),
            ("surface coordinates", self.textures),
            ("caustics by light tracing", self.caustics),
            ("visible lamps by light tracing", self.visible_lamps),
        ]
    }

    /// What one or the other asks for.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            dispersion: self.dispersion || other.dispersion,
            absorption: self.absorption || other.absorption,
            scattering: self.scattering || other.scattering,
            medium_stack: self.medium_stack || other.medium_stack,
            precedence: self.precedence || other.precedence,
            contact: self.contact || other.contact,
            sensor_within: self.sensor_within || other.sensor_within,
            lens: self.lens || other.lens,
            motion: self.motion || other.motion,
            light_samples: self.light_samples || other.light_samples,
            rough_surfaces: self.rough_surfaces || other.rough_surfaces,
            choices: self.choices || other.choices,
            transparent_shadows: self.transparent_shadows || other.transparent_shadows,
            textures: self.textures || other.textures,
            caustics: self.caustics || other.caustics,
            visible_lamps: self.visible_lamps || other.visible_lamps,
        }
    }

    /// Whether a hit has to be resolved: surfaces may coincide, or be hidden by a body that counts more.
    pub fn interface_events(&self) -> bool {
        self.precedence || self.contact
    }

    /// What the renderer does for this scene beyond the least.
    pub fn used(&self) -> Vec<&'static str> {
        self.all().into_iter().filter(|(_, needed)| *needed).map(|(name, _)| name).collect()
    }

    /// What the renderer leaves out, because the scene has no need of it.
    pub fn skipped(&self) -> Vec<&'static str> {
        self.all().into_iter().filter(|(_, needed)| !*needed).map(|(name, _)| name).collect()
    }
}

impl std::fmt::Display for Features {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let list = |names: Vec<&str>| if names.is_empty() { "nothing".to_owned() } else { names.join(", ") };
        write!(f, "used: {}; skipped: {}", list(self.used()), list(self.skipped()))
    }
}
