//! A headless browser, driven over its DevTools protocol.

use serde_json::{Value, json};
use std::fs;
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// Timeout of all waits.
pub const TIMEOUT: Duration = Duration::from_secs(30);

/// A browser with one page; stopped when dropped.
pub struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    session: String,
    asked: u64,
    errors: Vec<String>,
    requests: Vec<String>,
    _profile: TempDir,
}

/// Starts Chromium, whose debugger listens at any free port.
fn spawn(profile: &Path) -> Child {
    let spawned = Command::new("chromium")
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args([
            "--disable-dev-shm-usage",
            "--hide-scrollbars",
            "--disable-background-networking",
        ])
        .args(["--remote-debugging-port=0", "about:blank"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    spawned.unwrap_or_else(|error| {
        panic!("chromium: {error}: apt-get install -y --no-install-recommends chromium")
    })
}

/// Port and path of the debugger, from the file that the browser writes at its start.
fn debugging_address(profile: &Path) -> (String, String) {
    let active = profile.join("DevToolsActivePort");
    let began = Instant::now();
    loop {
        let text = fs::read_to_string(&active).unwrap_or_default();
        if let [port, path] = text.lines().collect::<Vec<_>>()[..] {
            return (port.to_owned(), path.to_owned());
        }
        assert!(began.elapsed() < TIMEOUT, "chromium does not start");
        std::thread::sleep(Duration::from_millis(20));
    }
}

impl Browser {
    /// Starts a browser and opens a page.
    ///
    /// # Panics
    /// When there is no Chromium, or it does not start.
    #[must_use]
    pub fn open(url: &str) -> Self {
        let profile = tempfile::tempdir().expect("a temporary folder");
        let child = spawn(profile.path());
        let (port, path) = debugging_address(profile.path());
        let host = format!("127.0.0.1:{port}");
        let stream = TcpStream::connect(&host).expect("the browser listens");
        stream.set_read_timeout(Some(TIMEOUT)).expect("a timeout");
        let opened = tungstenite::client(format!("ws://{host}{path}"), stream);
        let (socket, _) = opened.expect("the browser's own socket");
        let mut browser = Self {
            child,
            socket,
            session: String::new(),
            asked: 0,
            errors: Vec::new(),
            requests: Vec::new(),
            _profile: profile,
        };
        browser.show(url);
        browser
    }

    fn show(&mut self, url: &str) {
        let target = self.ask("Target.createTarget", json!({"url": "about:blank"}));
        let id = &target["targetId"];
        let attached = self.ask(
            "Target.attachToTarget",
            json!({"targetId": id, "flatten": true}),
        );
        self.session = attached["sessionId"]
            .as_str()
            .expect("a session")
            .to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            self.ask(&format!("{domain}.enable"), json!({}));
        }
        self.ask("Page.navigate", json!({"url": url}));
    }

    /// Sends a command and returns its result.
    ///
    /// # Panics
    /// When the browser refuses or does not answer.
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({"id": self.asked, "method": method, "params": params});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let sent = self.socket.send(Message::text(message.to_string()));
        sent.expect("the browser is there");
        loop {
            let heard = self.socket.read().expect("the browser answers");
            let Message::Text(text) = heard else { continue };
            let mut heard: Value = serde_json::from_str(&text).expect("JSON");
            if heard["id"] == self.asked {
                assert!(heard["error"].is_null(), "{method}: {}", heard["error"]);
                return heard["result"].take();
            }
            self.notice(&heard);
        }
    }

    fn notice(&mut self, event: &Value) {
        let params = &event["params"];
        match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => {
                self.errors.push(params["exceptionDetails"].to_string());
            }
            Some("Runtime.consoleAPICalled") if params["type"] == "error" => {
                self.errors.push(params["args"].to_string());
            }
            Some("Log.entryAdded") if params["entry"]["level"] == "error" => {
                self.errors.push(params["entry"].to_string());
            }
            Some("Network.requestWillBeSent") => {
                let url = params["request"]["url"].as_str().unwrap_or_default();
                self.requests.push(url.to_owned());
            }
            _ => {}
        }
    }

    /// Errors of the page and on its console so far.
    #[must_use]
    pub fn errors(&self) -> &[String] {
        &self.errors
    }

    /// Requests of the page so far, except for sockets.
    #[must_use]
    pub fn requests(&self) -> &[String] {
        &self.requests
    }

    /// Sets the size of the page, in CSS pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let mobile = width < 500;
        let size =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile});
        self.ask("Emulation.setDeviceMetricsOverride", size);
    }

    /// Sets the preferred color scheme.
    pub fn set_dark(&mut self, dark: bool) {
        let value = if dark { "dark" } else { "light" };
        let feature = json!({"name": "prefers-color-scheme", "value": value});
        self.ask("Emulation.setEmulatedMedia", json!({"features": [feature]}));
    }

    /// Evaluates an expression in the page.
    ///
    /// # Panics
    /// When it throws.
    pub fn eval(&mut self, expression: &str) -> Value {
        let params = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let mut result = self.ask("Runtime.evaluate", params);
        assert!(
            result["exceptionDetails"].is_null(),
            "{expression}: {result}"
        );
        result["result"]["value"].take()
    }

    /// Waits until an expression in the page is true. An expression that throws counts as false:
    /// the page may still load.
    ///
    /// # Panics
    /// When it does not become true in time.
    pub fn wait(&mut self, expression: &str) {
        let began = Instant::now();
        let expression = format!(
            "(() => {{ try {{ return !!({expression}) }} catch (e) {{ return `${{e}}` }} }})()"
        );
        loop {
            let value = self.eval(&expression);
            if value == true {
                return;
            }
            if began.elapsed() > TIMEOUT {
                let notice = self.eval("document.getElementById('notice')?.textContent");
                let errors = &self.errors;
                panic!("never true: {expression}: {value}; {notice}; {errors:?}");
            }
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// The center of an element on the page, after scrolling it into view.
    ///
    /// # Panics
    /// When there is no such element.
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        let found = self.eval(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{block: 'center'}}); \
             const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
        ));
        [0, 1].map(|axis| found[axis].as_f64().expect("a place on the page"))
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let button =
            json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1});
        self.ask("Input.dispatchMouseEvent", button);
    }

    /// Clicks an element.
    pub fn click(&mut self, selector: &str) {
        let at = self.middle(selector);
        self.drag(at, at);
    }

    /// Drags the mouse between two points of the page.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.mouse("mouseMoved", from);
        self.mouse("mousePressed", from);
        if from != to {
            self.mouse(
                "mouseMoved",
                [0, 1].map(|axis| (from[axis] + to[axis]) / 2.0),
            );
            self.mouse("mouseMoved", to);
        }
        self.mouse("mouseReleased", to);
    }

    /// Presses a key.
    pub fn press(&mut self, key: &str, code: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.ask(
                "Input.dispatchKeyEvent",
                json!({"type": kind, "key": key, "code": code}),
            );
        }
    }

    /// A screenshot of the window, as PNG.
    ///
    /// # Panics
    /// When the browser returns none.
    pub fn picture(&mut self) -> Vec<u8> {
        let shot = self.ask("Page.captureScreenshot", json!({"format": "png"}));
        let data = shot["data"].as_str().expect("a picture");
        data_encoding::BASE64
            .decode(data.as_bytes())
            .expect("a picture in base 64")
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
