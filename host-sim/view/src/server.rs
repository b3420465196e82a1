//! The server: the page, the socket, the robot's thread.

use super::connections;
use super::guard::{TOKEN_BYTES, Token, admits};
use super::order::{Done, Order};
use super::page::{PAGE, POLICY};
use super::seat::Seat;
use super::snapshot::Showable;
use super::source::{Refused, Source};
use super::stage::Stage;
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

/// Most viewers without the token at a time.
const MAX_WATCHERS: usize = 100;
/// Orders that may wait for the robot's thread.
const MAX_ORDERS: usize = 64;
/// Longest message of a viewer, bytes: a mind's file with a thousand samples, in hexadecimal, and room to spare.
const LONGEST_MESSAGE: usize = 1 << 18;

/// All parts of the latest snapshot.
pub(super) type Parts = Arc<Vec<Arc<dyn Showable>>>;

/// An order on its way to the robot's thread, and where its answer goes.
pub(super) struct Asked {
    pub order: Order,
    pub answer: oneshot::Sender<Result<Done, Refused>>,
}

/// What the viewers' tasks share.
pub(super) struct Shared {
    pub latest: watch::Receiver<Parts>,
    pub orders: SyncSender<Asked>,
    /// Counts the changes of the seat.
    pub seating: watch::Sender<u64>,
    listening: SocketAddr,
    seat: Arc<Mutex<Seat>>,
}

impl Shared {
    pub fn seat(&self) -> MutexGuard<'_, Seat> {
        lock(&self.seat)
    }
}

fn lock(seat: &Mutex<Seat>) -> MutexGuard<'_, Seat> {
    // A seat is whole between any two of its methods.
    seat.lock().unwrap_or_else(PoisonError::into_inner)
}

/// An open door: the address is taken, nobody is let in yet.
pub struct Door {
    listener: std::net::TcpListener,
    address: SocketAddr,
    token: Token,
}

impl Door {
    /// Listens at an address; port 0 is any free one.
    ///
    /// # Errors
    /// When the address is in use or not this machine's, reaches beyond it without `remote`, or the system has no
    /// randomness for the token.
    pub fn open(address: SocketAddr, remote: bool) -> Result<Self, BadInput> {
        let refuse = |why: String| BadInput::new(format!("--listen {address}: {why}"));
        let risk = "whoever has the token steers";
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

    /// Where to watch, and where to watch and steer.
    #[must_use]
    pub fn addresses(&self) -> [String; 2] {
        let watch = format!("http://{}/", self.address);
        let steer = format!("{watch}#token={}", self.token.as_str());
        [watch, steer]
    }
}

/// How a source is served.
#[derive(Debug, Clone, Copy)]
pub struct ServeOptions {
    /// Simulated seconds per second; `None` = as fast as it goes.
    pub speed: Option<f64>,
    /// A real robot stops when no page has steered for so long; `None` = never.
    pub steering_timeout: Option<Duration>,
}

/// Shows a source to whoever comes, until `ended` is raised.
///
/// # Errors
/// When the system gives neither threads nor sockets, or the source cannot be brought to an end.
pub fn serve(
    door: Door,
    source: Box<dyn Source>,
    options: ServeOptions,
    ended: Arc<AtomicBool>,
) -> Result<(), BadInput> {
    let refuse =
        |error: std::io::Error| BadInput::new(format!("the view cannot be served: {error}"));
    let (orders, asked) = sync_channel(MAX_ORDERS);
    let (show, latest) = watch::channel(Parts::default());
    let stage = Stage::new(source, options.speed);
    let seat = Arc::new(Mutex::new(Seat::new(door.token)));
    let steering = Steering {
        seat: Arc::clone(&seat),
        timeout: options.steering_timeout,
    };
    let (done, over) = oneshot::channel();
    let robot = std::thread::Builder::new().name("robot".to_owned());
    let robot = robot.spawn(move || {
        let end = run(stage, &steering, &asked, &show, &ended);
        // Whoever waits for it may be gone.
        let _ = done.send(());
        end
    });
    let robot = robot.map_err(refuse)?;
    let shared = Arc::new(Shared {
        latest,
        orders,
        seating: watch::channel(0).0,
        listening: door.address,
        seat,
    });
    let router = Router::new()
        .route("/", get(page))
        .route("/socket", get(socket))
        .with_state(shared);
    let mut runtime = tokio::runtime::Builder::new_current_thread();
    let runtime = runtime.enable_all().build().map_err(refuse)?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(door.listener).map_err(refuse)?;
        tokio::select! {
            () = connections::serve(listener, router) => {}
            _ = over => {}
        }
        Ok::<_, BadInput>(())
    })?;
    // It cannot panic but by a mistake of its own, which has been said then.
    robot.join().unwrap_or(Ok(())).map_err(BadInput::new)
}

