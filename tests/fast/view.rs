//! The page that shows a picture: what it tells, and to whom.
#![cfg(unix)]

use crate::common::browser::{self, Tab};
use crate::common::folder::Folder;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Stdio};
use std::time::{Duration, Instant};

const SCENE: &str = r#"<scene version="3.0.0"><integrator type="path"/>
    <sensor type="perspective"><transform name="to_world"><lookat origin="0 -4 1" target="0 0 0.5" up="0 0 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="48"/><integer name="height" value="36"/></film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform><bsdf type="diffuse"/></shape>
    <shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.5"/><bsdf type="plastic"/></shape>
    <emitter type="constant"><spectrum name="radiance" value="400:1, 700:3"/></emitter></scene>"#;

#[test]
fn a_file_that_was_cut_off_is_refused_at_once() {
    let folder = Folder::new("cut-off");
    folder.write("made.xml", SCENE);
    folder.ends(0, &["render", "made.xml", "-o", "x.exr", "--spp=4", "--no-png", "-q"]);
    let whole = folder.bytes("x.exr");
    folder.write("cut.exr", &whole[..whole.len() - 100]);
    let told = folder.ends(2, &["view", "cut.exr"]);
    assert!(told.contains("cannot read cut.exr") && told.contains("expected an OpenEXR file"), "{told}");
}

/// `abbe view`, ended when it is dropped.
struct View {
    child: Child,
    lines: BufReader<ChildStderr>,
    port: u16,
}

impl View {
    fn new(folder: &Folder, arguments: &[&str]) -> Self {
        let mut command = folder.command(&[&["view"], arguments].concat());
        let mut child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
        let mut lines = BufReader::new(child.stderr.take().expect("it is piped"));
        let port = loop {
            let mut line = String::new();
            assert!(lines.read_line(&mut line).expect("text") > 0, "it says where the page is");
            let address = line.strip_prefix("http://127.0.0.1:").and_then(|rest| rest.split('/').next());
            if let Some(port) = address.and_then(|port| port.parse().ok()) {
                break port;
            }
        };
        Self { child, lines, port }
    }

