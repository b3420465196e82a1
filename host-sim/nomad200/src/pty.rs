//! A pseudo terminal: a serial port for other programs, at any speed.

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

/// Buffered chunks in each direction. More is lost, as on a serial line.
const MAX_CHUNKS: usize = 64;

/// The controlling end of a pseudo terminal.
#[derive(Debug)]
pub struct PseudoTerminal {
    path: PathBuf,
    /// Keeps the device present while no program has it open.
    _device: OwnedFd,
    from_host: Receiver<Vec<u8>>,
    to_host: SyncSender<Vec<u8>>,
    /// Bytes that were read and not returned yet.
    unread: Vec<u8>,
}

impl PseudoTerminal {
    /// Opens a pseudo terminal.
    ///
    /// # Errors
    /// When the system has none.
    pub fn open() -> io::Result<Self> {
        let pair = openpty(None, None)?;
        let mut raw = tcgetattr(&pair.slave)?;
        cfmakeraw(&mut raw);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &raw)?;
        let path = ttyname(&pair.slave)?;
        let reader = File::from(pair.master);
        let writer = reader.try_clone()?;
        let (received, from_host) = sync_channel(MAX_CHUNKS);
        let (to_host, to_send) = sync_channel(MAX_CHUNKS);
        std::thread::spawn(move || read(reader, &received));
        std::thread::spawn(move || write(writer, &to_send));
        Ok(Self {
            path,
            _device: pair.slave,
            from_host,
            to_host,
            unread: Vec::new(),
        })
    }

    /// Path of the device for the host.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }
}

fn read(mut device: File, received: &SyncSender<Vec<u8>>) {
    let mut buffer = [0; 1_024];
    while let Ok(count) = device.read(&mut buffer) {
        let chunk = buffer.get(..count).unwrap_or(&[]).to_vec();
        if count == 0 || received.send(chunk).is_err() {
            break;
        }
    }
}

fn write(mut device: File, to_send: &Receiver<Vec<u8>>) {
    while let Ok(chunk) = to_send.recv() {
        if device.write_all(&chunk).is_err() {
            break;
        }
    }
}

fn closed() -> io::Error {
    io::Error::new(io::ErrorKind::BrokenPipe, "the pseudo terminal is gone")
}

impl Transport for PseudoTerminal {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self.to_host.try_send(bytes.to_vec()) {
            Err(std::sync::mpsc::TrySendError::Disconnected(_)) => Err(closed()),
            // Lost if no program reads.
            _ => Ok(()),
        }
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if self.unread.is_empty() {
            self.unread = match self.from_host.recv_timeout(timeout) {
                Ok(chunk) => chunk,
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => return Err(closed()),
            };
        }
        let count = self.unread.len().min(buffer.len());
        let taken: Vec<_> = self.unread.drain(..count).collect();
        buffer
            .iter_mut()
            .zip(&taken)
            .for_each(|(to, from)| *to = *from);
        Ok(count)
    }
}
