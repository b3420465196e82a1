//! A node in this process behind a link: the same code as on the chip.

use super::Transport;
use amp::body::{Body, HeldRing};
use amp::config::Config;
use amp::node::{FrameSink, Identity, Node};
use amp::som::Grid;
use amp::units::Millis;
use amp::wire::Receiver;
use amp::wire::message::FlashError;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Period of ticks, milliseconds.
const TICK_MS: u32 = 10;

/// A node as a [`Transport`]. Its clock advances only during a wait, and a wait takes no real time,
/// so results are repeatable.
pub struct InProcessNode<const SENSORS: usize = 16, B = HeldRing> {
    node: Box<Node<SENSORS, 16, 100, B>>,
    receiver: Receiver,
    outgoing: Outgoing,
    now: Millis,
}

struct Outgoing(VecDeque<u8>);

impl FrameSink for Outgoing {
    fn send(&mut self, frame: &[u8]) -> bool {
        self.0.extend(frame);
        true
    }
}

impl<const SENSORS: usize> InProcessNode<SENSORS> {
    /// A node that has just started.
    #[must_use]
    pub fn new(config: Config<SENSORS>) -> Self {
        Self::of_body(config)
    }
}

impl<const SENSORS: usize, B: Body<SENSORS>> InProcessNode<SENSORS, B> {
    /// A node that has just started, for a robot with any body.
    #[must_use]
    pub fn of_body(config: Config<SENSORS>) -> Self {
        Self::with_identity(config, Identity::default())
    }

    fn with_identity(config: Config<SENSORS>, identity: Identity) -> Self {
        let mut local = Self {
            node: Box::new(Node::new()),
            receiver: Receiver::new(),
            outgoing: Outgoing(VecDeque::new()),
            now: Millis::from_ms(0),
        };
        local.node.start(
            &config,
            Grid::rectangle(4, 4),
            identity,
            local.now,
            &mut local.outgoing,
        );
        local
    }

    /// The node.
    #[must_use]
    pub fn node(&self) -> &Node<SENSORS, 16, 100, B> {
        &self.node
    }

    /// Resets the node; its time continues.
    pub fn restart(&mut self, config: Config<SENSORS>) {
        let now = self.now;
        *self = Self::of_body(config);
        self.now = now;
    }

    fn receive_bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if let Some(frame) = self.receiver.push(byte) {
                self.node.frame(self.now, frame, &mut self.outgoing);
                // A process has no flash.
                let absent = Err(FlashError::NoFlash);
                self.node.flash_done(absent, self.now, &mut self.outgoing);
            }
        }
    }

    /// Runs the node until it sends something or is idle.
    fn run(&mut self) {
        while self.node.tick(self.now, &mut self.outgoing) && self.outgoing.0.is_empty() {}
    }
}

impl<const SENSORS: usize, B: Body<SENSORS> + Send> Transport for InProcessNode<SENSORS, B> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.receive_bytes(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        let end = self.now.as_ms().wrapping_add(timeout.as_millis() as u32);
        while self.outgoing.0.is_empty() {
            self.run();
            let left = Millis::from_ms(end).since(self.now);
            if !self.outgoing.0.is_empty() || left == 0 {
                break;
            }
            self.now = Millis::from_ms(self.now.as_ms().wrapping_add(TICK_MS.min(left)));
        }
        self.outgoing.0.read(buffer)
    }
}

/// A node behind a TCP socket of this machine, for one connection at a time, in real time. Dropping
/// it stops it.
pub struct NodeServer {
    address: SocketAddr,
    is_stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl NodeServer {
    /// Starts a node with a configuration.
    ///
    /// # Errors
    /// When there is no socket.
    pub fn start(config: Config<16>) -> io::Result<Self> {
        Self::with_identity(config, Identity::default())
    }

    /// As [`start`](Self::start), with a ring of its own that never receives an echo.
    ///
    /// # Errors
    /// When there is no socket.
    pub fn with_ring(config: Config<16>) -> io::Result<Self> {
        let identity = Identity {
            ring: true,
            ..Identity::default()
        };
        Self::with_identity(config, identity)
    }

    fn with_identity(config: Config<16>, identity: Identity) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", 0))?;
        let address = listener.local_addr()?;
        let is_stopped = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&is_stopped);
        let thread = std::thread::spawn(move || {
            let (mut local, began) = (
                InProcessNode::with_identity(config, identity),
                Instant::now(),
            );
            for stream in listener.incoming() {
                if stop.load(Ordering::Relaxed) {
                    break;
                }
                // After a lost connection the next one is accepted.
                let _ = stream.and_then(|stream| serve(&mut local, began, &stream, &stop));
            }
        });
        Ok(Self {
            address,
            is_stopped,
            thread: Some(thread),
        })
    }

    /// Its address, as `HOST:PORT`.
    #[must_use]
    pub fn host(&self) -> String {
        self.address.to_string()
    }
}

impl Drop for NodeServer {
    fn drop(&mut self) {
        self.is_stopped.store(true, Ordering::Relaxed);
        // Wakes the thread, which waits for a connection.
        let _ = TcpStream::connect(self.address);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(
    local: &mut InProcessNode,
    began: Instant,
    mut stream: &TcpStream,
    stop: &AtomicBool,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(Duration::from_millis(u64::from(TICK_MS))))?;
    let mut buffer = [0; 1_024];
    while !stop.load(Ordering::Relaxed) {
        let received = match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => 0,
            Err(error) => return Err(error),
        };
        local.now = Millis::from_ms(began.elapsed().as_millis() as u32);
        local.receive_bytes(buffer.get(..received).unwrap_or(&[]));
        local.run();
        let (head, tail) = local.outgoing.0.as_slices();
        stream.write_all(head)?;
        stream.write_all(tail)?;
        local.outgoing.0.clear();
    }
    Ok(())
}
