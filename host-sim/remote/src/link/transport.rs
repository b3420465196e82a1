//! Bytes to and from a mind.

use super::LinkError;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// How long opening a socket may take.
const OPENING: Duration = Duration::from_secs(5);

/// A peer that takes no byte for so long is given up.
const MAX_SEND: Duration = Duration::from_secs(10);

/// Carries bytes, in order; what is lost or damaged on the way is the frames' affair.
pub trait Transport: Send {
    /// Sends all bytes.
    ///
    /// # Errors
    /// When the way is broken.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits for bytes and returns how many there are: 0 only after nothing has come for as long as `patience`.
    ///
    /// # Errors
    /// When the way is broken or was closed from the other end.
    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize>;

    /// What the other end left behind when it went, in a few words for a person.
    fn last_words(&mut self) -> Option<String> {
        None
    }
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        (**self).receive(buffer, patience)
    }

    fn last_words(&mut self) -> Option<String> {
        (**self).last_words()
    }
}

/// A TCP connection.
#[derive(Debug)]
pub struct Tcp {
    stream: TcpStream,
    patience: Duration,
}

impl Tcp {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// [`LinkError::Open`].
    pub fn open(host: &str) -> Result<Self, LinkError> {
        let refuse = |error: io::Error| LinkError::Open {
            why: format!("tcp:{host} cannot be reached: {error}"),
        };
        let mut last = io::Error::new(ErrorKind::NotFound, "the name has no address");
        for address in host.to_socket_addrs().map_err(refuse)? {
            match TcpStream::connect_timeout(&address, OPENING) {
                Ok(stream) => return Self::new(stream).map_err(refuse),
                Err(error) => last = error,
            }
        }
        Err(refuse(last))
    }

    /// Takes over a connection.
    ///
    /// # Errors
    /// When the system refuses its options.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        // A small frame must not wait for the acknowledgement of the one before: 40 ms.
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(MAX_SEND))?;
        Ok(Self {
            stream,
            patience: Duration::ZERO,
        })
    }

    /// Gives the peer up when it takes no byte for this time, instead of 10 s.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn set_send_timeout(&mut self, timeout: Duration) -> io::Result<()> {
        self.stream.set_write_timeout(Some(timeout))
    }
}

impl Transport for Tcp {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let sent = self.stream.write_all(bytes);
        sent.map_err(|error| match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                io::Error::new(ErrorKind::TimedOut, "the other end takes no bytes")
            }
            _ => error,
        })
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        // Zero would mean: for ever.
        let patience = patience.max(Duration::from_millis(1));
        if patience != self.patience {
            self.stream.set_read_timeout(Some(patience))?;
            self.patience = patience;
        }
        received(|| self.stream.read(buffer))
    }
}

/// A serial port: 8 data bits, no parity, one stop bit, no flow control.
pub struct Serial {
    port: serial2::SerialPort,
}

impl Serial {
    /// Opens a port at `baud`.
    ///
    /// # Errors
    /// [`LinkError::Open`].
    pub fn open(path: &str, baud: u32) -> Result<Self, LinkError> {
        let refuse = |error: io::Error| {
            let hint = match error.kind() {
                ErrorKind::PermissionDenied => " (on Linux: be in the group dialout)",
                _ => "",
            };
            LinkError::Open {
                why: format!("serial:{path} cannot be opened: {error}{hint}"),
            }
        };
        let port = serial2::SerialPort::open(path, baud).map_err(refuse)?;
        // What came before is nobody's answer.
        port.discard_input_buffer().map_err(refuse)?;
        Ok(Self { port })
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.port
            .set_read_timeout(patience.max(Duration::from_millis(1)))?;
        received(|| self.port.read(buffer))
    }
}

/// Reads once; no bytes in time are 0, no bytes at all an error.
fn received(mut read: impl FnMut() -> io::Result<usize>) -> io::Result<usize> {
    loop {
        return match read() {
            Ok(0) => Err(io::Error::new(
                ErrorKind::UnexpectedEof,
                "the other end closed it",
            )),
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Ok(0)
            }
            other => other,
        };
    }
}
