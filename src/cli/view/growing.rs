//! What the page shows: a file, or what a render has done so far.

use abbe::film::{Film, Quantity};
use abbe::output::Colour;
use abbe::output::exr::{Channels, Stored};
use abbe::render::Work;
use serde_json::{Value, json};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Shortest time between two pictures.
const PAUSE: Duration = Duration::from_millis(500);

/// Largest fraction of the time that pictures take, as one over it.
const RARELY: u32 = 20;

/// A page that has not asked for so long is closed.
const SILENCE: Duration = Duration::from_secs(10);

/// A picture and its viewers.
pub struct Page {
    title: String,
    shown: Mutex<Shown>,
    /// Whether [`Shown::questions`] has any: asked after each piece of work.
    is_asked: AtomicBool,
}

struct Shown {
    picture: Arc<Seen>,
    /// How many pictures there were before it.
    version: u64,
    progress: f64,
    is_done: bool,
    /// Pixels of the film whose spectrum a viewer asks for.
    questions: Vec<([u32; 2], Sender<Value>)>,
    /// When the page last asked for anything.
    heard: Option<Instant>,
    /// When the next picture is due.
    next: Instant,
}

/// What there is to see.
enum Seen {
    /// Channels of a render under way.
    Growing(Channels),
    /// A file, read as far as it is asked for.
    Stored(Stored),
}

/// What is looked at first, and so is read on one way through a file.
const COLOURS: [&str; 8] = ["R", "G", "B", "A", "error.R", "error.G", "error.B", "samples"];

impl Seen {
    fn size(&self) -> [usize; 2] {
        match self {
            Self::Growing(picture) => [picture.width, picture.height],
            Self::Stored(picture) => [picture.width, picture.height],
        }
    }

    fn names(&self) -> Vec<&str> {
        match self {
            Self::Growing(picture) => picture.channels.iter().map(|(name, _)| name.as_str()).collect(),
            Self::Stored(picture) => picture.names().iter().map(String::as_str).collect(),
        }
    }

    /// The values of a channel as little-endian 32-bit floats.
    fn channel(&self, name: &str) -> std::io::Result<Option<Vec<u8>>> {
        let bytes = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
        match self {
            Self::Growing(picture) => Ok(picture.channel(name).map(bytes)),
            Self::Stored(picture) => {
                // A bin is looked at with its error.
                let error = format!("error.{name}");
                let likely = if COLOURS.contains(&name) { &COLOURS[..] } else { &[error.as_str()][..] };
                Ok(picture.channel(name, likely)?.map(|values| bytes(&values)))
            }
        }
    }
}

impl Page {
    pub fn new(title: &str) -> Self {
        let shown = Shown {
            picture: Arc::new(Seen::Growing(Channels::default())),
            version: 0,
            progress: 0.0,
            is_done: false,
            questions: Vec::new(),
            heard: None,
            next: Instant::now(),
        };
        Self { title: title.to_owned(), shown: Mutex::new(shown), is_asked: AtomicBool::new(false) }
    }

