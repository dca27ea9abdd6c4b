//! Several programs that answer the same rays in turn, so that a machine that is faster now and slower then
//! treats all alike.

use super::Measure;
use super::scene::{Kind, Scene};
use std::error::Error;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Distances that differ by no more than this, of 1 + the distance, are the same: Embree computes in single
/// precision.
const SAME: f32 = 1e-4;

/// One program under way.
struct Runner {
    name: String,
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

pub fn measure(settings: &Measure) -> Result<(), Box<dyn Error>> {
    let own = std::env::current_exe()?;
    for &triangles in &settings.triangles {
        let scene = Scene::new(triangles, settings.rays)?;
        let folder = std::env::temp_dir().join(format!("rays-{}", std::process::id()));
        std::fs::create_dir_all(&folder)?;
        let file = folder.join("scene.bin");
        scene.write(&file)?;
        println!("{} triangles, {} rays of each kind", scene.mesh.indices.len(), settings.rays);
        drop(scene);
        let own = format!("{} serve", own.display());
        let commands = std::iter::once(&own).chain(&settings.beside);
        let mut runners =
            commands.map(|command| Runner::start(command, &file)).collect::<Result<Vec<_>, _>>()?;
        for kind in Kind::ALL {
            in_turn(&mut runners, kind, settings.rounds)?;
        }
        for kind in Kind::ALL {
            compare_answers(&mut runners, kind, &folder)?;
        }
        for runner in runners {
            runner.end()?;
        }
        std::fs::remove_dir_all(&folder)?;
    }
    Ok(())
}

/// Prints medians, and those of the ratios within each round.
fn in_turn(runners: &mut [Runner], kind: Kind, rounds: usize) -> Result<(), Box<dyn Error>> {
    let mut times = vec![Vec::new(); runners.len()];
    let mut hits = vec![0; runners.len()];
    for round in 0..rounds {
        for i in 0..runners.len() {
            // Each goes first as often as the others.
            let runner = (i + round) % runners.len();
            let line = runners[runner].ask(kind.name())?;
            let (nanoseconds, count) = line.split_once(' ').ok_or("half an answer")?;
            times[runner].push(nanoseconds.parse::<f64>()?);
            hits[runner] = count.parse()?;
        }
    }
    for (runner, (times_of, hits)) in runners.iter().zip(times.iter().zip(hits)) {
        let ratios = times_of.iter().zip(&times[0]).map(|(time, own)| time / own).collect();
        let (time, ratio) = (median(times_of.clone()), median(ratios));
        println!(
            "  {:8} {:7.1} ns a ray, {:6.3} Mray/s, {hits} hits, {ratio:.3} of the first's time: {}",
            kind.name(),
            time,
            1e3 / time,
            runner.name
        );
    }
    Ok(())
}

/// Counts the rays for which a program says something other than the first, by what it says.
fn compare_answers(runners: &mut [Runner], kind: Kind, folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut first: Option<Vec<(f32, u32)>> = None;
    for runner in runners {
        let path = folder.join("answers.bin");
        runner.ask(&format!("answers {} {}", kind.name(), path.display()))?;
        let answers = read_answers(&path)?;
        let Some(first) = &first else {
            first = Some(answers);
            continue;
        };
        let (mut hits, mut misses, mut nearer, mut farther, mut neighbours) = (0, 0, 0, 0, 0);
        for (&(own, triangle), &(other, its_triangle)) in first.iter().zip(&answers) {
            match (own.is_finite(), other.is_finite()) {
                (false, false) => {}
                (false, true) => hits += 1,
                (true, false) => misses += 1,
                (true, true) if (own - other).abs() <= SAME * (1.0 + own) => {
                    neighbours += usize::from(triangle != its_triangle);
                }
                (true, true) if other < own => nearer += 1,
                (true, true) => farther += 1,
            }
        }
        println!(
            "  {:8} beside the first's answers {misses} hits missed, {hits} more, {farther} farther, {nearer} nearer, {neighbours} \
             at the same distance with another triangle: {}",
            kind.name(),
            runner.name
        );
    }
    Ok(())
}

fn read_answers(path: &PathBuf) -> std::io::Result<Vec<(f32, u32)>> {
    let bytes = std::fs::read(path)?;
    let word = |answer: &[u8], at: usize| std::array::from_fn(|byte| answer[at + byte]);
    let answer = |bytes: &[u8]| (f32::from_le_bytes(word(bytes, 0)), u32::from_le_bytes(word(bytes, 4)));
    Ok(bytes.chunks_exact(8).map(answer).collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}

impl Runner {
    fn start(command: &str, file: &Path) -> Result<Self, Box<dyn Error>> {
        let mut words = command.split_whitespace();
        let program = words.next().ok_or("no command")?;
        let mut process = Command::new(program)
            .args(words)
            .arg(file)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{command}: {error}"))?;
        let (to, from) = (process.stdin.take().ok_or("no input")?, process.stdout.take().ok_or("no output")?);
        let mut runner = Self { name: command.to_string(), process, to, from: BufReader::new(from) };
        let built = runner.hear()?;
        println!("  {built}: {command}");
        Ok(runner)
    }

    fn ask(&mut self, question: &str) -> Result<String, Box<dyn Error>> {
        writeln!(self.to, "{question}")?;
        self.hear()
    }

    fn hear(&mut self) -> Result<String, Box<dyn Error>> {
        let mut line = String::new();
        if self.from.read_line(&mut line)? == 0 {
            return Err(format!("{} ended early", self.name).into());
        }
        Ok(line.trim_end().to_string())
    }

    fn end(mut self) -> Result<(), Box<dyn Error>> {
        drop(self.to);
        let status = self.process.wait()?;
        if status.success() { Ok(()) } else { Err(format!("{}: {status}", self.name).into()) }
    }
}
