//! Runs the firmware in an emulator, as a child process.

use super::{LinkError, Machine, Tcp, Transport};
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Limit for the start of the emulator.
const START_TIMEOUT: Duration = Duration::from_secs(10);

/// Limit for its exit after its end of the socket has closed.
const EXIT_TIMEOUT: Duration = Duration::from_millis(500);

/// Poll interval while it starts or ends.
const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// Maximum size of the stored tail of its standard error.
const MAX_STDERR_BYTES: usize = 4_096;

/// Kills a process when this script's standard input closes, however this process ends.
const KILL_SCRIPT: &str = "read -r _; kill -KILL \"$1\" 2>/dev/null";

/// A running emulator. It ends when this is dropped or this process ends.
pub struct Qemu {
    process: KillOnDrop,
    line: Tcp,
    stderr_tail: StderrTail,
}

/// The tail of the child's standard error.
type StderrTail = Arc<Mutex<String>>;

/// A child, and a watcher that kills it when this process cannot.
struct KillOnDrop {
    child: Child,
    watcher: Option<Child>,
    emulator: &'static str,
}

impl Qemu {
    /// Starts an image on a machine; with `verbose` its standard error is copied to ours.
    ///
    /// # Errors
    /// [`LinkError::Open`] without the image or the emulator, or when it ends at once.
    pub fn start(machine: &Machine, image: &Path, verbose: bool) -> Result<Self, LinkError> {
        if !image.is_file() {
            let image = image.display();
            return Err(open_error(format!("{image}: there is no such image")));
        }
        let emulator = machine.emulator;
        let no_socket = |error: io::Error| open_error(format!("no socket for {emulator}: {error}"));
        let listener = TcpListener::bind(("127.0.0.1", 0)).map_err(no_socket)?;
        let port = listener.local_addr().map_err(no_socket)?.port();
        let mut process = KillOnDrop::spawn(machine, image, port)?;
        let stderr_tail = process.capture_stderr(verbose);
        let stream = process.accept(&listener, &stderr_tail)?;
        let line = Tcp::new(stream).map_err(no_socket)?;
        Ok(Self {
            process,
            line,
            stderr_tail,
        })
    }

    /// Tail of the standard error of the emulator, and of the firmware's semihosting log.
    #[must_use]
    pub fn stderr(&self) -> String {
        text(&self.stderr_tail)
    }

    /// Process number of the emulator.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.child.id()
    }
}

impl Transport for Qemu {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.line.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        self.line.receive(buffer, timeout)
    }

    fn exit_message(&mut self) -> Option<String> {
        let until = Instant::now() + EXIT_TIMEOUT;
        loop {
            if let Some(status) = self.process.child.try_wait().ok()? {
                return Some(ended(
                    self.process.emulator,
                    status,
                    &text(&self.stderr_tail),
                ));
            }
            if Instant::now() >= until {
                return None;
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

impl KillOnDrop {
    fn spawn(machine: &Machine, image: &Path, port: u16) -> Result<Self, LinkError> {
        let emulator = machine.emulator;
        let spawned = Command::new(emulator)
            .args(machine.arguments)
            .args(["-nographic", "-monitor", "none", "-kernel"])
            .arg(image)
            .arg("-chardev")
            .arg(format!(
                "socket,id=link,host=127.0.0.1,port={port},nodelay=on"
            ))
            .args(["-serial", "chardev:link"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .stdin(Stdio::null())
            // Standard output is for results.
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        match spawned {
            Ok(child) => Ok(Self {
                watcher: spawn_watcher(child.id()),
                child,
                emulator,
            }),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(open_error(format!(
                "{emulator} is not installed: apt-get install {}",
                machine.install
            ))),
            Err(error) => Err(open_error(format!("{emulator} cannot be started: {error}"))),
        }
    }

    /// Reads the child's standard error and stores the tail.
    fn capture_stderr(&mut self, verbose: bool) -> StderrTail {
        let stderr_tail = StderrTail::default();
        if let Some(stderr) = self.child.stderr.take() {
            let copy = Arc::clone(&stderr_tail);
            std::thread::spawn(move || copy_lines(stderr, &copy, verbose));
        }
        stderr_tail
    }

    /// Waits until the emulator has connected.
    fn accept(
        &mut self,
        listener: &TcpListener,
        stderr_tail: &StderrTail,
    ) -> Result<TcpStream, LinkError> {
        let emulator = self.emulator;
        let failed =
            |error: io::Error| open_error(format!("{emulator} cannot be reached: {error}"));
        listener.set_nonblocking(true).map_err(failed)?;
        let until = Instant::now() + START_TIMEOUT;
        while Instant::now() < until {
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false).map_err(failed)?;
                    return Ok(stream);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(failed(error)),
            }
            if let Some(status) = self.child.try_wait().map_err(failed)? {
                return Err(open_error(ended(emulator, status, &text(stderr_tail))));
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Err(open_error(format!(
            "{emulator} has not started within {} s",
            START_TIMEOUT.as_secs()
        )))
    }
}

impl Drop for KillOnDrop {
    fn drop(&mut self) {
        // The watcher ends first: later the child's number may belong to another process.
        let children = self.watcher.iter_mut().chain([&mut self.child]);
        for child in children {
            // The child may already have ended.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Starts the watcher. Without a shell a child may outlive a killed parent.
fn spawn_watcher(id: u32) -> Option<Child> {
    Command::new("sh")
        .args(["-c", KILL_SCRIPT, "watch"])
        .arg(id.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()
}

fn copy_lines(stderr: impl Read, stderr_tail: &StderrTail, verbose: bool) {
    let mut lines = BufReader::new(stderr);
    let mut line = Vec::new();
    while lines
        .read_until(b'\n', &mut line)
        .is_ok_and(|count| count > 0)
    {
        let text = String::from_utf8_lossy(&line);
        if verbose {
            eprint!("{text}");
        }
        let mut stderr_tail = stderr_tail.lock().unwrap_or_else(PoisonError::into_inner);
        stderr_tail.push_str(&text);
        let mut surplus = stderr_tail.len().saturating_sub(MAX_STDERR_BYTES);
        while !stderr_tail.is_char_boundary(surplus) {
            surplus += 1;
        }
        stderr_tail.drain(..surplus);
        line.clear();
    }
}

fn text(stderr_tail: &StderrTail) -> String {
    stderr_tail
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .trim_end()
        .to_owned()
}

fn ended(emulator: &str, status: std::process::ExitStatus, stderr_tail: &str) -> String {
    // After its own message the emulator prints the registers.
    let own = stderr_tail.lines().rfind(|line| line.starts_with("qemu"));
    let last = own.or_else(|| stderr_tail.lines().last());
    format!(
        "{emulator} has ended ({status}): {}",
        last.unwrap_or("it printed nothing")
    )
}

fn open_error(why: String) -> LinkError {
    LinkError::Open { why }
}
