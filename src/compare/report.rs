//! A comparison told as a table and as JSON.

use super::bias::{CELLS, LEVEL, POWER, TILE};
use super::{ChannelResult, Comparison, Figures, Noise, Outlier};
use std::fmt::Write;

type Named = Vec<(String, Option<f64>)>;

impl Comparison {
    /// Every figure under the name that it has in the JSON and in conditions; those of a channel as `R.rmse`.
    /// `None` for what these files cannot tell.
    pub fn figures(&self) -> Named {
        let channels = self.channels.iter().flat_map(|channel| {
            let named = move |(name, value)| (format!("{}.{name}", channel.name), value);
            of_channel(channel).into_iter().map(named)
        });
        self.of_the_whole().into_iter().chain(channels).collect()
    }

    /// Figures of the whole comparison: all but those of single channels.
    fn of_the_whole(&self) -> Named {
        let seen = self.seen.as_ref();
        let verdict = self.verdict();
        let tested = |value: fn(&super::Verdict) -> f64| verdict.as_ref().map(value);
        let mut named = of_figures(&self.figures);
        named.extend(
            [
                ("white", seen.map(|seen| seen.white)),
                ("delta_e", seen.map(|seen| seen.delta_e)),
                ("flip", seen.map(|seen| seen.flip)),
                ("hdr_flip", seen.map(|seen| seen.hdr_flip)),
                ("p", tested(|v| v.p)),
                ("p_mean", tested(|v| v.p_mean)),
                ("p_tiles", tested(|v| v.p_tiles)),
                ("p_pixels", tested(|v| v.p_pixels)),
                ("p_uniform", tested(|v| v.p_uniform)),
                ("detectable", tested(|v| v.detectable)),
                ("detectable_tile", tested(|v| v.detectable_tile)),
                ("bad_a", Some(self.bad[0] as f64)),
                ("bad_b", Some(self.bad[1] as f64)),
                ("unmeasured", Some(self.unmeasured as f64)),
            ]
            .map(|(name, value)| (name.to_owned(), value)),
        );
        named
    }

    /// One object:
    /// - `a`, `b`: each with `files`, `errors` (`"stated"`, or `"spread"` of several files, or null) and
    ///   `replicates` behind them (null where the files do not say);
    /// - `width`, `height`, pixels;
    /// - `outliers`: for some pixels in which A is brightest over B, `pixel`, column and row, and `a`, `b`;
    /// - `notes`: sentences, first those on what was assumed;
    /// - `figures`: the names of [`Self::figures`] without those of channels; null for what the files cannot
    ///   tell and for what is no finite number;
    /// - `channels`: for each its own figures, and `p_histogram`, counts of 20 equal cells from p = 0 to 1.
    pub fn json(&self, files: [&[String]; 2]) -> String {
        let side = |side: usize| {
            let replicates = self.replicates[side].map_or("null".to_owned(), |count| count.to_string());
            let files: Vec<String> = files[side].iter().map(|file| quoted(file)).collect();
            let errors = match self.noise[side] {
                Noise::Unknown => "null",
                Noise::Stated => "\"stated\"",
                Noise::Spread => "\"spread\"",
            };
            format!(
                "{{\"files\": [{}], \"errors\": {errors}, \"replicates\": {replicates}}}",
                files.join(", ")
            )
        };
        let object = |named: &Named, indent: &str| {
            let lines: Vec<String> = named
                .iter()
                .map(|(name, value)| format!("{indent}{}: {}", quoted(name), number(*value)))
                .collect();
            lines.join(",\n")
        };
        let channels: Vec<String> = self
            .channels
            .iter()
            .map(|channel| {
                let histogram =
                    channel.tests.as_ref().map_or("null".to_owned(), |t| format!("{:?}", t.histogram));
                let figures = object(&of_channel(channel), "      ");
                let name = quoted(&channel.name);
                format!("    {name}: {{\n{figures},\n      \"p_histogram\": {histogram}\n    }}")
            })
            .collect();
        let notes: Vec<String> = self.all_notes().map(quoted).collect();
        let outlier = |Outlier { pixel: [x, y], values }: &Outlier| {
            let [a, b] = values.map(|value| number(Some(value)));
            format!("{{\"pixel\": [{x}, {y}], \"a\": {a}, \"b\": {b}}}")
        };
        let outliers: Vec<String> = self.outliers.iter().map(outlier).collect();
        format!(
            "{{\n  \"a\": {},\n  \"b\": {},\n  \"width\": {},\n  \"height\": {},\n  \"outliers\": [{}],\n  \"notes\": [{}],\n  \
             \"figures\": {{\n{}\n  }},\n  \"channels\": {{\n{}\n  }}\n}}\n",
            side(0),
            side(1),
            self.width,
            self.height,
            outliers.join(", "),
            notes.join(", "),
            object(&self.of_the_whole(), "    "),
            channels.join(",\n")
        )
    }

