//! Renders that are ended by a signal, and what is told of those that take long.
#![cfg(unix)]

use crate::common::folder::{Folder, of_repository};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The program under way, and what it says.
struct Running {
    child: Child,
    stderr: BufReader<std::process::ChildStderr>,
}

impl Running {
    fn start(mut command: Command) -> Self {
        command.stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let stderr = BufReader::new(child.stderr.take().expect("it was asked for"));
        Self { child, stderr }
    }

    /// Waits for a line that tells how far it is.
    fn tells(&mut self) -> String {
        self.hears(|line| line.contains(" %  "))
    }

    /// Waits until every pixel has a sample: only then the error is known. On a busy machine the line that
    /// comes after ten seconds of silence comes earlier.
    fn is_begun(&mut self) {
        self.hears(|line| line.contains(" %  ") && !line.contains("not known yet"));
    }

    fn hears(&mut self, is_wanted: impl Fn(&str) -> bool) -> String {
        let mut line = String::new();
        while !is_wanted(&line) {
            line.clear();
            let read = self.stderr.read_line(&mut line).expect("standard error can be read");
            assert!(read > 0, "it ended without a word");
        }
        line
    }

    fn signal(&self, name: &str) {
        let status = Command::new("kill").args([name, &self.child.id().to_string()]).status();
        assert!(status.expect("kill can be run").success());
    }

    /// The exit code, and what else was said.
    fn end(mut self) -> (Option<i32>, String) {
        let mut rest = String::new();
        self.stderr.read_to_string(&mut rest).expect("standard error can be read");
        (self.child.wait().expect("the program ends").code(), rest)
    }
}

/// The program, which heeds a signal that its terminal closes even if the tests do not.
#[allow(unsafe_code, reason = "a call of the operating system")]
fn abbe(folder: &Folder, arguments: &[&str]) -> Command {
    let mut command = folder.command(arguments);
    // SAFETY: to set a signal to what it does by default is allowed between fork and exec.
    unsafe {
        command.pre_exec(|| {
            libc::signal(libc::SIGHUP, libc::SIG_DFL);
            Ok(())
        })
    };
    command
}

const BOX: &str = "scenes/box/scene.xml";

#[test]
fn a_stopped_render_says_what_was_done() {
    const ASKED: f32 = 1e6;
    for signal in ["-INT", "-TERM", "-HUP"] {
        let folder = Folder::new(signal);
        let arguments = ["render", &of_repository(BOX), "--spp=1000000", "--size=40x40"];
        let mut render = Running::start(abbe(&folder, &arguments));
        render.is_begun();
        render.signal(signal);
        let (code, told) = render.end();
        assert_eq!(code, Some(3), "{signal}: {told}");
        assert!(told.contains("stopped: "), "{signal}: {told}");
        assert_eq!(folder.files(), ["box.exr", "box.png"]);
        let file = folder.picture("box.exr");
        let samples = file.channel("samples").expect("the channel is there");
        let [fewest, most] = [f32::min, f32::max].map(|end| samples.iter().copied().reduce(end).unwrap());
        assert!(fewest > 0.0 && most < ASKED, "{signal}: {fewest} to {most}");
        let stated = file.attribute("abbe.samplesPerPixel").expect("it is stated");
        let expected = if fewest == most { format!("{fewest}") } else { format!("{fewest} to {most}") };
        assert_eq!(stated, expected, "{signal}");
        let all: f64 = samples.iter().map(|&samples| f64::from(samples)).sum();
        assert_eq!(file.attribute("abbe.samples"), Some(format!("{all}").as_str()), "{signal}");
    }
}

#[test]
fn a_render_under_nohup_outlives_its_terminal() {
    let folder = Folder::new("nohup");
    let mut command = Command::new("nohup");
    command.args([
        env!("CARGO_BIN_EXE_abbe"),
        "render",
        &of_repository(BOX),
        "--spp=1000000",
        "--size=40x40",
    ]);
    command.current_dir(&folder);
    let mut render = Running::start(command);
    render.tells();
    render.signal("-HUP");
    std::thread::sleep(Duration::from_secs(1));
    assert!(render.child.try_wait().expect("the program can be waited for").is_none(), "it ended");
    render.signal("-INT");
    assert_eq!(render.end().0, Some(3));
}

/// Paths of thousands of segments within white walls: the first pass takes minutes.
const SLOW: &str = r#"<scene version="3.0.0">
    <integrator type="path"><integer name="max_depth" value="4000"/><integer name="rr_depth" value="4000"/></integrator>
    <sensor type="perspective"><film type="hdrfilm"/></sensor>
    <shape type="cube"><boolean name="flip_normals" value="true"/>
        <bsdf type="diffuse"><spectrum name="reflectance" value="1"/></bsdf></shape>
    <shape type="rectangle"><transform name="to_world"><scale value="0.01"/><translate z="0.9"/></transform>
        <emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape></scene>"#;

/// Long before there is anything to write a pipe hears of it; stopped then, it leaves what was there.
#[test]
fn long_renders_and_studies_are_heard_of() {
    let folder = Folder::new("slow");
    folder.write("slow.xml", SLOW);
    for name in ["slow.exr", "slow.png"] {
        folder.write(name, "old");
    }
    let started = Instant::now();
    let size = "--size=512x512";
    let start = |arguments: &[&str]| {
        let more = [size, "--spp=1024", "--threads=1"];
        Running::start(abbe(&folder, &[arguments, &more].concat()))
    };
    let mut render = start(&["render", "slow.xml"]);
    let mut study = start(&["study", "slow.xml", "-o", "noise"]);
    // What is waited for is the clock: meanwhile the other tests have the processor.
    std::thread::sleep(Duration::from_millis(500));
    [&render, &study].into_iter().for_each(|running| running.signal("-STOP"));
    std::thread::sleep(Duration::from_secs(9));
    [&render, &study].into_iter().for_each(|running| running.signal("-CONT"));
    let told = render.tells();
    assert!(told.contains("samples") && told.contains("not known yet"), "{told}");
    assert!(study.tells().contains("reference"));
    // Ten seconds, and what else has to be done on a busy machine.
    assert!(started.elapsed() < Duration::from_secs(25), "{:?}", started.elapsed());
    // The study would end after the run under way.
    study.child.kill().expect("the program can be ended");
    study.end();
    render.signal("-TERM");
    let (code, told) = render.end();
    assert_eq!(code, Some(3), "{told}");
    assert!(told.contains("nothing is written"), "{told}");
    assert_eq!(folder.files(), ["noise", "slow.exr", "slow.png", "slow.xml"]);
    for name in ["slow.exr", "slow.png"] {
        assert_eq!(folder.text(name), "old", "{name}");
    }
}
