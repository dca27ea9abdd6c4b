//! To come.
/// To come.
#[derive(Clone, Debug)]
pub struct Mesh;
