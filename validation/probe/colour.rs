use abbe::spectrum::colour::{Lab, delta_e_2000};
use serde::Deserialize;
use serde_json::{Value, json};
use std::error::Error;

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// CIEDE2000 of pairs of CIELAB colours.
    DeltaE2000 { first: Vec<[f64; 3]>, second: Vec<[f64; 3]> },
}

pub fn answer(question: Question) -> Result<Value, Box<dyn Error>> {
    let lab = |[l, a, b]: [f64; 3]| Lab { l, a, b };
    Ok(match question {
        Question::DeltaE2000 { first, second } => {
            let pairs = first.into_iter().zip(second);
            json!(pairs.map(|(a, b)| delta_e_2000(lab(a), lab(b))).collect::<Vec<f64>>())
        }
    })
}
