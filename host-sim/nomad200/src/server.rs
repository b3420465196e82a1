//! The simulated robot on a real line and by a real clock: the only part of it that knows one.

use super::Line;
use remote::link::{Tcp, Transport};
use socket2::{SockRef, TcpKeepalive};
use std::io;
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

/// Longest wait for a byte: the robot's time goes on in between.
const GLANCE: Duration = Duration::from_millis(2);

/// After so long a silence an unfinished packet is given up: half of what the client library waits for an answer.
const SILENCE: Duration = Duration::from_millis(500);

/// Idle time before the first keep-alive probe, and between the next ones.
const PROBE_AFTER: Duration = Duration::from_secs(10);
const PROBE_EVERY: Duration = Duration::from_secs(5);

/// A host that acknowledges neither an answer nor a probe for so long is gone.
#[cfg(target_os = "linux")]
const MAX_UNACKNOWLEDGED: Duration = Duration::from_secs(20);

/// A robot that has fallen behind the clock by more than this catches up no more, s.
const MAX_LAG_S: u128 = 1;

/// How fast the robot's time runs.
#[derive(Debug, Clone, Copy)]
pub struct Pace {
    speed: u32,
    began: Instant,
    /// Robot's time that has passed, ms.
    lived_ms: u128,
}

impl Pace {
    /// So many times real time, from now on.
    #[must_use]
    pub fn new(speed: u32, now: Instant) -> Self {
        Self {
            speed: speed.max(1),
            began: now,
            lived_ms: 0,
        }
    }

    /// Robot's time to let pass until `now`, ms. What it is too late for is left out.
    pub fn due_ms(&mut self, now: Instant) -> u32 {
        let speed = u128::from(self.speed);
        let real_ms = now.saturating_duration_since(self.began).as_millis();
        let due_ms = (real_ms * speed).saturating_sub(self.lived_ms);
        let most_ms = MAX_LAG_S * 1_000 * speed;
        self.lived_ms += due_ms;
        // At most a second at some thousand times real time.
        due_ms.min(most_ms) as u32
    }
}

/// A robot that is served.
#[derive(Debug)]
pub struct Server {
    line: Line,
    pace: Pace,
}

impl Server {
    /// Serves the robot of `line` at so many times real time.
    #[must_use]
    pub fn new(line: Line, speed: u32) -> Self {
        Self {
            line,
            pace: Pace::new(speed, Instant::now()),
        }
    }

    /// The robot's line.
    #[must_use]
    pub fn line(&self) -> &Line {
        &self.line
    }

    /// Waits for the next one to connect; the robot lives on meanwhile.
    ///
    /// # Errors
    /// When whoever came is gone before the greeting.
    pub fn accept(&mut self, listener: &TcpListener) -> io::Result<Tcp> {
        listener.set_nonblocking(true)?;
        loop {
            self.live();
            match listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    probe_when_idle(&stream)?;
                    let mut host = Tcp::new(stream)?;
                    // A host that reads no answers is disconnected.
                    host.set_send_timeout(SILENCE)?;
                    self.line.renew();
                    self.line.greet();
                    return host.send(&self.line.take()).map(|()| host);
                }
                // Nobody is there, or gone again.
                Err(_) => std::thread::sleep(GLANCE),
            }
        }
    }

    /// Speaks with a host until it is gone; returns how it went.
    pub fn speak(&mut self, host: &mut dyn Transport) -> io::Error {
        let mut buffer = [0; 1_024];
        let mut heard = Instant::now();
        loop {
            let received = match host.receive(&mut buffer, GLANCE) {
                Ok(count) => buffer.get(..count).unwrap_or(&[]),
                Err(error) => return error,
            };
            self.live();
            if !received.is_empty() {
                heard = Instant::now();
                self.line.receive(received);
            } else if heard.elapsed() >= SILENCE {
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

    fn live(&mut self) {
        let due_ms = self.pace.due_ms(Instant::now());
        self.line.advance(due_ms);
    }
}

/// Enables TCP keep-alive: a host that vanishes without closing its connection is found out. An idle host answers the
/// probes and stays.
fn probe_when_idle(stream: &TcpStream) -> io::Result<()> {
    let socket = SockRef::from(stream);
    let keepalive = TcpKeepalive::new()
        .with_time(PROBE_AFTER)
        .with_interval(PROBE_EVERY);
    // Probes are not sent while an answer is not acknowledged: this bounds that, and the probes as well.
    #[cfg(target_os = "linux")]
    socket.set_tcp_user_timeout(Some(MAX_UNACKNOWLEDGED))?;
    socket.set_tcp_keepalive(&keepalive)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robots_time_runs_as_fast_as_it_is_told_and_skips_what_it_missed() {
        let began = Instant::now();
        let at = |ms: u64| began + Duration::from_millis(ms);
        let mut pace = Pace::new(20, began);
        assert_eq!(pace.due_ms(at(0)), 0);
        assert_eq!(pace.due_ms(at(3)), 60);
        assert_eq!(pace.due_ms(at(3)), 0);
        assert_eq!(pace.due_ms(at(10)), 140);
        // Stopped for a minute, it lives one second of it.
        assert_eq!(pace.due_ms(at(60_010)), 20_000);
        assert_eq!(pace.due_ms(at(60_011)), 20);
    }
}
