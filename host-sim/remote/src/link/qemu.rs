//! The firmware in an emulated chip, as a child of this process.

use super::{LinkError, Machine, Tcp, Transport};
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long the emulator may take to start.
const STARTING: Duration = Duration::from_secs(10);

/// How long it may take to end after its end of the line has gone.
const ENDING: Duration = Duration::from_millis(500);

/// Time between two looks at it while it starts or ends.
const GLANCE: Duration = Duration::from_millis(2);

/// Most bytes kept of what the emulator said.
const MAX_KEPT: usize = 4_096;

/// Kills a process as soon as its own standard input ends, which it does however this process ends.
const WATCH: &str = "read -r _; kill -KILL \"$1\" 2>/dev/null";

/// A running emulator. Ends when dropped, or when this process ends.
pub struct Qemu {
    process: KillOnDrop,
    line: Tcp,
    said: Said,
}

/// What was said on standard error.
type Said = Arc<Mutex<String>>;

/// A child and whoever ends it when we cannot.
struct KillOnDrop {
    child: Child,
    watcher: Option<Child>,
    emulator: &'static str,
}

impl Qemu {
    /// Starts the image on a machine; with `verbose`, what the emulator says goes to standard error as well.
    ///
    /// # Errors
    /// [`LinkError::Open`] without the image or the emulator, or when it ends at once.
    pub fn start(machine: &Machine, image: &Path, verbose: bool) -> Result<Self, LinkError> {
        if !image.is_file() {
            let image = image.display();
            return Err(refused(format!("{image}: there is no such image")));
        }
        let emulator = machine.emulator;
        let no_socket = |error: io::Error| refused(format!("no socket for {emulator}: {error}"));
        let listener = TcpListener::bind(("127.0.0.1", 0)).map_err(no_socket)?;
        let port = listener.local_addr().map_err(no_socket)?.port();
        let mut process = KillOnDrop::spawn(machine, image, port)?;
        let said = process.overhear(verbose);
        let stream = process.accept(&listener, &said)?;
        let line = Tcp::new(stream).map_err(no_socket)?;
        Ok(Self {
            process,
            line,
            said,
        })
    }

    /// What the emulator and, by semihosting, the firmware have said on standard error; the end of it.
    #[must_use]
    pub fn said(&self) -> String {
        text(&self.said)
    }

    /// The emulator's process number.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.process.child.id()
    }
}

impl Transport for Qemu {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.line.send(bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        self.line.receive(buffer, patience)
    }

    fn last_words(&mut self) -> Option<String> {
        let until = Instant::now() + ENDING;
        loop {
            if let Some(status) = self.process.child.try_wait().ok()? {
                return Some(ended(self.process.emulator, status, &text(&self.said)));
            }
            if Instant::now() >= until {
                return None;
            }
            std::thread::sleep(GLANCE);
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
                watcher: watch(child.id()),
                child,
                emulator,
            }),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(refused(format!(
                "{emulator} is not installed: apt-get install {}",
                machine.install
            ))),
            Err(error) => Err(refused(format!("{emulator} cannot be started: {error}"))),
        }
    }

    /// Keeps the end of what the child says on standard error.
    fn overhear(&mut self, verbose: bool) -> Said {
        let said = Said::default();
        if let Some(stderr) = self.child.stderr.take() {
            let keeper = Arc::clone(&said);
            std::thread::spawn(move || keep(stderr, &keeper, verbose));
        }
        said
    }

    /// Waits until the emulator has connected to its end of the line.
    fn accept(&mut self, listener: &TcpListener, said: &Said) -> Result<TcpStream, LinkError> {
        let emulator = self.emulator;
        let failed = |error: io::Error| refused(format!("{emulator} cannot be reached: {error}"));
        listener.set_nonblocking(true).map_err(failed)?;
        let until = Instant::now() + STARTING;
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
                return Err(refused(ended(emulator, status, &text(said))));
            }
            std::thread::sleep(GLANCE);
        }
        Err(refused(format!(
            "{emulator} has not started within {} s",
            STARTING.as_secs()
        )))
    }
}

impl Drop for KillOnDrop {
    fn drop(&mut self) {
        // First the watcher: afterwards the number may be another process's.
        let children = self.watcher.iter_mut().chain([&mut self.child]);
        for child in children {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Starts the child's watcher. Where there is no shell, a child may outlive us if we are killed.
fn watch(id: u32) -> Option<Child> {
    Command::new("sh")
        .args(["-c", WATCH, "watch"])
        .arg(id.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .ok()
}

fn keep(stderr: impl Read, said: &Said, verbose: bool) {
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
        let mut said = said.lock().unwrap_or_else(PoisonError::into_inner);
        said.push_str(&text);
        let mut surplus = said.len().saturating_sub(MAX_KEPT);
        while !said.is_char_boundary(surplus) {
            surplus += 1;
        }
        said.drain(..surplus);
        line.clear();
    }
}

fn text(said: &Said) -> String {
    said.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .trim_end()
        .to_owned()
}

fn ended(emulator: &str, status: std::process::ExitStatus, said: &str) -> String {
    // After a complaint of its own come the processor's registers.
    let own = said.lines().rfind(|line| line.starts_with("qemu"));
    let last = own.or_else(|| said.lines().last());
    format!(
        "{emulator} has ended ({status}): {}",
        last.unwrap_or("it said nothing")
    )
}

fn refused(why: String) -> LinkError {
    LinkError::Open { why }
}
