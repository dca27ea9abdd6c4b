//! A folder for the files of one test, in which the program is run.

use abbe::output::exr::{self, Channels};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// A folder of a test's own, empty at first.
pub struct Folder {
    path: PathBuf,
    is_kept: bool,
}

impl Folder {
    /// Among the system's temporary files, removed when it is dropped.
    pub fn new(name: &str) -> Self {
        // Tests of one process run side by side, and several processes too.
        static MADE: AtomicU32 = AtomicU32::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("abbe-{name}-{}-{number}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder for temporary files");
        Self { path, is_kept: false }
    }

    /// Among the files of the build, to be looked at afterwards.
    pub fn kept(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        // There is none before the first time.
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder can be made");
        Self { path, is_kept: true }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// The names of what is in it, sorted.
    pub fn files(&self) -> Vec<String> {
        let names = std::fs::read_dir(&self.path).expect("the folder exists");
        let mut names: Vec<String> =
            names.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    pub fn exists(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("a file can be written");
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).expect("it is text")
    }

    pub fn picture(&self, name: &str) -> Channels {
        exr::read(&self.path(name)).expect("a readable picture")
    }

    /// The program, about to run in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_abbe"));
        command.args(arguments).current_dir(&self.path).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the program starts")
    }

    /// Runs a command that must end with this code; what it says on standard error.
    #[track_caller]
    pub fn ends(&self, code: i32, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        let told = stderr(&output);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {told}");
        told
    }

    /// Runs a command that must succeed. The most memory that it held, bytes.
    #[cfg(target_os = "linux")]
    #[track_caller]
    pub fn peak_memory(&self, arguments: &[&str]) -> u64 {
        let mut child = self.command(arguments).spawn().expect("the program starts");
        let status = format!("/proc/{}/status", child.id());
        let mut peak = 0;
        // Asked while it runs: what the system tells afterwards counts what was this process's before the
        // program began, too.
        while child.try_wait().expect("it can be waited for").is_none() {
            let told = std::fs::read_to_string(&status).unwrap_or_default();
            let line = told.lines().find_map(|line| line.strip_prefix("VmHWM:")?.strip_suffix("kB"));
            peak = peak.max(line.and_then(|number| number.trim().parse().ok()).unwrap_or(0));
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        assert!(child.wait().expect("it ends").success(), "{arguments:?}");
        assert!(peak > 0, "{arguments:?}");
        1024 * peak
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !self.is_kept {
            // Whatever is left over lies among the system's temporary files.
            let _ = std::fs::remove_dir_all(&self.path);
        }
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The path of a file of the repository, for the program's arguments.
pub fn of_repository(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}
