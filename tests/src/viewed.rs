//! A running `host-sim view`, and viewers without a browser.

use crate::{Program, words};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, ErrorKind};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::handshake::HandshakeError;
use tungstenite::http::HeaderValue;
use tungstenite::{Error, Message, WebSocket};

const TIMEOUT: Duration = Duration::from_secs(30);

/// The program as a server; ended when dropped.
pub struct Viewed {
    child: Child,
    /// Address of the page for watching.
    pub watch: String,
    /// Address of the page for watching and steering.
    pub steer: String,
}

impl Viewed {
    /// Starts `host-sim view` at a free port.
    ///
    /// # Panics
    /// When it does not start or prints anything but two addresses.
    #[must_use]
    pub fn start(program: &Program, flags: &str) -> Self {
        let line = format!("view --listen 127.0.0.1:0 {flags}");
        Self::spawn(program.command(&words(&line)))
    }

    /// As [`start`](Self::start), in a process with at most `files` open files and sockets.
    ///
    /// # Panics
    /// As [`start`](Self::start).
    #[must_use]
    pub fn start_with_files(program: &Program, files: u32, flags: &str) -> Self {
        let line = format!("view --listen 127.0.0.1:0 {flags}");
        let own = program.command(&words(&line));
        let mut shell = Command::new("sh");
        let limited = format!("ulimit -n {files} && exec \"$0\" \"$@\"");
        shell.args(["-c", &limited]).arg(own.get_program());
        shell.args(own.get_args()).current_dir(program.folder());
        Self::spawn(shell)
    }

    fn spawn(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let mut lines = BufReader::new(child.stdout.take().expect("its output")).lines();
        let mut address = || {
            let line = lines.next().expect("an address").expect("text");
            line.split_whitespace()
                .last()
                .expect("an address")
                .to_owned()
        };
        let (steer, watch) = (address(), address());
        Self {
            child,
            watch,
            steer,
        }
    }

