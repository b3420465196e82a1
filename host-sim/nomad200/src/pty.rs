//! A pseudo terminal: a serial port as far as any program can see, at any speed.

use nix::pty::openpty;
use nix::sys::termios::{SetArg, cfmakeraw, tcgetattr, tcsetattr};
use nix::unistd::ttyname;
use remote::link::Transport;
use std::fs::File;
use std::io::{self, Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// Pieces in the air in each direction. What nobody reads is lost, as on a serial line.
const MAX_PIECES: usize = 64;

/// Our end of a pseudo terminal.
#[derive(Debug)]
pub struct Pty {
    path: PathBuf,
    /// Keeps the device there while nobody has it open.
    _device: OwnedFd,
    from_host: Receiver<Vec<u8>>,
    to_host: SyncSender<Vec<u8>>,
    /// Read and not yet handed on.
    left: Vec<u8>,
}

impl Pty {
    /// Opens a pair.
    ///
    /// # Errors
    /// When there is none to be had.
    pub fn open() -> io::Result<Self> {
        let pair = openpty(None, None)?;
        let mut raw = tcgetattr(&pair.slave)?;
        cfmakeraw(&mut raw);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &raw)?;
        let path = ttyname(&pair.slave)?;
        let reader = File::from(pair.master);
        let writer = reader.try_clone()?;
        let (heard, from_host) = sync_channel(MAX_PIECES);
        let (to_host, said) = sync_channel(MAX_PIECES);
        std::thread::spawn(move || read(reader, &heard));
        std::thread::spawn(move || write(writer, &said));
        Ok(Self {
            path,
            _device: pair.slave,
            from_host,
            to_host,
            left: Vec::new(),
        })
    }

    /// The device a host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn read(mut device: File, heard: &SyncSender<Vec<u8>>) {
    let mut buffer = [0; 1_024];
    while let Ok(count) = device.read(&mut buffer) {
        let piece = buffer.get(..count).unwrap_or(&[]).to_vec();
        if count == 0 || heard.send(piece).is_err() {
            break;
        }
    }
}

fn write(mut device: File, said: &Receiver<Vec<u8>>) {
    while let Ok(piece) = said.recv() {
        if device.write_all(&piece).is_err() {
            break;
        }
    }
}

fn gone() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "the pseudo terminal is gone")
}

impl Transport for Pty {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self.to_host.try_send(bytes.to_vec()) {
            Err(std::sync::mpsc::TrySendError::Disconnected(_)) => Err(gone()),
            // Nobody reads: lost.
            _ => Ok(()),
        }
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.left.is_empty() {
            self.left = match self.from_host.recv_timeout(patience) {
                Ok(piece) => piece,
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            };
        }
        let count = self.left.len().min(buffer.len());
        let taken: Vec<_> = self.left.drain(..count).collect();
        buffer
            .iter_mut()
            .zip(&taken)
            .for_each(|(to, from)| *to = *from);
        Ok(count)
    }
}
