mod plot;
mod report;

use super::Failure;
use super::render::{cannot_read, cannot_write};
use abbe::output::write_whole;
use abbe::spectrum::catalogue::{self, Kind, Quantity};
use abbe::spectrum::table_file::TableFile;
use abbe::spectrum::{Extrapolation, Spectrum, text};
use abbe::units::WavelengthRange;
use std::path::{Path, PathBuf};

/// Say what a spectrum is: its source, its values, its colour under illuminants, and for materials index,
/// Abbe number and reflectance
#[derive(clap::Args)]
pub struct Args {
    /// Name of a built-in spectrum (D65, gold, BK7, colorchecker/red...), an .spd file (lines of a wavelength
    /// in nm and a value, as scenes take it), or a .csv table: a line of names, of which the first is
    /// wavelength_nm, then lines of numbers, with commas between
    #[arg(required_unless_present = "list", value_name = "NAME|FILE")]
    spectrum: Option<String>,

    /// What the name means, where it means several things
    #[arg(long, value_parser = parse_kind)]
    kind: Option<Kind>,

    /// Column of a .csv table with several columns
    #[arg(long)]
    column: Option<String>,

    /// Give values at this wavelength (nm) instead of every 20 nm; may be repeated
    #[arg(long, value_name = "NM", value_parser = parse_wavelength)]
    at: Vec<f64>,

    /// Count light in photons too: its values times λ / (h c), in photons·s⁻¹ where they are in watts, so
    /// photons·s⁻¹·m⁻²·sr⁻¹·nm⁻¹ for a radiance
    #[arg(long)]
    photons: bool,

    /// Draw the spectrum as a picture, SVG or PNG by the name
    #[arg(long, value_name = "OUT.svg|png")]
    plot: Option<PathBuf>,

    /// List the built-in spectra, of one kind with --kind
    #[arg(long)]
    list: bool,
}

fn parse_kind(text: &str) -> Result<Kind, String> {
    Kind::ALL
        .into_iter()
        .find(|kind| kind.name() == text)
        .ok_or_else(|| format!("expected one of {}", Kind::ALL.map(Kind::name).join(", ")))
}

fn parse_wavelength(text: &str) -> Result<f64, String> {
    let WavelengthRange { min, max } = WavelengthRange::WIDEST;
    let nm = text.parse::<f64>().ok().filter(|nm| (min..=max).contains(nm));
    nm.ok_or_else(|| format!("expected a wavelength from {min} to {max} nm"))
}

