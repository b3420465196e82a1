//! Transports that carry bytes to and from a controller.

use super::LinkError;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Limit for opening a socket.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(5);

/// Limit for sending to a peer that does not read.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);

/// Carries bytes in order. The frames detect lost and damaged bytes.
pub trait Transport: Send {
    /// Sends all bytes.
    ///
    /// # Errors
    /// When the transport is broken.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// Waits for bytes and returns their number; 0 means a timeout.
    ///
    /// # Errors
    /// When the transport is broken or closed.
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize>;

    /// A short message about the other end's exit, if it has left one.
    fn exit_message(&mut self) -> Option<String> {
        None
    }
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        (**self).receive(buffer, timeout)
    }

    fn exit_message(&mut self) -> Option<String> {
        (**self).exit_message()
    }
}

/// A TCP connection.
#[derive(Debug)]
pub struct Tcp {
    stream: TcpStream,
    timeout: Duration,
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
            match TcpStream::connect_timeout(&address, CONNECT_TIMEOUT) {
                Ok(stream) => return Self::new(stream).map_err(refuse),
                Err(error) => last = error,
            }
        }
        Err(refuse(last))
    }

    /// Wraps an open connection.
    ///
    /// # Errors
    /// When the system refuses its options.
    pub fn new(stream: TcpStream) -> io::Result<Self> {
        // Without this, a small frame waits 40 ms for the acknowledgment of the one before.
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(SEND_TIMEOUT))?;
        Ok(Self {
            stream,
            timeout: Duration::ZERO,
        })
    }

    /// Replaces the send timeout of 10 s.
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

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        // Zero would mean no timeout.
        let timeout = timeout.max(Duration::from_millis(1));
        if timeout != self.timeout {
            self.stream.set_read_timeout(Some(timeout))?;
            self.timeout = timeout;
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
        // Discards bytes that arrived before.
        port.discard_input_buffer().map_err(refuse)?;
        Ok(Self { port })
    }
}

impl Transport for Serial {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.port.write_all(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.port
            .set_read_timeout(timeout.max(Duration::from_millis(1)))?;
        received(|| self.port.read(buffer))
    }
}

/// Reads once. A timeout is 0 bytes; a closed connection is an error.
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
