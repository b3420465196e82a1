//! Serves the simulated robot in real time; only this module reads a clock.

use super::RobotLine;
use remote::link::{Tcp, Transport};
use socket2::{SockRef, TcpKeepalive};
use std::io;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// Interval of polls; the robot's time advances in between.
const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// An incomplete packet is discarded after this silence: half the client library's timeout.
const PACKET_TIMEOUT: Duration = Duration::from_millis(500);

/// Idle time before the first keep-alive probe, and between probes.
const PROBE_AFTER: Duration = Duration::from_secs(10);
const PROBE_EVERY: Duration = Duration::from_secs(5);

/// A host that acknowledges nothing for this long is disconnected.
#[cfg(target_os = "linux")]
const MAX_UNACKNOWLEDGED: Duration = Duration::from_secs(20);

/// A robot that lags behind by more than this skips the rest, s.
const MAX_LAG_S: u128 = 1;

/// Clock of the simulated time.
#[derive(Debug, Clone, Copy)]
pub struct SimClock {
    speed: u32,
    began: Instant,
    /// Simulated time that has passed, ms.
    passed_ms: u128,
}

impl SimClock {
    /// A clock that runs `speed` times as fast as real time.
    #[must_use]
    pub fn new(speed: u32, now: Instant) -> Self {
        Self {
            speed: speed.max(1),
            began: now,
            passed_ms: 0,
        }
    }

    /// Simulated time to advance until `now`, ms. An excessive lag is skipped.
    pub fn due_ms(&mut self, now: Instant) -> u32 {
        let speed = u128::from(self.speed);
        let real_ms = now.saturating_duration_since(self.began).as_millis();
        let due_ms = (real_ms * speed).saturating_sub(self.passed_ms);
        let max_ms = MAX_LAG_S * 1_000 * speed;
        self.passed_ms += due_ms;
        // At most a second at some thousand times real time.
        due_ms.min(max_ms) as u32
    }
}

/// Serves a robot.
#[derive(Debug)]
pub struct Server {
    line: RobotLine,
    clock: SimClock,
}

impl Server {
    /// Serves the robot of `line` at `speed` times real time.
    #[must_use]
    pub fn new(line: RobotLine, speed: u32) -> Self {
        Self {
            line,
            clock: SimClock::new(speed, Instant::now()),
        }
    }

    /// The robot's line.
    #[must_use]
    pub fn line(&self) -> &RobotLine {
        &self.line
    }

    /// Waits for a connection while the robot's time advances.
    ///
    /// # Errors
    /// When the greeting cannot be sent.
    pub fn accept(&mut self, listener: &TcpListener) -> io::Result<Tcp> {
        listener.set_nonblocking(true)?;
        loop {
            self.catch_up();
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    probe_when_idle(&stream)?;
                    let mut host = Tcp::new(stream)?;
                    // A host that does not read is disconnected.
                    host.set_send_timeout(PACKET_TIMEOUT)?;
                    self.line.reset();
                    self.line.greet();
                    return host.send(&self.line.take()).map(|()| host);
                }
                // No connection, or one that has already closed.
                Err(_) => std::thread::sleep(POLL_INTERVAL),
            }
        }
    }

    /// Serves a host until the transport fails; returns the error.
    pub fn serve(&mut self, host: &mut dyn Transport) -> io::Error {
        let mut buffer = [0; 1_024];
        let mut last_received = Instant::now();
        loop {
            let received = match host.receive(&mut buffer, POLL_INTERVAL) {
                Ok(count) => buffer.get(..count).unwrap_or(&[]),
                Err(error) => return error,
            };
            self.catch_up();
            if !received.is_empty() {
                last_received = Instant::now();
                self.line.receive(received);
            } else if last_received.elapsed() >= PACKET_TIMEOUT {
                self.line.idle();
            }
            let answers = self.line.take();
            if !answers.is_empty()
                && let Err(error) = host.send(&answers)
            {
                return error;
            }
        }
    }

    fn catch_up(&mut self) {
        let due_ms = self.clock.due_ms(Instant::now());
        self.line.advance(due_ms);
    }
}

/// Enables TCP keep-alive, which detects a host that vanishes without closing its connection. An
/// idle host answers the probes and stays.
fn probe_when_idle(stream: &TcpStream) -> io::Result<()> {
    let socket = SockRef::from(stream);
    let keepalive = TcpKeepalive::new()
        .with_time(PROBE_AFTER)
        .with_interval(PROBE_EVERY);
    // No probes are sent while an answer is unacknowledged; this bounds that time too.
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(MAX_UNACKNOWLEDGED))?;
    socket.set_tcp_keepalive(&keepalive)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robots_time_runs_at_the_set_speed_and_skips_an_excessive_lag() {
        let began = Instant::now();
        let at = |ms: u64| began + Duration::from_millis(ms);
        let mut clock = SimClock::new(20, began);
        assert_eq!(clock.due_ms(at(0)), 0);
        assert_eq!(clock.due_ms(at(3)), 60);
        assert_eq!(clock.due_ms(at(3)), 0);
        assert_eq!(clock.due_ms(at(10)), 140);
        // After a pause of a minute it advances by one second.
        assert_eq!(clock.due_ms(at(60_010)), 20_000);
        assert_eq!(clock.due_ms(at(60_011)), 20);
    }
}