    /// Ends it as Ctrl-C does; returns its exit code.
    ///
    /// # Panics
    /// When it does not end.
    #[must_use]
    pub fn end(mut self) -> Option<i32> {
        let kill = format!("kill -INT {}", self.child.id());
        let status = Command::new("sh").args(["-c", &kill]).status();
        assert!(status.is_ok_and(|status| status.success()));
        let began = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("its state") {
                return status.code();
            }
            assert!(began.elapsed() < TIMEOUT, "it goes on");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Kills it.
    pub fn kill(self) {
        drop(self);
    }

    /// HOST:PORT.
    ///
    /// # Panics
    /// When the address has none.
    #[must_use]
    pub fn host(&self) -> &str {
        let host = self.watch.strip_prefix("http://");
        host.and_then(|host| host.strip_suffix('/'))
            .expect("an address")
    }

    /// The token.
    ///
    /// # Panics
    /// When the address has none.
    #[must_use]
    pub fn token(&self) -> &str {
        self.steer.split_once("#token=").expect("a token").1
    }

    /// Connects with these headers instead of the default ones; a refusal returns its HTTP status.
    ///
    /// # Panics
    /// When there is no answer.
    pub fn knock(&self, headers: &[(&'static str, &str)]) -> Result<Viewer, u16> {
        self.knock_at("/socket", headers)
    }

    /// As [`knock`](Self::knock), at another path.
    ///
    /// # Panics
    /// When there is no answer.
    pub fn knock_at(&self, path: &str, headers: &[(&'static str, &str)]) -> Result<Viewer, u16> {
        let mut request = format!("ws://{}{path}", self.host())
            .into_client_request()
            .expect("an address");
        for (name, value) in headers {
            let value = HeaderValue::from_str(value).expect("a header");
            request.headers_mut().insert(*name, value);
        }
        let stream = TcpStream::connect(self.host()).expect("it listens");
        stream.set_read_timeout(Some(TIMEOUT)).expect("a timeout");
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Viewer::new(socket)),
            Err(HandshakeError::Failure(Error::Http(response))) => Err(response.status().as_u16()),
            Err(other) => panic!("{other}"),
        }
    }

    /// A viewer that only watches.
    ///
    /// # Panics
    /// When it is refused.
    #[must_use]
    pub fn viewer(&self) -> Viewer {
        self.knock(&[]).expect("a viewer is accepted")
    }

    /// A page opened with the token, before it steers.
    ///
    /// # Errors
    /// The HTTP status of a refusal.
    pub fn owner(&self) -> Result<Viewer, u16> {
        self.knock_at(&format!("/socket?token={}", self.token()), &[])
    }

    /// A viewer that steers.
    ///
    /// # Panics
    /// When it is refused.
    #[must_use]
    pub fn steerer(&self) -> Viewer {
        let mut viewer = self.owner().expect("an owner is accepted");
        let order = json!({"do": "steer", "token": self.token()});
        viewer.order(order).expect("the seat");
        viewer
    }
}

impl Drop for Viewed {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A viewer without a browser.
pub struct Viewer {
    socket: WebSocket<TcpStream>,
    asked: u64,
    /// Number of messages received.
    heard: u64,
    /// The latest value of each part, and the number of its message.
    seen: BTreeMap<String, (u64, Value)>,
}

impl Viewer {
    fn new(socket: WebSocket<TcpStream>) -> Self {
        Self {
            socket,
            asked: 0,
            heard: 0,
            seen: BTreeMap::new(),
        }
    }

    /// Receives the next message.
    fn hear(&mut self) -> Value {
        loop {
            let message = match self.socket.read() {
                // A stopped and resumed process reads again.
                Err(Error::Io(error)) if error.kind() == ErrorKind::Interrupted => continue,
                message => message.expect("a message"),
            };
            if let Message::Text(text) = message {
                let message: Value = serde_json::from_str(&text).expect("JSON");
                self.heard += 1;
                if let Some(part) = message["part"].as_str() {
                    let seen = (self.heard, message["value"].clone());
                    self.seen.insert(part.to_owned(), seen);
                }
                return message;
            }
        }
    }

    /// Sends a command without waiting.
    ///
    /// # Panics
    /// When the socket is closed.
    pub fn send(&mut self, mut order: Value) -> u64 {
        self.asked += 1;
        order["id"] = json!(self.asked);
        let sent = self.socket.send(Message::text(order.to_string()));
        sent.expect("the server is there");
        self.asked
    }

    /// Sends a command; returns its answer.
    ///
    /// # Errors
    /// The refusal.
    pub fn order(&mut self, order: Value) -> Result<Value, String> {
        let id = self.send(order);
        loop {
            let message = self.hear();
            if message["reply"] == id {
                return match message["error"].as_str() {
                    Some(why) => Err(why.to_owned()),
                    None => Ok(message),
                };
            }
        }
    }

    /// The latest value of a part; waits for the first one.
    ///
    /// # Panics
    /// When it does not arrive in time.
    pub fn latest(&mut self, part: &str) -> Value {
        self.wait(part, |_| true);
        self.seen[part].1.clone()
    }

    /// Explores, learns and waits for the maps.
    ///
    /// # Panics
    /// When a command is refused.
    pub fn explore_and_learn(&mut self, moves: u64) {
        let moment = self.moment();
        self.order(json!({"do": "explore"})).expect("it explores");
        let explored = self.wait_after(moment, "memory", |rows| {
            rows.as_array()
                .is_some_and(|rows| rows.len() as u64 == moves)
        });
        self.wait_after(explored, "now", is_idle);
        let moment = self.moment();
        self.order(json!({"do": "learn"})).expect("it learns");
        let learned = self.wait_after(moment, "maps", |maps| maps["learned"] == true);
        self.wait_after(learned, "now", is_idle);
    }

    /// Waits for this many decisions toward goals.
    pub fn decided(&mut self, steps: u64) {
        self.wait("now", |now| now["counts"]["steps"].as_u64() >= Some(steps));
    }

    /// Number of the latest message. The effect of a command may arrive before its answer, so a
    /// wait uses the number before the command.
    #[must_use]
    pub fn moment(&self) -> u64 {
        self.heard
    }

    /// Waits until a condition holds for a part.
    ///
    /// # Panics
    /// When it does not hold in time.
    pub fn wait(&mut self, part: &str, is: impl Fn(&Value) -> bool) {
        self.wait_after(0, part, is);
    }

    /// Waits until a condition holds for a part that arrives after message `moment`; returns that
    /// message's number. Among messages of one moment, `now` comes after maps and memory.
    ///
    /// # Panics
    /// When it does not hold in time.
    pub fn wait_after(&mut self, moment: u64, part: &str, is: impl Fn(&Value) -> bool) -> u64 {
        let began = Instant::now();
        loop {
            if let Some((heard, value)) = self.seen.get(part)
                && *heard > moment
                && is(value)
            {
                return *heard;
            }
            assert!(began.elapsed() < TIMEOUT, "no such {part}");
            self.hear();
        }
    }
}

/// The controller is idle.
#[must_use]
pub fn is_idle(now: &Value) -> bool {
    now["mode"] == "idle"
}