    /// The figures as a table for people.
    pub fn table(&self, files: [&[String]; 2]) -> String {
        let mut out = String::new();
        for (side, (name, files)) in ["A", "B"].into_iter().zip(files).enumerate() {
            let role = if side == 1 { ", the reference" } else { "" };
            let errors = match (self.noise[side], self.replicates[side]) {
                (Noise::Unknown, _) => "no errors".to_owned(),
                (Noise::Spread, _) => "errors from their spread".to_owned(),
                (Noise::Stated, Some(count)) => format!("errors from {count} replicates"),
                (Noise::Stated, None) => "errors".to_owned(),
            };
            let pictures = match files {
                [file] => file.clone(),
                files => format!("mean of {} pictures, {}", files.len(), files.join(" ")),
            };
            let _ = writeln!(out, "{name}  {pictures}: {}×{}, {errors}{role}", self.width, self.height);
        }
        for note in self.all_notes() {
            let _ = writeln!(out, "note: {note}");
        }
        let f = &self.figures;
        let of = if self.seen.is_some() { "luminance" } else { "all channels, mean" };
        let _ = writeln!(
            out,
            "\n{of}: A {}, B {}, {} apart\n  RMSE      {}\n  relMSE    {}\n  SMAPE     {}",
            short(f.mean_a),
            short(f.mean_b),
            percent(f.bias),
            short(f.rmse),
            short(f.relmse),
            short(f.smape)
        );
        if let Some(seen) = &self.seen {
            let e = seen.exposures;
            let _ = writeln!(
                out,
                "  ΔE2000    {}   (mean; CIELAB with D65 of luminance {} as white)\n  \
                 FLIP      {}   (mean; value over {}, clipped; {:.1} pixels per degree)\n  \
                 HDR-FLIP  {}   (mean; ACES, {} exposures from 2^{:.2} to 2^{:.2})",
                short(seen.delta_e),
                short(seen.white),
                short(seen.flip),
                short(seen.white),
                seen.pixels_per_degree,
                short(seen.hdr_flip),
                e.count,
                e.start,
                e.stop
            );
        }
        self.tell_outliers(&mut out);
        self.tell_tests(&mut out);
        out
    }

    fn tell_outliers(&self, out: &mut String) {
        let Some(channel) = self.channels.get(self.middle).filter(|_| !self.outliers.is_empty()) else {
            return;
        };
        let told: Vec<String> = self
            .outliers
            .iter()
            .map(|Outlier { pixel: [x, y], values: [a, b] }| {
                format!("{x},{y} ({} for {})", short(*a), short(*b))
            })
            .collect();
        let _ = writeln!(
            out,
            "\nA is brightest over B, in {}, at pixels {}; abbe explain SCENE --pixel X,Y tells why",
            channel.name,
            told.join(", ")
        );
    }

    /// First what was assumed.
    fn all_notes(&self) -> impl Iterator<Item = &str> {
        self.assumptions.iter().chain(&self.notes).map(String::as_str)
    }