    fn shown(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether [`Self::show`] has anything to do.
    pub fn is_due(&self) -> bool {
        if self.is_asked.load(Ordering::Relaxed) {
            return true;
        }
        let shown = self.shown();
        shown.heard.is_some_and(|heard| heard.elapsed() < SILENCE) && Instant::now() >= shown.next
    }

    /// Answers what is asked of the film, and shows it where it is time for that.
    pub fn show(&self, work: &Work, progress: f64) {
        let film = work.film();
        let (questions, is_time) = {
            let mut shown = self.shown();
            self.is_asked.store(false, Ordering::Relaxed);
            (std::mem::take(&mut shown.questions), Instant::now() >= shown.next)
        };
        for (pixel, answer) in questions {
            // Who asked may have gone.
            let _ = answer.send(told_of_film(film, pixel));
        }
        if is_time {
            let began = Instant::now();
            let picture = Arc::new(Seen::Growing(colours(film)));
            let mut shown = self.shown();
            shown.picture = picture;
            shown.version += 1;
            shown.progress = progress;
            shown.next = Instant::now() + PAUSE.max(began.elapsed() * RARELY);
        }
    }

    /// Nothing more comes. What is shown from now on, if it is not the last that was.
    pub fn finished(&self, picture: Option<Stored>) {
        let mut shown = self.shown();
        if let Some(picture) = picture {
            shown.picture = Arc::new(Seen::Stored(picture));
            shown.version += 1;
        }
        (shown.is_done, shown.progress) = (true, 1.0);
        // Who still waits is told nothing, and asks again.
        shown.questions.clear();
    }

    /// What there is to see.
    pub fn state(&self) -> Value {
        let mut shown = self.shown();
        shown.heard = Some(Instant::now());
        let [width, height] = shown.picture.size();
        json!({
            "title": self.title,
            "width": width,
            "height": height,
            "version": shown.version,
            "progress": shown.progress,
            "done": shown.is_done,
            "channels": shown.picture.names(),
        })
    }

    /// The values of a channel as little-endian 32-bit floats, row by row from the top; `None` where there is
    /// no such channel.
    ///
    /// # Errors
    /// Where the file that is shown can't be read any more.
    pub fn channel(&self, name: &str) -> std::io::Result<Option<Vec<u8>>> {
        let picture = self.shown().picture.clone();
        picture.channel(name)
    }

    /// All channels of a pixel: at once where they are known, else as soon as the render can tell them.
    /// `None` outside of the picture.
    ///
    /// # Errors
    /// As of [`Self::channel`].
    pub fn pixel(&self, pixel @ [x, y]: [u32; 2]) -> std::io::Result<Option<Receiver<Value>>> {
        let mut shown = self.shown();
        let [width, height] = shown.picture.size();
        if x as usize >= width || y as usize >= height {
            return Ok(None);
        }
        let (answer, answered) = channel();
        if shown.is_done {
            let picture = shown.picture.clone();
            drop(shown);
            let place = pixel.map(|x| x as usize);
            let values: Vec<f32> = match &*picture {
                Seen::Growing(picture) => {
                    let index = place[1] * width + place[0];
                    picture.channels.iter().map(|(_, values)| values[index]).collect()
                }
                Seen::Stored(picture) => picture.pixel(place)?,
            };
            let names = picture.names().into_iter().map(str::to_owned);
            // It is received below.
            let _ = answer.send(told(names.zip(values)));
        } else {
            shown.questions.push((pixel, answer));
            self.is_asked.store(true, Ordering::Relaxed);
        }
        Ok(Some(answered))
    }
}

fn told(values: impl Iterator<Item = (String, f32)>) -> Value {
    values.map(|(name, value)| json!([name, value])).collect()
}

/// What there is of a film to look at: colours, their errors as the pixel's own replicates tell them, and
/// samples.
fn colours(film: &Film) -> Channels {
    let mut channels: Vec<(String, Vec<f32>)> = Vec::new();
    for &(name, weights) in Colour::Rec709.channels() {
        let measured = film.shown().map(|(x, y)| film.combined(x, y, weights));
        let (means, errors): (Vec<f32>, Vec<f32>) =
            measured.map(|measured| (measured.mean as f32, measured.error as f32)).unzip();
        channels.push((name.to_owned(), means));
        channels.push((format!("error.{name}"), errors));
    }
    let samples = film.shown().map(|(x, y)| film.samples(x, y) as f32);
    channels.push(("samples".to_owned(), samples.collect()));
    let [width, height] = film.extent.shown.size.map(|size| size as usize);
    Channels { width, height, channels, ..Channels::default() }
}

/// All of a pixel, by the names that the file will have.
fn told_of_film(film: &Film, [x, y]: [u32; 2]) -> Value {
    let (shown, measured) = (film.extent.shown, film.extent.measured);
    let [x, y] = [0, 1].map(|axis| [x, y][axis] + shown.offset[axis] - measured.offset[axis]);
    let colours = Colour::Rec709.channels().iter();
    let colours = colours.map(|&(name, weights)| (name.to_owned(), Quantity::Combined(weights)));
    let bins = film.extras.bins.into_iter().flat_map(|bins| {
        (0..bins.count)
            .map(move |bin| (abbe::output::exr::spectral_channel(bins.centre(bin)), Quantity::Bin(bin)))
    });
    let both = colours.chain(bins).flat_map(|(name, quantity)| {
        let found = film.measured(x, y, quantity);
        let error = (format!("error.{name}"), found.error as f32);
        [(name, found.mean as f32), error]
    });
    told(both.chain([("samples".to_owned(), film.samples(x, y) as f32)]))
}
