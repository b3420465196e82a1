//! The web server: page, socket, and the robot's thread.

use super::command::{CommandOutcome, PageCommand};
use super::connections;
use super::control_lock::ControlLock;
use super::guard::{TOKEN_BYTES, Token, admits};
use super::page::{PAGE, POLICY};
use super::runner::Runner;
use super::snapshot::PartMessage;
use super::source::{CommandRefused, ViewSource};
use super::viewer;
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::{HeaderMap, HeaderName, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use files::error::BadInput;
use remote::listen::check_reach;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{oneshot, watch};

/// Maximum number of viewers without the token.
const MAX_WATCHERS: usize = 100;
/// Maximum number of commands that wait for the robot's thread.
const MAX_COMMANDS: usize = 64;
/// Maximum size of a viewer's message, bytes: a controller file with a thousand samples in
/// hexadecimal, with some reserve.
const MAX_MESSAGE_BYTES: usize = 1 << 18;

/// All parts of the latest snapshot.
pub(super) type Parts = Arc<Vec<Arc<dyn PartMessage>>>;

/// A command on its way to the robot's thread, and the channel for its outcome.
pub(super) struct PendingCommand {
    pub command: PageCommand,
    pub answer: oneshot::Sender<Result<CommandOutcome, CommandRefused>>,
}

/// State shared by the viewers' tasks.
pub(super) struct ServerState {
    pub latest: watch::Receiver<Parts>,
    pub commands: SyncSender<PendingCommand>,
    /// Counts the changes of the control lock.
    pub lock_changes: watch::Sender<u64>,
    listening: SocketAddr,
    lock: Arc<Mutex<ControlLock>>,
}

impl ServerState {
    pub fn control_lock(&self) -> MutexGuard<'_, ControlLock> {
        lock(&self.lock)
    }
}

fn lock(lock: &Mutex<ControlLock>) -> MutexGuard<'_, ControlLock> {
    // A panic leaves the lock valid: each method updates all of it.
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A server with a bound address that accepts no connection yet.
pub struct BoundServer {
    listener: std::net::TcpListener,
    address: SocketAddr,
    token: Token,
}

impl BoundServer {
    /// Binds an address; port 0 takes any free one.
    ///
    /// # Errors
    /// When the address is in use or not local, is reachable from outside without `remote`, or
    /// there is no randomness for the token.
    pub fn open(address: SocketAddr, remote: bool) -> Result<Self, BadInput> {
        let refuse = |why: String| BadInput::new(format!("--listen {address}: {why}"));
        let risk = "anyone with the token can steer";
        check_reach(&address.to_string(), &[address], remote, risk)?;
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes).map_err(|error| refuse(format!("no token: {error}")))?;
        let listener = std::net::TcpListener::bind(address)
            .and_then(|listener| listener.set_nonblocking(true).map(|()| listener));
        let listener =
            listener.map_err(|error| refuse(format!("{error} (port 0 takes any that is free)")))?;
        let address = listener
            .local_addr()
            .map_err(|error| refuse(error.to_string()))?;
        Ok(Self {
            listener,
            address,
            token: Token::of(bytes),
        })
    }

    /// Addresses to watch, and to watch and steer.
    #[must_use]
    pub fn addresses(&self) -> [String; 2] {
        let watch = format!("http://{}/", self.address);
        let steer = format!("{watch}#token={}", self.token.as_str());
        [watch, steer]
    }
}

/// Options of the server.
#[derive(Debug, Clone, Copy)]
pub struct ServeOptions {
    /// Simulated seconds per second; `None` = maximum.
    pub speed: Option<f64>,
    /// A real robot stops after this time without a steering page; `None` = never.
    pub steering_timeout: Option<Duration>,
}

/// Serves a source until `ended` is set.
///
/// # Errors
/// When threads or sockets fail, or the source cannot be shut down.
pub fn serve(
    server: BoundServer,
    source: Box<dyn ViewSource>,
    options: ServeOptions,
    ended: Arc<AtomicBool>,
) -> Result<(), BadInput> {
    let refuse =
        |error: std::io::Error| BadInput::new(format!("the view cannot be served: {error}"));
    let (commands, queued) = sync_channel(MAX_COMMANDS);
    let (show, latest) = watch::channel(Parts::default());
    let runner = Runner::new(source, options.speed);
    let lock = Arc::new(Mutex::new(ControlLock::new(server.token)));
    let steering = SteeringMonitor {
        lock: Arc::clone(&lock),
        timeout: options.steering_timeout,
    };
    let (done, over) = oneshot::channel();
    let robot = std::thread::Builder::new().name("robot".to_owned());
    let robot = robot.spawn(move || {
        let end = run(runner, &steering, &queued, &show, &ended);
        // The receiver may be gone.
        let _ = done.send(());
        end
    });
    let robot = robot.map_err(refuse)?;
    let shared = Arc::new(ServerState {
        latest,
        commands,
        lock_changes: watch::channel(0).0,
        listening: server.address,
        lock,
    });
    serve_pages(server.listener, shared, over).map_err(refuse)?;
    // A panic there is a bug, and was already printed.
    robot.join().unwrap_or(Ok(())).map_err(BadInput::new)
}