/// A spectrum with what is known of it; the kind is not known of a file.
struct Subject {
    title: String,
    kind: Option<Kind>,
    /// Lines of "what: value".
    facts: Vec<(&'static str, String)>,
    quantity: Quantity,
}

pub fn run(args: &Args) -> Result<(), Failure> {
    if args.list {
        return super::print(&list(args.kind));
    }
    let subjects = subjects(args)?;
    // Refused before the report rather than after it.
    let plot = args.plot.as_deref().map(|path| Ok((path, plot(path, &subjects)?))).transpose()?;
    for subject in &subjects {
        let is_light = matches!(subject.kind, Some(Kind::Illuminant) | None);
        if args.photons && !(is_light && matches!(subject.quantity, Quantity::Spectrum(_))) {
            let problem = format!("{}: only light is counted in photons", subject.title);
            return Err(Failure::Input(format!("error: {problem}\nhelp: name an illuminant or a file")));
        }
        super::print(&format!("{}\n", report::report(subject, &args.at, args.photons)))?;
    }
    let Some((path, bytes)) = plot else { return Ok(()) };
    write_whole(path, &bytes).map_err(|error| cannot_write(path, &error))
}

/// The bytes of the plot, of the kind that its name says.
fn plot(path: &Path, subjects: &[Subject]) -> Result<Vec<u8>, Failure> {
    let [subject] = subjects else {
        let kinds: Vec<&str> = subjects.iter().filter_map(|subject| subject.kind).map(Kind::name).collect();
        return Err(Failure::Input(format!(
            "error: the name means several things\nhelp: say which to plot: --kind {}",
            kinds.join(" or --kind ")
        )));
    };
    plot::draw(subject)
        .file(path)
        .map_err(|problem| Failure::Input(format!("error: --plot {}: {problem}", path.display())))
}

fn list(kind: Option<Kind>) -> String {
    let kinds = Kind::ALL.into_iter().filter(|of| kind.is_none_or(|kind| kind == *of));
    let line = |kind, name| match catalogue::lookup(kind, name) {
        Ok(entry) if !entry.aliases.is_empty() => format!("  {name}  ({})\n", entry.aliases.join(", ")),
        _ => format!("  {name}\n"),
    };
    let block = |kind| {
        let lines: String = catalogue::names(kind).into_iter().map(|name| line(kind, name)).collect();
        format!("{kind}\n{lines}")
    };
    kinds.map(block).collect()
}

fn subjects(args: &Args) -> Result<Vec<Subject>, Failure> {
    let wanted = args.spectrum.as_deref().unwrap_or_default();
    let path = Path::new(wanted);
    let ends_in =
        |ending: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
    if ends_in("spd") || ends_in("csv") {
        let content = std::fs::read_to_string(path).map_err(|error| cannot_read(path, &error))?;
        // Editors on Windows may begin a text with a byte order mark.
        let content = content.strip_prefix('\u{feff}').unwrap_or(&content);
        let subject = if ends_in("spd") { from_spd(content) } else { from_table(content, args) };
        return match subject {
            Ok(subject) => {
                let subject = Subject { title: wanted.to_owned(), kind: args.kind, ..subject };
                refuse_impossible(&subject)?;
                Ok(vec![subject])
            }
            Err(problem) => Err(Failure::Input(format!("error: {}: {problem}", path.display()))),
        };
    }
    let kinds = Kind::ALL.into_iter().filter(|of| args.kind.is_none_or(|kind| kind == *of));
    let (found, unknown): (Vec<_>, Vec<_>) =
        kinds.map(|kind| catalogue::lookup(kind, wanted)).partition(Result::is_ok);
    if found.is_empty() {
        let nearest: Vec<String> = unknown
            .into_iter()
            .filter_map(Result::err)
            .filter_map(|error| error.nearest.map(|nearest| format!("'{nearest}' ({})", error.kind)))
            .collect();
        let is_known = |kind: &Kind| catalogue::lookup(*kind, wanted).is_ok();
        let others: Vec<&str> = Kind::ALL.into_iter().filter(is_known).map(Kind::name).collect();
        let hint = match (others.is_empty(), nearest.is_empty()) {
            (false, _) => {
                format!("it names a spectrum of another kind: take --kind {}", others.join(" or --kind "))
            }
            (true, true) => "abbe spectrum --list shows all names".to_owned(),
            (true, false) => format!("did you mean {}?", nearest.join(" or ")),
        };
        let what = args.kind.map_or("spectrum", Kind::name);
        return Err(Failure::Input(format!("error: there is no {what} named '{wanted}'\nhelp: {hint}")));
    }
    let subject = |entry: catalogue::Entry| {
        let mut facts = vec![("source", entry.source), ("licence", entry.licence), ("units", entry.units)];
        facts.extend(entry.notes.into_iter().map(|note| ("note", note)));
        facts.push(("table", format!("data/{}.csv, {}", entry.file, entry.column)));
        let title = format!("{} ({})", entry.name, entry.kind);
        Subject { title, kind: Some(entry.kind), facts, quantity: entry.quantity }
    };
    Ok(found.into_iter().filter_map(Result::ok).map(subject).collect())
}

/// Refuses a file whose values no reflectance has, as a scene does.
fn refuse_impossible(subject: &Subject) -> Result<(), Failure> {
    let (Some(Kind::Reflectance), Quantity::Spectrum(spectrum)) = (subject.kind, &subject.quantity) else {
        return Ok(());
    };
    let values = spectrum.nodes().into_iter().map(|nm| (nm, spectrum.at(nm)));
    let Some((nm, value)) = values.into_iter().find(|(_, value)| !(0.0..=1.0).contains(value)) else {
        return Ok(());
    };
    let remedy = match value {
        2.0..=100.0 => "per cent must be divided by 100",
        _ => "a surface reflects no less than nothing, and no more than it receives",
    };
    Err(Failure::Input(format!(
        "error: {}: the reflectance is {value} at {nm} nm; expected values from 0 to 1\nhelp: {remedy}",
        subject.title
    )))
}

fn from_spd(content: &str) -> Result<Subject, String> {
    let columns = text::parse_spd(content).map_err(|error| match error.problem {
        text::TextProblem::NotNanometres(_) => format!("{error}\nhelp: {}", text::TO_NANOMETRES),
        _ => error.to_string(),
    })?;
    let spectrum = Spectrum::irregular(&columns.nodes, &columns.values, Extrapolation::Zero);
    let quantity = Quantity::Spectrum(spectrum.map_err(|error| error.to_string())?);
    Ok(Subject { title: String::new(), kind: None, facts: Vec::new(), quantity })
}

fn from_table(content: &str, args: &Args) -> Result<Subject, String> {
    let table = TableFile::parse(content).map_err(|error| error.to_string())?;
    let Some(wavelengths) = table.columns.first().filter(|name| name.as_str() == "wavelength_nm") else {
        return Err("expected the first column to be 'wavelength_nm'\n\
             help: begin with a line of names, such as wavelength_nm,reflectance, and give wavelengths in nm"
            .to_owned());
    };
    let nm = table.numbers(wavelengths).map_err(|error| error.to_string())?;
    let spectrum = |column: &str| {
        let values = table.numbers(column).map_err(|error| error.to_string())?;
        Spectrum::irregular(&nm, &values, Extrapolation::Hold).map_err(|error| error.to_string())
    };
    let values = &table.columns[1..];
    let quantity = match (&args.column, values) {
        (Some(column), _) => Quantity::Spectrum(spectrum(column)?),
        (None, [only]) => Quantity::Spectrum(spectrum(only)?),
        (None, [n, k, ..]) if n == "n" && k == "k" => {
            Quantity::ComplexIndex { n: spectrum("n")?, k: spectrum("k")? }
        }
        _ => return Err(format!("say which column with --column: {}", values.join(", "))),
    };
    let mut facts = vec![("source", table.source), ("licence", table.licence), ("units", table.units)];
    facts.extend(table.notes.into_iter().map(|note| ("note", note)));
    facts.retain(|(_, value)| !value.is_empty());
    Ok(Subject { title: String::new(), kind: None, facts, quantity })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(spectrum: &str) -> Args {
        Args {
            spectrum: Some(spectrum.to_owned()),
            kind: None,
            column: None,
            at: Vec::new(),
            photons: false,
            plot: None,
            list: false,
        }
    }

    #[test]
    fn a_name_may_mean_several_things() {
        let kinds = |args: &Args| -> Vec<Option<Kind>> {
            subjects(args).ok().into_iter().flatten().map(|subject| subject.kind).collect()
        };
        assert_eq!(kinds(&args("BK7")), [Some(Kind::Dielectric), Some(Kind::Absorption)]);
        let narrowed = Args { kind: Some(Kind::Dielectric), ..args("BK7") };
        assert_eq!(kinds(&narrowed), [Some(Kind::Dielectric)]);
    }

    #[test]
    fn an_unknown_name_comes_with_suggestions() {
        let Err(Failure::Input(message)) = subjects(&args("golld")) else { panic!("found golld") };
        assert!(message.contains("did you mean 'gold' (conductor)"), "{message}");
    }

    #[test]
    fn a_name_of_another_kind_is_told_with_its_kind() {
        let wrong = Args { kind: Some(Kind::Reflectance), ..args("Au") };
        let Err(Failure::Input(message)) = subjects(&wrong) else { panic!("found Au") };
        assert!(message.contains("no reflectance named 'Au'"), "{message}");
        assert!(message.contains("--kind conductor") && !message.contains("did you mean"), "{message}");
    }

    #[test]
    fn notes_are_those_of_the_material() {
        let told = |name: &str| {
            let of_kind = Args { kind: Some(Kind::Dielectric), ..args(name) };
            let [subject] = &subjects(&of_kind).ok().expect("a listed name")[..] else { panic!("{name}") };
            report::report(subject, &[500.0], false)
        };
        let glass = told("N-SF11");
        for other in ["carbon_disulfide", "methylene_iodide", "nd_check", "formula 1", "com)See"] {
            assert!(!glass.contains(other), "{glass}");
        }
        assert!(glass.contains("glass pages are relative to air"), "{glass}");
        assert!(told("carbon_disulfide").contains("is stated for 300 to 12000 nm"));
    }

    #[test]
    fn tables_with_several_columns_ask_which() {
        let table = "wavelength_nm,a,b\n400,1,2\n500,3,4\n";
        assert_eq!(
            from_table(table, &args("x.csv")).err().as_deref(),
            Some("say which column with --column: a, b")
        );
        let chosen = Args { column: Some("b".to_owned()), ..args("x.csv") };
        let Ok(Subject { quantity: Quantity::Spectrum(spectrum), .. }) = from_table(table, &chosen) else {
            panic!("column b is there")
        };
        assert_eq!(spectrum.at(450.0), 3.0);
    }

    #[test]
    fn every_built_in_spectrum_can_be_told_and_drawn() {
        for kind in Kind::ALL {
            for name in catalogue::names(kind) {
                let of_kind = Args { kind: Some(kind), ..args(name) };
                for subject in subjects(&of_kind).ok().expect("a listed name") {
                    let told = report::report(&subject, &[], false);
                    let bad = |word: &str| ["NaN", "inf", "-inf"].contains(&word);
                    assert!(told.len() > 200 && !told.split_whitespace().any(bad), "{told}");
                    let drawn = plot::draw(&subject).svg();
                    assert!(
                        drawn.ends_with("</svg>\n") && !drawn.contains("NaN") && !drawn.contains("inf"),
                        "{name}"
                    );
                }
            }
        }
    }
}
