//! The picture in the making, in tev (<https://github.com/Tom94/tev>): packets of its network protocol, as
//! its README has them.

use abbe::film::Film;
use abbe::output::Colour;
use std::io::{Result, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

/// How long a viewer may keep the render waiting.
const PATIENCE: Duration = Duration::from_secs(5);

/// Shortest time between two pictures.
const PAUSE: Duration = Duration::from_secs(2);

/// The kinds of packets.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// A picture that tev shows.
pub struct Tev {
    stream: TcpStream,
    name: String,
    is_created: bool,
    last: Option<Instant>,
}

impl Tev {
    /// Connects to a viewer at HOST:PORT.
    pub fn new(address: &str, name: &str) -> Result<Self> {
        let mut failed = std::io::Error::other("the name has no address");
        for address in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE))?;
                    return Ok(Self { stream, name: name.to_owned(), is_created: false, last: None });
                }
                Err(error) => failed = error,
            }
        }
        Err(failed)
    }

    /// Whether it is time for another picture.
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() >= PAUSE)
    }

    /// Shows what a film holds.
    pub fn show(&mut self, film: &Film) -> Result<()> {
        let size = film.extent.shown.size;
        let channels = Colour::Rec709.channels();
        if !self.is_created {
            self.stream.write_all(&created(&self.name, size, channels.iter().map(|&(name, _)| name)))?;
            self.is_created = true;
        }
        for &(name, weights) in channels {
            let value = |(x, y)| film.combined(x, y, weights).mean as f32;
            let values: Vec<f32> = film.shown().map(value).collect();
            self.stream.write_all(&updated(&self.name, size, name, &values))?;
        }
        self.last = Some(Instant::now());
        Ok(())
    }
}

/// A packet: its length with these four bytes, its kind, and what it says.
fn packet(kind: u8, content: &[u8]) -> Vec<u8> {
    let length = (content.len() + 5) as u32;
    [&length.to_le_bytes(), &[kind][..], content].concat()
}

fn text(text: &str) -> Vec<u8> {
    text.bytes().filter(|&byte| byte != 0).chain([0]).collect()
}

/// A black picture that the viewer turns to.
fn created<'a>(name: &str, size: [u32; 2], channels: impl ExactSizeIterator<Item = &'a str>) -> Vec<u8> {
    let mut content = vec![1];
    content.extend(text(name));
    content.extend(size.into_iter().chain([channels.len() as u32]).flat_map(u32::to_le_bytes));
    content.extend(channels.flat_map(text));
    packet(CREATE_IMAGE, &content)
}

/// All values of a channel, row by row from the top.
fn updated(name: &str, size: [u32; 2], channel: &str, values: &[f32]) -> Vec<u8> {
    let mut content = vec![0];
    content.extend(text(name));
    content.extend(1u32.to_le_bytes());
    content.extend(text(channel));
    content.extend([0, 0].into_iter().chain(size).flat_map(u32::to_le_bytes));
    // Where its values begin, and how far they are apart.
    content.extend([0u64, 1].into_iter().flat_map(u64::to_le_bytes));
    content.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    packet(UPDATE_IMAGE, &content)
}
