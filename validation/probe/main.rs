//! Answers questions to the library in double precision, for the validation: one JSON question a line on
//! standard input, one JSON answer a line on standard output.

mod colour;
mod optics;
mod stopping;

use serde::Deserialize;
use std::io::stdin;

#[derive(Deserialize)]
#[serde(rename_all = "snake_case")]
enum Question {
    Colour(colour::Question),
    Optics(optics::Question),
    Stopping(stopping::Question),
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for line in stdin().lines() {
        let answer = match serde_json::from_str(&line?)? {
            Question::Colour(question) => colour::answer(question)?,
            Question::Optics(question) => optics::answer(question)?,
            Question::Stopping(question) => stopping::answer(question)?,
        };
        println!("{answer}");
    }
    Ok(())
}
