//! Formulas of the index of refraction.

use super::super::fields::{Float, Numbers};
use super::super::{Field, Parameter, Simple, float, numbers};
use crate::scene::read::Query;
use crate::scene::source::SceneError;
use crate::scene::write::{Node, Writer};
use crate::spectrum::{DispersionFormula, FormulaKind};
use crate::units::WavelengthRange;

pub const LEAST_WAVELENGTH: Simple<Float> =
    float("wavelength_min", WavelengthRange::VISIBLE.min, "where it begins").positive().unit("nm");
pub const GREATEST_WAVELENGTH: Simple<Float> =
    float("wavelength_max", WavelengthRange::VISIBLE.max, "where it ends").positive().unit("nm");

/// The coefficients of a formula, by its lists of numbers, and the range that it is for.
pub struct Formula(pub &'static [Simple<Numbers>]);

pub static SELLMEIER: [Simple<Numbers>; 2] =
    [numbers("b", "factors of the terms"), numbers("c", "squares of their wavelengths, µm²")];
pub static CAUCHY: [Simple<Numbers>; 1] = [numbers("coefficients", "A, B, C …")];

impl Field for Formula {
    type Value = DispersionFormula;

    fn parameters(&self) -> Vec<Parameter> {
        let range = [LEAST_WAVELENGTH, GREATEST_WAVELENGTH];
        self.0.iter().flat_map(Field::parameters).chain(range.iter().flat_map(Field::parameters)).collect()
    }

    fn read(&self, query: &Query<'_>) -> Option<DispersionFormula> {
        let range =
            WavelengthRange { min: LEAST_WAVELENGTH.read(query)?, max: GREATEST_WAVELENGTH.read(query)? };
        let result = if query.object.plugin == "sellmeier" {
            let b = self.0[0].read(query);
            let c = self.0[1].read(query);
            match (b, c) {
                (Some(b), Some(c)) if b.len() == c.len() && !b.is_empty() => {
                    let terms: Vec<(f64, f64)> = b.into_iter().zip(c).collect();
                    Some(DispersionFormula::sellmeier(&terms, range))
                }
                (Some(b), Some(c)) => {
                    let problem = format!("\"b\" has {} numbers and \"c\" has {}", b.len(), c.len());
                    query.error(SceneError::at(
                        &query.place("c"),
                        problem,
                        "expected as many of one as of the other, at least 1",
                    ));
                    None
                }
                _ => None,
            }
        } else {
            let terms = self.0[0].read(query);
            terms.map(|terms| DispersionFormula::cauchy(&terms, range))
        };
        match result? {
            Ok(formula) => Some(formula),
            Err(error) => {
                query.error(
                    SceneError::at(
                        &query.object.place,
                        "The formula gives no refractive index",
                        error.to_string(),
                    )
                    .with_remedy("coefficients are for wavelengths in micrometres"),
                );
                None
            }
        }
    }

    fn write(&self, node: Node, formula: &DispersionFormula, writer: &mut Writer) -> Node {
        let coefficients = formula.coefficients();
        // The files' formulas have n² − 1 = Σ ..., and powers of 1/λ² that are not written.
        let odd = coefficients.iter().skip(1).step_by(2).copied().collect::<Vec<_>>();
        let node = if formula.kind() == FormulaKind::Cauchy {
            let terms: Vec<f64> = coefficients.first().copied().into_iter().chain(odd).collect();
            node.numbers("coefficients", &terms)
        } else {
            let even = coefficients.iter().skip(2).step_by(2).copied().collect::<Vec<_>>();
            node.numbers("b", &odd).numbers("c", &even)
        };
        let range = formula.stated();
        GREATEST_WAVELENGTH.write(LEAST_WAVELENGTH.write(node, &range.min, writer), &range.max, writer)
    }
}