    /// What a request is answered with.
    fn asks(&self, method: &str, path: &str, headers: &str) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        // An answer to this version comes in one piece.
        let request = format!("{method} {path} HTTP/1.0\r\n{headers}\r\n");
        stream.write_all(request.as_bytes()).expect("it listens");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8_lossy(&answer[..end]).into_owned();
        let code = head.split(' ').nth(1).and_then(|code| code.parse().ok()).expect("a code");
        (code, answer.split_off(end + 4))
    }

    fn gets(&self, path: &str) -> (u16, Vec<u8>) {
        self.asks("GET", path, &format!("Host: localhost:{}\r\n", self.port))
    }

    fn json(&self, path: &str) -> Value {
        let (code, body) = self.gets(path);
        assert_eq!(code, 200, "{path}");
        serde_json::from_slice(&body).expect("JSON")
    }

    /// Waits until the state of the page is of some kind.
    fn until(&self, is_met: impl Fn(&Value) -> bool) -> Value {
        let began = Instant::now();
        loop {
            let state = self.json("/state");
            if is_met(&state) {
                return state;
            }
            assert!(began.elapsed() < Duration::from_secs(120), "{state}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Ends it as Ctrl-C does: its code, and what else it said.
    #[allow(unsafe_code, reason = "a call of the operating system")]
    fn end(mut self) -> (Option<i32>, String) {
        // SAFETY: the process is a child that nobody has waited for yet.
        unsafe { libc::kill(self.child.id() as i32, libc::SIGINT) };
        let mut told = String::new();
        self.lines.read_to_string(&mut told).expect("text");
        (self.child.wait().expect("it ends").code(), told)
    }
}

impl Drop for View {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes"))).collect()
}

/// All channels of a pixel are those of the file, bit by bit.
fn assert_is_pixel(view: &View, folder: &Folder, name: &str, [x, y]: [usize; 2]) {
    let picture = folder.picture(name);
    let told = view.json(&format!("/pixel?x={x}&y={y}"));
    let told: Vec<(String, f32)> = serde_json::from_value(told).expect("names and numbers");
    let place = y * picture.width + x;
    let own: Vec<(String, f32)> =
        picture.channels.iter().map(|(name, values)| (name.clone(), values[place])).collect();
    assert_eq!(told, own);
    assert_eq!(told.iter().filter(|(name, _)| name.starts_with("S0.")).count(), 5);
}

/// An address is told once there is something to show.
#[test]
fn what_cannot_be_shown_has_no_address() {
    let folder = Folder::new("view-wrong");
    folder.write("made.xml", SCENE);
    folder.write("bad.xml", "<scene version=\"3.0.0\"><sensor type=\"perspectve\"/></scene>");
    for (arguments, expected) in [
        (&["missing.exr"][..], "cannot read missing.exr"),
        (&["missing.xml"], "missing.xml cannot be read"),
        (&["bad.xml"], "did you mean"),
        (&["made.xml", "--frames=0..2", "-o", "f-%d.exr"], "a page shows one"),
    ] {
        let told = folder.ends(2, &[&["view"], arguments].concat());
        assert!(told.contains(expected) && !told.contains("http://"), "{told}");
    }
}

#[test]
fn a_page_shows_a_picture_and_nothing_else() {
    let folder = Folder::new("view");
    folder.write("made.xml", SCENE);
    folder.ends(0, &["render", "made.xml", "--spp=8", "--spectral=5", "-o", "a.exr", "--quiet"]);
    let view = View::new(&folder, &["a.exr"]);
    let (code, page) = view.gets("/");
    assert_eq!(code, 200);
    assert!(page == include_bytes!("../../src/cli/view/page.html"));
    let state = view.json("/state");
    assert_eq!((state["width"].as_u64(), state["done"].as_bool()), (Some(48), Some(true)));
    let picture = folder.picture("a.exr");
    for name in ["R", "error.R", "S0.595,000000nm", "samples"] {
        let (code, bytes) = view.gets(&format!("/channel?name={}", name.replace(',', "%2C")));
        assert_eq!((code, floats(&bytes).as_slice()), (200, picture.channel(name).expect("a channel")));
    }
    for pixel in [[0, 0], [47, 35], [20, 17]] {
        assert_is_pixel(&view, &folder, "a.exr", pixel);
    }
    // No file, named or not.
    for path in [
        "/a.exr",
        "/made.xml",
        "/../made.xml",
        "//etc/passwd",
        "/etc/passwd",
        "/%2e%2e/made.xml",
        "/channel?name=../made.xml",
        "/channel?name=%2e%2e%2fmade.xml",
        "/channel?file=made.xml",
        "/pixel?x=48&y=0",
        "/pixel?x=-1&y=0",
        "/pixel?x=0",
        "/state/..",
        "/page.html",
    ] {
        assert_eq!(view.gets(path), (404, Vec::new()), "{path}");
    }
    // Who comes by another name, or from another site, or wants to write.
    let port = view.port;
    let own = format!("Host: 127.0.0.1:{port}\r\n");
    assert_eq!(view.asks("GET", "/state", &own).0, 200);
    for headers in [
        String::new(),
        "Host: evil.example\r\n".to_owned(),
        format!("Host: evil.example:{port}\r\n"),
        format!("Host: 127.0.0.1:{}\r\n", port ^ 1),
        "Host: 127.0.0.1\r\n".to_owned(),
        format!("{own}Sec-Fetch-Site: cross-site\r\n"),
        format!("{own}Sec-Fetch-Site: same-site\r\n"),
    ] {
        for path in ["/", "/state", "/channel?name=R", "/pixel?x=0&y=0"] {
            assert_eq!(view.asks("GET", path, &headers), (403, Vec::new()), "{headers}");
        }
    }
    assert_eq!(view.asks("POST", "/state", &own).0, 405);
    // Other addresses of the machine lead nowhere.
    assert!(TcpStream::connect(("127.0.0.2", port)).is_err());
    assert_eq!(view.end().0, Some(0));
    let told = folder.ends(2, &["view", "a.exr", "--spp=4"]);
    assert!(told.contains("--spp: a.exr is shown as it is"), "{told}");
    let told = folder.ends(2, &["view", "made.exr"]);
    assert!(told.contains("cannot read made.exr"), "{told}");
    folder.write("bad.exr", "no picture");
    let told = folder.ends(2, &["view", "bad.exr"]);
    assert!(told.contains("cannot read bad.exr") && told.contains("help: expected an OpenEXR"), "{told}");
}

#[test]
fn a_page_shows_a_picture_in_the_making() {
    let folder = Folder::new("growing");
    folder.write("made.xml", SCENE);
    let render = |spp| ["made.xml", spp, "--spectral=5", "-o", "a.exr"];
    let view = View::new(&folder, &render("--spp=1000000"));
    let first = view.until(|state| state["width"].as_u64() == Some(48));
    let red = view.gets("/channel?name=R").1;
    assert_eq!(floats(&red).len(), 48 * 36);
    // The picture grows while it is rendered.
    view.until(|state| state["version"].as_u64() >= first["version"].as_u64().map(|version| version + 2));
    let later = view.json("/state");
    assert_eq!(later["done"].as_bool(), Some(false));
    assert!(view.gets("/channel?name=R").1 != red);
    // A pixel has its bins and their errors.
    let pixel: Vec<(String, Option<f32>)> =
        serde_json::from_value(view.json("/pixel?x=20&y=17")).expect("names and numbers");
    let value = |name: &str| pixel.iter().find(|(known, _)| known == name).and_then(|(_, value)| *value);
    assert!(value("S0.595,000000nm").is_some_and(|value| value > 0.0), "{pixel:?}");
    assert!(value("error.S0.595,000000nm").is_some(), "{pixel:?}");
    let (code, told) = view.end();
    assert_eq!(code, Some(3), "{told}");
    assert!(folder.exists("a.exr"), "{told}");

    // What is finished stays until it has been seen, as the file has it.
    let view = View::new(&folder, &render("--spp=16"));
    view.until(|state| state["done"].as_bool() == Some(true));
    assert_is_pixel(&view, &folder, "a.exr", [20, 17]);
    let (code, told) = view.end();
    assert_eq!(code, Some(0), "{told}");
}

/// What the page says of the pixel that it tells of: name, value and error as they were sent.
const TOLD: &str = "[...document.querySelectorAll('#values tr')]\
    .map(row => [row.dataset.name, +row.dataset.value, +row.dataset.error])";

#[test]
fn a_browser_shows_a_picture_in_the_making() {
    let Some(program) = browser::find() else {
        eprintln!("left out: no chromium on the PATH (validation/study/run installs one)");
        return;
    };
    let (folder, kept) = (Folder::new("browser"), Folder::kept("view-page"));
    folder.write("made.xml", SCENE);
    let arguments = ["made.xml", "--spp=1000000", "--time=6s", "--threads=1", "--spectral=5", "-o", "a.exr"];
    let view = View::new(&folder, &arguments);
    let url = format!("http://127.0.0.1:{}/", view.port);
    let mut tab = Tab::open(&program, &kept.path("profile"), &url);
    // It is drawn again and again while the render goes on, and the pixels of the screen change.
    let pixels = "image.getContext('2d').getImageData(0, 0, 48, 36).data.join()";
    tab.until("document.body && document.body.dataset.drawn >= 1");
    let first = tab.value(pixels);
    tab.until("drawn >= 4");
    assert_eq!(tab.value("document.body.dataset.done"), "false", "the render has ended too early");
    assert!(tab.value(pixels) != first);
    // The mouse is moved to the middle of a pixel.
    let place = tab.value(
        "(() => { const box = image.getBoundingClientRect(), edge = box.width / 48; \
         return [box.x + 20.5 * edge, box.y + 17.5 * edge] })()",
    );
    let place: [f64; 2] = serde_json::from_value(place).expect("two numbers");
    tab.point(place);
    tab.until("$('values').dataset.x === '20' && $('values').dataset.y === '17'");
    assert_eq!(tab.value(&format!("{TOLD}.filter(([name]) => isBin(name)).length")), 5);
    tab.keep(&kept.path("growing.png"));
    // Once it is done, what is told is what the file has, bit by bit.
    tab.until("document.body.dataset.done === 'true'");
    tab.until("$('values').dataset.version === String(state.version)");
    let picture = folder.picture("a.exr");
    let at = |name: &str| f64::from(picture.channel(name).expect("a channel")[17 * 48 + 20]);
    let told: Vec<(String, f64, Option<f64>)> =
        serde_json::from_value(tab.value(TOLD)).expect("names and numbers");
    let bins: Vec<_> = told.iter().filter(|(name, ..)| name.starts_with("S0.")).collect();
    assert_eq!(bins.len(), 5);
    for (name, value, error) in bins {
        assert_eq!((*value, *error), (at(name), Some(at(&format!("error.{name}")))), "{name}");
    }
    // Keys: the error instead of the colour, and more exposure.
    tab.press("e");
    // Errors are far smaller than colours, so they are exposed for longer.
    tab.until("$('channel').value === 'error of colour' && stops > 4");
    let before = tab.value("stops").as_f64().expect("a number");
    tab.press("+");
    assert_eq!(tab.value("stops").as_f64(), Some(before + 0.5));
    tab.press("ArrowRight");
    tab.until("$('values').dataset.x === '21'");
    tab.keep(&kept.path("done.png"));
    assert_eq!(view.end().0, Some(0));
}

/// The page reads only those channels of a spectral picture that are looked at: the 190 MB of all are never
/// held at once.
#[test]
#[cfg(target_os = "linux")]
fn a_large_picture_is_read_as_far_as_it_is_looked_at() {
    let folder = Folder::new("large");
    folder.write("made.xml", SCENE);
    let options = ["--size=640x480", "--spectral=72", "--spp=2", "--max-depth=1", "--no-png", "--quiet"];
    folder.ends(0, &[&["render", "made.xml", "-o", "a.exr"], &options[..]].concat());
    let view = View::new(&folder, &["a.exr"]);
    let picture = folder.picture("a.exr");
    let size = picture.channels.iter().map(|(_, values)| 4 * values.len()).sum::<usize>();
    assert!(size > 180_000_000, "{size}");
    // More channels than are kept, in two directions.
    let bins = picture.channels.iter().filter(|(name, _)| name.starts_with("S0."));
    let all: Vec<&(String, Vec<f32>)> = bins.collect();
    for (name, values) in all.iter().step_by(9).chain(all.iter().rev().step_by(20)) {
        let (code, bytes) = view.gets(&format!("/channel?name={}", name.replace(',', "%2C")));
        assert!(code == 200 && floats(&bytes) == *values, "{name}");
    }
    for [x, y] in [[0, 0], [639, 479], [200, 100], [201, 100], [200, 101]] {
        let told = view.json(&format!("/pixel?x={x}&y={y}"));
        let told: Vec<(String, f32)> = serde_json::from_value(told).expect("names and numbers");
        let own = picture.channels.iter().map(|(name, values)| (name.clone(), values[y * 640 + x]));
        assert!(told == own.collect::<Vec<_>>(), "{x}, {y}");
    }
    let status = std::fs::read_to_string(format!("/proc/{}/status", view.child.id())).expect("it runs");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.strip_suffix("kB"));
    let peak: usize = line.expect("a number").trim().parse().expect("a number");
    assert!(1024 * peak < size, "{} MiB", peak >> 10);
}
