//! A sample told in words.

use abbe::integrator::{RecordedStep, Step};
use abbe::render::{Explained, Shared};
use abbe::scene::Description;
use std::fmt::Write;

/// Numbers of each wavelength, or one where all are the same.
fn numbers(values: &[f64]) -> String {
    match values {
        [first, rest @ ..] if rest.iter().all(|value| value == first) => format!("{first:.4e}"),
        _ => values.iter().map(|value| format!("{value:.4e}")).collect::<Vec<_>>().join("  "),
    }
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({x:.5}, {y:.5}, {z:.5})")
}

fn within(medium: Option<u32>) -> String {
    medium.map_or_else(String::new, |medium| format!(", through medium {medium}"))
}

fn density(density: Option<f64>) -> String {
    density.map_or_else(|| "one of finitely many directions".to_owned(), |d| format!("density {d:.4e} /sr"))
}

/// Where in the file the shape of a number stands.
fn shape(description: &Description, number: u32) -> String {
    let index = number.saturating_sub(1) as usize;
    let (shapes, solids) = (&description.shapes, &description.solids);
    let at = if let Some(shape) = shapes.get(index) {
        Some((&shape.place, shape.id.as_deref()))
    } else if let Some(solid) = solids.get(index - shapes.len()) {
        Some((&solid.place, None))
    } else {
        description.instances.get(index - shapes.len() - solids.len()).map(|found| (&found.place, None))
    };
    let Some((at, id)) = at else { return format!("shape {number}") };
    let id = id.map_or_else(String::new, |id| format!(" \"{id}\""));
    format!("shape {number}{id} (line {})", description.sources.line(at))
}

pub fn tell(explained: &Explained, description: &Description, light_tracing: bool) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = tell_to(&mut text, explained, description, light_tracing);
    text
}

fn tell_to(
    text: &mut String,
    explained: &Explained,
    description: &Description,
    light_tracing: bool,
) -> std::fmt::Result {
    let Explained { pixel: [x, y], sample, samples, replicate, place: [px, py], time, .. } = explained;
    writeln!(text, "pixel {x},{y}, sample {sample} of {samples} (replicate {replicate})")?;
    writeln!(text, "  at {px:.4}, {py:.4} on the film, at time {time:.6}")?;
    writeln!(text, "  wavelengths {} nm, the first is the hero", list(&explained.wavelengths))?;
    writeln!(text, "  radiance {} W·m⁻²·sr⁻¹·nm⁻¹", numbers(&explained.radiance))?;
    writeln!(
        text,
        "  Y {:.5e}; it makes {:.3} % of the pixel's {:.5e}",
        explained.luminance,
        100.0 * explained.share_of_pixel,
        explained.pixel_luminance
    )?;
    if light_tracing {
        writeln!(text, "  light subpaths add to the pixel; they are not told here")?;
    }
    if let Some(Shared { own, parts, told: [x, y] }) = &explained.shared {
        writeln!(text, "shared suffixes: the radiance is the sum of")?;
        writeln!(text, "  its own light       {}", numbers(own))?;
        for part in parts.iter().filter(|part| part.radiance.iter().any(|&value| value != 0.0)) {
            let [x, y] = part.pixel;
            writeln!(text, "  {:19} {}", format!("the path of {x},{y}"), numbers(&part.radiance))?;
        }
        writeln!(text, "told is the path of {x},{y}, as that pixel alone would follow it")?;
    }
    writeln!(text, "camera ray from {} toward {}", place(explained.origin), place(explained.direction))?;
    for RecordedStep { vertex, step } in &explained.steps {
        tell_step(text, *vertex, step, description)?;
    }
    writeln!(text, "radiance of the path: {}", numbers(&explained.path_radiance))
}

fn list(values: &[f64]) -> String {
    values.iter().map(|value| format!("{value:.2}")).collect::<Vec<_>>().join(", ")
}

fn tell_step(text: &mut String, vertex: u32, step: &Step, description: &Description) -> std::fmt::Result {
    let state = |text: &mut String, throughput: &[f64], ratio: &[f64]| -> std::fmt::Result {
        writeln!(text, "     throughput {}", numbers(throughput))?;
        match ratio.iter().all(|&ratio| ratio == 1.0) {
            true => Ok(()),
            false => writeln!(text, "     densities over the hero's {}", numbers(ratio)),
        }
    };
    match step {
        Step::Surface {
            place: at,
            normal,
            shading_normal,
            distance,
            shape: number,
            material,
            medium,
            throughput,
            ratio,
            ..
        } => {
            let shape = shape(description, *number);
            writeln!(
                text,
                "{vertex:3}  surface: {shape}, material {material}, after {distance:.5}{}",
                within(*medium)
            )?;
            let seen = shading_normal.map(|seen| format!(", shading normal {}", place(seen)));
            writeln!(text, "     at {}, normal {}{}", place(*at), place(*normal), seen.unwrap_or_default())?;
            state(text, throughput, ratio)
        }
        Step::Medium { place: at, distance, medium, throughput, ratio } => {
            writeln!(text, "{vertex:3}  scattered in a medium after {distance:.5}{}", within(*medium))?;
            writeln!(text, "     at {}", place(*at))?;
            state(text, throughput, ratio)
        }
        Step::Escape { direction, medium, throughput, ratio } => {
            writeln!(text, "{vertex:3}  leaves the scene toward {}{}", place(*direction), within(*medium))?;
            state(text, throughput, ratio)
        }
        Step::Found { contribution } => writeln!(text, "     + finds light: {}", numbers(contribution)),
        Step::LightSample { toward, distance, density: of, contribution } => {
            let density = of.map_or_else(|| "of no extent".to_owned(), |of| format!("density {of:.4e} /sr"));
            match distance {
                Some(distance) => {
                    write!(text, "     light sample at {}, {distance:.5} away", place(*toward))?
                }
                None => write!(text, "     light sample toward {}", place(*toward))?,
            }
            match contribution.iter().all(|&value| value == 0.0) {
                true => writeln!(text, ", {density}: nothing arrives"),
                false => writeln!(text, ", {density}\n     + brings {}", numbers(contribution)),
            }
        }
        Step::Scatter { direction, transmitted, density: of, throughput, ratio } => {
            let how = if *transmitted { "goes through" } else { "goes on" };
            writeln!(text, "     {how} toward {}, {}", place(*direction), density(*of))?;
            state(text, throughput, ratio)
        }
        Step::Survive { probability } => {
            writeln!(text, "     survives roulette with probability {probability:.4}")
        }
        Step::Branch { number, of, weight } => {
            writeln!(text, "     branch {} of {of} from vertex {vertex}, weight {weight:.4}", number + 1)
        }
        Step::End { why } => writeln!(text, "     ends: {why}"),
    }
}