/// Serves the page and its sockets until the robot's thread is `over`.
fn serve_pages(
    listener: std::net::TcpListener,
    shared: Arc<ServerState>,
    over: oneshot::Receiver<()>,
) -> std::io::Result<()> {
    let router = Router::new()
        .route("/", get(page))
        .route("/socket", get(socket))
        .with_state(shared);
    let mut runtime = tokio::runtime::Builder::new_current_thread();
    runtime.enable_all().build()?.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::select! {
            () = connections::serve(listener, router) => {}
            _ = over => {}
        }
        Ok(())
    })
}

/// Checks the control lock in the robot's thread.
struct SteeringMonitor {
    lock: Arc<Mutex<ControlLock>>,
    timeout: Option<Duration>,
}

impl SteeringMonitor {
    /// The time-out, once after each time it has passed.
    fn lost(&self) -> Option<Duration> {
        let timeout = self.timeout?;
        let lost = lock(&self.lock).becomes_unattended(Instant::now(), timeout);
        lost.then_some(timeout)
    }
}

/// The robot's loop; only here the clock is read.
fn run(
    mut runner: Runner,
    steering: &SteeringMonitor,
    commands: &Receiver<PendingCommand>,
    show: &watch::Sender<Parts>,
    ended: &AtomicBool,
) -> Result<(), String> {
    let began = Instant::now();
    let mut last_viewers = 0;
    loop {
        if ended.load(Ordering::Relaxed) {
            return runner.end();
        }
        if let Some(timeout) = steering.lost() {
            runner.steering_lost(timeout);
        }
        let next = runner.advance(began.elapsed());
        let viewers = show.receiver_count() - 1;
        if viewers > last_viewers {
            runner.refresh();
        }
        last_viewers = viewers;
        let until_shown = match viewers {
            0 => None,
            _ => publish(&mut runner, show, began),
        };
        // Also while idle, because a viewer may connect.
        let idle = Duration::from_millis(200);
        let wait = next
            .unwrap_or(idle)
            .min(until_shown.unwrap_or(idle))
            .min(idle);
        match commands.recv_timeout(wait) {
            Ok(command) => execute_all(&mut runner, command, commands),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return runner.end(),
        }
    }
}

/// Publishes a snapshot if one is due. Returns the time until the next one; `None` = nothing has
/// changed.
fn publish(runner: &mut Runner, show: &watch::Sender<Parts>, began: Instant) -> Option<Duration> {
    if let Some(snapshot) = runner.show(began.elapsed()) {
        show.send_replace(Arc::new(snapshot.into_parts()));
    }
    runner.until_shown(began.elapsed())
}

/// Executes a command and all queued ones.
fn execute_all(runner: &mut Runner, first: PendingCommand, queued: &Receiver<PendingCommand>) {
    let mut next = Some(first);
    while let Some(PendingCommand { command, answer }) = next {
        // The sender may be gone.
        let _ = answer.send(runner.execute(&command));
        next = queued.try_recv().ok();
    }
}

const HEADERS: [(HeaderName, &str); 5] = [
    (header::CONTENT_TYPE, "text/html; charset=utf-8"),
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::CACHE_CONTROL, "no-store"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
];

fn admitted(shared: &ServerState, headers: &HeaderMap) -> Result<(), (StatusCode, &'static str)> {
    let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or(""));
    if admits(shared.listening, text(header::HOST), text(header::ORIGIN)) {
        return Ok(());
    }
    Err((
        StatusCode::FORBIDDEN,
        "only the page this program serves may ask\n",
    ))
}

async fn page(State(shared): State<Arc<ServerState>>, headers: HeaderMap) -> Response {
    match admitted(&shared, &headers) {
        Ok(()) => (HEADERS, PAGE).into_response(),
        Err(refusal) => refusal.into_response(),
    }
}

async fn socket(State(shared): State<Arc<ServerState>>, request: Request) -> Response {
    if let Err(refusal) = admitted(&shared, request.headers()) {
        return refusal.into_response();
    }
    let (mut parts, _) = request.into_parts();
    let upgrade = match WebSocketUpgrade::from_request_parts(&mut parts, &()).await {
        Ok(upgrade) => upgrade,
        Err(refusal) => return refusal.into_response(),
    };
    let query = parts.uri.query().unwrap_or_default();
    let token = query
        .split('&')
        .find_map(|pair| pair.strip_prefix("token="));
    let Some(id) = shared.control_lock().add_viewer(MAX_WATCHERS, token) else {
        let why = "there are enough watchers: open the address with the token\n";
        return (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    };
    let guard = viewer::ViewerGuard::new(Arc::clone(&shared), id);
    upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .on_upgrade(move |socket| viewer::serve_viewer(socket, shared, guard))
}