/// The seat as the robot's thread sees it.
struct Steering {
    seat: Arc<Mutex<Seat>>,
    timeout: Option<Duration>,
}

impl Steering {
    /// The time-out, once after each time it has passed.
    fn lost(&self) -> Option<Duration> {
        let timeout = self.timeout?;
        let lost = lock(&self.seat).becomes_unattended(Instant::now(), timeout);
        lost.then_some(timeout)
    }
}

/// The robot's loop: the only place that looks at the clock.
fn run(
    mut stage: Stage,
    steering: &Steering,
    asked: &Receiver<Asked>,
    show: &watch::Sender<Parts>,
    ended: &AtomicBool,
) -> Result<(), String> {
    let began = Instant::now();
    let mut watched = 0;
    loop {
        if ended.load(Ordering::Relaxed) {
            return stage.end();
        }
        if let Some(timeout) = steering.lost() {
            stage.steering_lost(timeout);
        }
        let next = stage.advance(began.elapsed());
        let viewers = show.receiver_count() - 1;
        if viewers > watched {
            stage.refresh();
        }
        watched = viewers;
        let mut until_shown = None;
        if viewers > 0 {
            if let Some(snapshot) = stage.show(began.elapsed()) {
                show.send_replace(Arc::new(snapshot.into_parts()));
            }
            until_shown = stage.until_shown(began.elapsed());
        }
        // Even when nothing goes on somebody may come to watch.
        let idle = Duration::from_millis(200);
        let wait = next
            .unwrap_or(idle)
            .min(until_shown.unwrap_or(idle))
            .min(idle);
        let mut order = match asked.recv_timeout(wait) {
            Ok(order) => Some(order),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return stage.end(),
        };
        while let Some(Asked {
            order: what,
            answer,
        }) = order
        {
            // Whoever asked may be gone.
            let _ = answer.send(stage.carry_out(&what));
            order = asked.try_recv().ok();
        }
    }
}

const HEADERS: [(HeaderName, &str); 5] = [
    (header::CONTENT_TYPE, "text/html; charset=utf-8"),
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::CACHE_CONTROL, "no-store"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
];

fn admitted(shared: &Shared, headers: &HeaderMap) -> Result<(), (StatusCode, &'static str)> {
    let text = |name: HeaderName| headers.get(name).map(|value| value.to_str().unwrap_or(""));
    if admits(shared.listening, text(header::HOST), text(header::ORIGIN)) {
        return Ok(());
    }
    Err((
        StatusCode::FORBIDDEN,
        "only the page this program serves may ask\n",
    ))
}

async fn page(State(shared): State<Arc<Shared>>, headers: HeaderMap) -> Response {
    match admitted(&shared, &headers) {
        Ok(()) => (HEADERS, PAGE).into_response(),
        Err(refusal) => refusal.into_response(),
    }
}

async fn socket(State(shared): State<Arc<Shared>>, request: Request) -> Response {
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
    let Some(id) = shared.seat().enter(MAX_WATCHERS, token) else {
        let why = "there are enough watchers: open the address with the token\n";
        return (StatusCode::SERVICE_UNAVAILABLE, why).into_response();
    };
    let leaving = viewer::Leaving::new(Arc::clone(&shared), id);
    upgrade
        .max_message_size(LONGEST_MESSAGE)
        .on_upgrade(move |socket| viewer::attend(socket, shared, leaving))
}
