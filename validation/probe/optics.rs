use abbe::bsdf::fresnel;
use serde::Deserialize;
use serde_json::{Value, json};
use std::error::Error;

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// Unpolarised reflectance of a conductor n + ik seen from vacuum, at the cosines of the angles of incidence.
    Conductor { cosines: Vec<f64>, n: f64, k: f64 },
}

pub fn answer(question: Question) -> Result<Value, Box<dyn Error>> {
    Ok(match question {
        Question::Conductor { cosines, n, k } => {
            json!(cosines.into_iter().map(|cosine| fresnel::conductor(cosine, n, k)).collect::<Vec<f64>>())
        }
    })
}
