//! A simulated Nomad 200 started as a program, and helpers for its clients.

use crate::Program;
use nomad200::{Host, NomadReadings};
use remote::link::{Serial, Tcp};
use std::io::{BufRead as _, BufReader, ErrorKind, Read, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Timeout of all waits.
pub const TIMEOUT: Duration = Duration::from_secs(30);

/// A program that runs in parallel to the test; killed when dropped.
#[derive(Debug)]
pub struct Running {
    child: Child,
    stdout: Receiver<String>,
    stderr: Receiver<String>,
}

impl Running {
    /// Starts `program` with the words of `line`.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start(program: &Program, line: &str) -> Self {
        let mut child = program
            .command(&crate::words(line))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let stdout = lines(child.stdout.take().expect("its output"));
        let stderr = lines(child.stderr.take().expect("its messages"));
        Self {
            child,
            stdout,
            stderr,
        }
    }

    /// The next line of its output.
    ///
    /// # Panics
    /// When there is none in time.
    #[must_use]
    pub fn line(&self) -> String {
        let line = self.stdout.recv_timeout(TIMEOUT);
        line.unwrap_or_else(|_| panic!("no line; {:?}", self.messages()))
    }

    /// Its messages on standard error so far.
    #[must_use]
    pub fn messages(&self) -> Vec<String> {
        self.stderr.try_iter().collect()
    }

    /// Kills it.
    pub fn kill(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Interrupts it as Ctrl-C does.
    ///
    /// # Panics
    /// When there is no shell.
    pub fn interrupt(&self) {
        let kill = format!("kill -INT {}", self.child.id());
        let status = Command::new("sh").args(["-c", &kill]).status();
        assert!(status.is_ok_and(|status| status.success()));
    }

    /// Waits for its end: exit code, the rest of its output, its messages.
    ///
    /// # Panics
    /// When it does not end in time.
    #[must_use]
    pub fn end(&mut self, patience: Duration) -> (Option<i32>, String, String) {
        let until = Instant::now() + patience;
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("its state") {
                break status;
            }
            assert!(
                Instant::now() < until,
                "it does not end: {:?}",
                self.messages()
            );
            std::thread::sleep(Duration::from_millis(5));
        };
        let rest = |stream: &Receiver<String>| {
            let mut text = String::new();
            loop {
                match stream.recv_timeout(TIMEOUT) {
                    Ok(line) => text += &(line + "\n"),
                    Err(RecvTimeoutError::Disconnected) => return text,
                    Err(RecvTimeoutError::Timeout) => panic!("its output does not end"),
                }
            }
        };
        (status.code(), rest(&self.stdout), rest(&self.stderr))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.kill();
    }
}

/// The lines of a stream as they arrive.
fn lines(stream: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    receiver
}

/// A running simulated robot.
#[derive(Debug)]
pub struct ServedRobot {
    /// The program.
    pub program: Running,
    /// Its address: `HOST:PORT`, or a device.
    pub place: String,
}

impl ServedRobot {
    /// Starts it at a free port, with more flags.
    #[must_use]
    pub fn at_a_port(program: &Program, flags: &str) -> Self {
        Self::start(program, &format!("--listen 127.0.0.1:0 {flags}"))
    }

    /// Starts it at a serial port, with more flags.
    #[must_use]
    pub fn at_a_pty(program: &Program, flags: &str) -> Self {
        Self::start(program, &format!("--pty {flags}"))
    }

    fn start(program: &Program, flags: &str) -> Self {
        let program = Running::start(program, &format!("nomad serve {flags}"));
        let line = program.line();
        let place = line.strip_prefix("listening on ");
        let place = place.unwrap_or_else(|| panic!("{line}")).to_owned();
        Self { program, place }
    }

    /// Connects as a program for the robot does.
    ///
    /// # Panics
    /// When the connection fails or the greeting is missing.
    #[must_use]
    pub fn connect(&self) -> Host {
        let line = Tcp::open(&self.place).unwrap_or_else(|error| panic!("{error}"));
        Host::with_greeting(line).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Opens its serial port.
    ///
    /// # Panics
    /// When that fails.
    #[must_use]
    pub fn open(&self, baud: u32) -> Host {
        let line = Serial::open(&self.place, baud).unwrap_or_else(|error| panic!("{error}"));
        Host::new(line)
    }
}

/// Whether the base stands still.
#[must_use]
pub fn stands(state: &NomadReadings) -> bool {
    state.motors == 0 && state.velocity == [0; 3]
}

/// Mode of a proxy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ProxyMode {
    /// Forwards everything in both directions.
    Open,
    /// Discards everything.
    Mute,
    /// Closes the connection.
    Off,
}

/// A TCP proxy that can be interrupted.
#[derive(Debug)]
pub struct Proxy {
    /// Its address, as `HOST:PORT`.
    pub place: String,
    line: Arc<AtomicU8>,
    /// Bytes to insert into the stream to the server.
    own: Arc<Mutex<Vec<u8>>>,
}

impl Proxy {
    /// A proxy to `host`, for the first client that connects.
    ///
    /// # Panics
    /// When there is no socket.
    #[must_use]
    pub fn to(host: &str) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a socket");
        let place = listener.local_addr().expect("its address").to_string();
        let line = Arc::new(AtomicU8::new(ProxyMode::Open as u8));
        let own = Arc::new(Mutex::new(Vec::new()));
        let nothing = Arc::default();
        let (cut, there, host) = (Arc::clone(&line), Arc::clone(&own), host.to_owned());
        std::thread::spawn(move || {
            let Ok((near, _)) = listener.accept() else {
                return;
            };
            let far = TcpStream::connect(host).expect("whoever listens");
            for (from, to, own) in [(&near, &far, there), (&far, &near, nothing)] {
                let ends = (from.try_clone(), to.try_clone());
                let cut = Arc::clone(&cut);
                if let (Ok(from), Ok(to)) = ends {
                    std::thread::spawn(move || carry(from, to, &cut, &own));
                }
            }
        });
        Self { place, line, own }
    }

    /// Inserts bytes into the stream to the server.
    pub fn say(&self, bytes: &[u8]) {
        let mut own = self.own.lock().unwrap_or_else(PoisonError::into_inner);
        own.extend_from_slice(bytes);
    }

    /// Switches the mode.
    pub fn switch(&self, line: ProxyMode) {
        self.line.store(line as u8, Ordering::Relaxed);
    }
}

fn carry(mut from: TcpStream, mut to: TcpStream, cut: &AtomicU8, own: &Mutex<Vec<u8>>) {
    let _ = (from.set_nodelay(true), to.set_nodelay(true));
    let _ = from.set_read_timeout(Some(Duration::from_millis(20)));
    let mut buffer = [0; 1_024];
    loop {
        let count = match from.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(_) => break,
        };
        let line = cut.load(Ordering::Relaxed);
        if line == ProxyMode::Off as u8 {
            break;
        }
        let own = std::mem::take(&mut *own.lock().unwrap_or_else(PoisonError::into_inner));
        let said = [&buffer[..count], &own].concat();
        if line == ProxyMode::Open as u8 && to.write_all(&said).is_err() {
            break;
        }
    }
    let _ = to.shutdown(Shutdown::Both);
    let _ = from.shutdown(Shutdown::Both);
}
