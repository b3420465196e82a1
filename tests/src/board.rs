//! The emulated chip as a board behind a TCP socket, which can be switched off and on.

use crate::chip::{TIMEOUT, image};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A chip behind a TCP socket; stopped when dropped.
#[derive(Debug)]
pub struct EmulatedBoard {
    host: String,
    emulator: Option<Child>,
}

impl EmulatedBoard {
    /// A chip that has just been switched on.
    ///
    /// # Panics
    /// When there is no socket or no emulator.
    #[must_use]
    pub fn start() -> Self {
        let free = TcpListener::bind(("127.0.0.1", 0)).and_then(|listener| listener.local_addr());
        let mut board = Self {
            host: free.expect("a socket").to_string(),
            emulator: None,
        };
        board.switch_on();
        board
    }

    /// Its address, as `HOST:PORT`.
    #[must_use]
    pub fn host(&self) -> &str {
        &self.host
    }

    /// Switches it on and waits until it can be reached.
    ///
    /// # Panics
    /// When it cannot.
    pub fn switch_on(&mut self) {
        let serial = format!("tcp:{},server=on,wait=off,nodelay=on", self.host);
        let spawned = Command::new("qemu-system-arm")
            .args(["-M", "netduinoplus2", "-nographic", "-monitor", "none"])
            .arg("-kernel")
            .arg(image())
            .args(["-serial", &serial])
            .args(["-semihosting-config", "enable=on,target=native"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn();
        self.emulator = Some(spawned.expect("qemu-system-arm starts"));
        let began = Instant::now();
        while TcpStream::connect(&self.host).is_err() {
            assert!(began.elapsed() < TIMEOUT, "the emulator does not listen");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Switches it off at once.
    pub fn switch_off(&mut self) {
        if let Some(mut emulator) = self.emulator.take() {
            // It may have ended already.
            let _ = emulator.kill();
            let _ = emulator.wait();
        }
    }
}

impl Drop for EmulatedBoard {
    fn drop(&mut self) {
        self.switch_off();
    }
}