    fn tell_tests(&self, out: &mut String) {
        let Some(verdict) = self.verdict() else { return };
        let columns = [
            "mean B",
            "(A−B)/B",
            "± 1 s.e.",
            "p mean",
            "p tiles",
            "p pixels",
            "uniform",
            "detectable",
            "in a tile",
        ];
        let tested = self.channels.iter().filter(|channel| channel.tests.is_some());
        let width = tested.map(|channel| channel.name.chars().count()).max().unwrap_or(0).max(7);
        let _ = write!(out, "\nWelch's t-test\n  {:<width$}", "channel");
        for column in columns {
            let _ = write!(out, "  {column:>10}");
        }
        let (mut histogram, mut noiseless, mut borrowed) = ([0; CELLS], 0, 0);
        for channel in &self.channels {
            let Some(tests) = &channel.tests else { continue };
            histogram.iter_mut().zip(tests.histogram).for_each(|(sum, count)| *sum += count);
            noiseless += tests.noiseless;
            borrowed += tests.borrowed;
            let _ = write!(out, "\n  {:<width$}", channel.name);
            let fractions = [tests.detectable, tests.detectable_tile].map(percent);
            for cell in [
                short(channel.figures.mean_b),
                percent(channel.figures.bias),
                percent(tests.error / channel.figures.mean_b.abs()),
                short(tests.p_mean),
                short(tests.p_tiles),
                short(tests.p_pixels),
                short(tests.p_uniform),
            ]
            .into_iter()
            .chain(fractions)
            {
                let _ = write!(out, "  {cell:>10}");
            }
        }
        let tenths: Vec<String> = histogram.chunks(2).map(|pair| (pair[0] + pair[1]).to_string()).collect();
        let left_out = match noiseless + borrowed {
            0 => String::new(),
            _ => format!(
                "\n    left out of it and of 'uniform': {noiseless} without noise, {borrowed} equal on both sides or black on one"
            ),
        };
        let _ = writeln!(
            out,
            "\n  histogram of the pixels' p, 0 to 1 in tenths: {}{left_out}\n  over all: p = {} of means, tiles of {TILE}×{TILE} and pixels together, corrected for their number (Šidák)\n  \
             detectable: the bias of the mean, and of the median tile, that would be found with a power of {:.0} % at the {:.0} % level",
            tenths.join(" "),
            short(verdict.p),
            100.0 * POWER,
            100.0 * LEVEL
        );
    }
}

fn of_figures(figures: &Figures) -> Named {
    [
        ("mean_a", figures.mean_a),
        ("mean_b", figures.mean_b),
        ("rmse", figures.rmse),
        ("relmse", figures.relmse),
        ("smape", figures.smape),
        ("bias", figures.bias),
    ]
    .map(|(name, value)| (name.to_owned(), Some(value)))
    .into()
}

fn of_channel(channel: &ChannelResult) -> Named {
    let mut named = of_figures(&channel.figures);
    let tests = channel.tests.as_ref();
    named.extend(
        [
            ("bias_error", tests.map(|t| t.error / channel.figures.mean_b.abs())),
            ("p_mean", tests.map(|t| t.p_mean)),
            ("p_tiles", tests.map(|t| t.p_tiles)),
            ("p_pixels", tests.map(|t| t.p_pixels)),
            ("p_uniform", tests.map(|t| t.p_uniform)),
            ("detectable", tests.map(|t| t.detectable)),
            ("detectable_tile", tests.map(|t| t.detectable_tile)),
            ("noiseless", tests.map(|t| t.noiseless as f64)),
            ("borrowed", tests.map(|t| t.borrowed as f64)),
        ]
        .map(|(name, value)| (name.to_owned(), value)),
    );
    named
}

fn number(value: Option<f64>) -> String {
    // The shortest text that reads back as the same number.
    value.filter(|value| value.is_finite()).map_or("null".to_owned(), |value| format!("{value:?}"))
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' | '\\' => quoted.extend(['\\', character]),
            control if control < ' ' => {
                let _ = write!(quoted, "\\u{:04x}", u32::from(control));
            }
            other => quoted.push(other),
        }
    }
    quoted.push('"');
    quoted
}

/// Three significant digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}");
    }
    let digits = (2.0 - size.log10().floor()).clamp(0.0, 5.0) as usize;
    format!("{value:.digits$}")
}

/// Nothing is a fraction of black.
fn percent(fraction: f64) -> String {
    if fraction.is_finite() { format!("{} %", short(100.0 * fraction)) } else { "–".to_owned() }
}
