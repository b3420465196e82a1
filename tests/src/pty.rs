//! A mind at the other end of a pseudo terminal: a serial line as far as any program can see.

use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use nix::unistd::ttyname;
use std::fs::File;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::fd::OwnedFd;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the line does to the bytes from the mind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Nothing.
    Good,
    /// Begins with the end of a frame whose beginning nobody heard, then is good.
    StartsInTheMiddle,
    /// Runs at another speed: what arrives is something else.
    WrongSpeed,
    /// Is pulled out after so many bytes.
    PulledAfter(usize),
}

/// A serial line with a mind at its end.
#[derive(Debug)]
pub struct Pty {
    /// The device's path.
    pub path: PathBuf,
    /// Keeps the device there while nobody has it open.
    _device: Option<OwnedFd>,
}

impl Pty {
    /// A line to whatever listens at `host`.
    ///
    /// # Panics
    /// When there is no pseudo terminal or no listener.
    #[must_use]
    pub fn to(host: &str, line: Line) -> Self {
        let pair = openpty(None, None).expect("a pseudo terminal");
        let mut raw = tcgetattr(&pair.slave).expect("its settings");
        cfmakeraw(&mut raw);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &raw).expect("raw bytes");
        let path = ttyname(&pair.slave).expect("its name");
        let mind = TcpStream::connect(host).expect("the mind");
        pump(File::from(pair.master), mind, line);
        let keeps = !matches!(line, Line::PulledAfter(_));
        // A device that is to disappear must not be held here; the program opens it before its first byte comes.
        let device = keeps.then_some(pair.slave);
        Self {
            path,
            _device: device,
        }
    }
}

/// Carries bytes both ways until one side is gone or the line is pulled out.
fn pump(device: File, mind: TcpStream, line: Line) {
    let carried = Arc::new(AtomicUsize::new(0));
    let (mut from_program, mut to_mind) = (
        device.try_clone().expect("a second handle"),
        mind.try_clone().expect("a second handle"),
    );
    let seen = Arc::clone(&carried);
    std::thread::spawn(move || {
        let mut buffer = [0; 256];
        loop {
            match from_program.read(&mut buffer) {
                Ok(count) if count > 0 && !is_pulled(line, &seen) => {
                    if to_mind.write_all(&buffer[..count]).is_err() {
                        break;
                    }
                }
                // Nobody has the device open yet.
                Err(error) if error.raw_os_error() == Some(5) && !is_pulled(line, &seen) => {
                    std::thread::sleep(std::time::Duration::from_millis(5));
                }
                _ => break,
            }
        }
        let _ = to_mind.shutdown(std::net::Shutdown::Both);
    });
    std::thread::spawn(move || {
        let (mut device, mut mind) = (device, mind);
        if line == Line::StartsInTheMiddle {
            let _ = device.write_all(&[0x11, 0x22, 0x33, 0]);
        }
        let mut buffer = [0; 64];
        while let Ok(count) = mind.read(&mut buffer) {
            if count == 0 || is_pulled(line, &carried) {
                break;
            }
            carried.fetch_add(count, Ordering::Relaxed);
            let bytes = garbled(&buffer[..count], line);
            if device.write_all(&bytes).is_err() {
                break;
            }
        }
    });
}

fn is_pulled(line: Line, carried: &AtomicUsize) -> bool {
    matches!(line, Line::PulledAfter(bytes) if carried.load(Ordering::Relaxed) >= bytes)
}

/// A line read at twice its speed makes two bytes of one, and neither is it.
fn garbled(bytes: &[u8], line: Line) -> Vec<u8> {
    if line != Line::WrongSpeed {
        return bytes.to_vec();
    }
    let halves = |byte: &u8| [byte & 0x0f | 0x80, byte >> 4 | 0xc0];
    bytes.iter().flat_map(halves).collect()
}
