//! A pseudo terminal with a controller at its other end: a serial line for any program.

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

/// Fault of the line from the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineFault {
    /// No fault.
    Good,
    /// Starts with the end of a frame, then is good.
    StartsInTheMiddle,
    /// Wrong baud rate: other bytes arrive.
    WrongSpeed,
    /// Disconnected after this many bytes.
    PulledAfter(usize),
}

/// A serial line with a controller at its end.
#[derive(Debug)]
pub struct FaultyPty {
    /// The device's path.
    pub path: PathBuf,
    /// Keeps the device open between clients.
    _device: Option<OwnedFd>,
}

impl FaultyPty {
    /// A line to the server at `host`.
    ///
    /// # Panics
    /// When there is no pseudo terminal or no server.
    #[must_use]
    pub fn to(host: &str, line: LineFault) -> Self {
        let pair = openpty(None, None).expect("a pseudo terminal");
        let mut raw = tcgetattr(&pair.slave).expect("its settings");
        cfmakeraw(&mut raw);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &raw).expect("raw bytes");
        let path = ttyname(&pair.slave).expect("its name");
        let mind = TcpStream::connect(host).expect("the mind");
        pump(File::from(pair.master), mind, line);
        let keeps = !matches!(line, LineFault::PulledAfter(_));
        // A device that must disappear is not held open here; the program opens it before its first
        // byte.
        let device = keeps.then_some(pair.slave);
        Self {
            path,
            _device: device,
        }
    }
}

/// Forwards bytes in both directions until one side closes or the line is disconnected.
fn pump(device: File, controller: TcpStream, line: LineFault) {
    let carried = Arc::new(AtomicUsize::new(0));
    let from_program = device.try_clone().expect("a second handle");
    let to_controller = controller.try_clone().expect("a second handle");
    let seen = Arc::clone(&carried);
    std::thread::spawn(move || forward(from_program, to_controller, line, &seen));
    std::thread::spawn(move || forward_back(controller, device, line, &carried));
}

/// Forwards the program's bytes; waits until the program has opened the device.
fn forward(
    mut from_program: File,
    mut to_controller: TcpStream,
    line: LineFault,
    carried: &AtomicUsize,
) {
    let mut buffer = [0; 256];
    loop {
        match from_program.read(&mut buffer) {
            Ok(count) if count > 0 && !is_pulled(line, carried) => {
                if to_controller.write_all(&buffer[..count]).is_err() {
                    break;
                }
            }
            // The device is not open yet.
            Err(error) if error.raw_os_error() == Some(5) && !is_pulled(line, carried) => {
                std::thread::sleep(std::time::Duration::from_millis(5));
            }
            _ => break,
        }
    }
    let _ = to_controller.shutdown(std::net::Shutdown::Both);
}

/// Forwards the controller's bytes with the line's fault, and counts them.
fn forward_back(
    mut from_controller: TcpStream,
    mut to_program: File,
    line: LineFault,
    carried: &AtomicUsize,
) {
    if line == LineFault::StartsInTheMiddle {
        let _ = to_program.write_all(&[0x11, 0x22, 0x33, 0]);
    }
    let mut buffer = [0; 64];
    while let Ok(count) = from_controller.read(&mut buffer) {
        if count == 0 || is_pulled(line, carried) {
            break;
        }
        carried.fetch_add(count, Ordering::Relaxed);
        let bytes = garbled(&buffer[..count], line);
        if to_program.write_all(&bytes).is_err() {
            break;
        }
    }
}

fn is_pulled(line: LineFault, carried: &AtomicUsize) -> bool {
    matches!(line, LineFault::PulledAfter(bytes) if carried.load(Ordering::Relaxed) >= bytes)
}

/// A line read at twice its baud rate makes two wrong bytes of one.
fn garbled(bytes: &[u8], line: LineFault) -> Vec<u8> {
    if line != LineFault::WrongSpeed {
        return bytes.to_vec();
    }
    let halves = |byte: &u8| [byte & 0x0f | 0x80, byte >> 4 | 0xc0];
    bytes.iter().flat_map(halves).collect()
}
