//! Serves one viewer: sends snapshots and receives commands.

use super::command::{CommandOutcome, NumberedCommand, PageCommand, Reply};
use super::control_lock::{ControlLockError, ViewerId};
use super::server::{Parts, PendingCommand, ServerState};
use super::snapshot::{PartMessage, message};
use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use serde::Serialize;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::mpsc::TrySendError;
use std::time::{Duration, Instant};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::MissedTickBehavior;

/// A viewer that does not read for this long is disconnected. A browser on a machine that is busy
/// may pause for several seconds.
const SEND_TIMEOUT: Duration = Duration::from_secs(15);

/// Interval of pings to the steering viewer: a quarter of the shortest steering time-out.
const PING_EVERY: Duration = Duration::from_millis(250);

/// Maximum number of replies that wait for a viewer.
const MAX_REPLIES: usize = 64;

/// Removes the viewer when dropped.
pub(super) struct ViewerGuard {
    shared: Arc<ServerState>,
    id: ViewerId,
}

impl ViewerGuard {
    pub fn new(shared: Arc<ServerState>, id: ViewerId) -> Self {
        let guard = Self { shared, id };
        guard.notify_viewers();
        guard
    }

    fn notify_viewers(&self) {
        self.shared
            .lock_changes
            .send_modify(|changes| *changes += 1);
    }
}

impl Drop for ViewerGuard {
    fn drop(&mut self) {
        self.shared.control_lock().remove_viewer(self.id);
        self.notify_viewers();
    }
}

/// Serves a viewer until it disconnects.
pub(super) async fn serve_viewer(socket: WebSocket, shared: Arc<ServerState>, guard: ViewerGuard) {
    let (outgoing, incoming) = socket.split();
    let (reply, replies) = mpsc::channel(MAX_REPLIES);
    let latest = shared.latest.clone();
    let lock_changes = shared.lock_changes.subscribe();
    // The first task to end ends the other. Reading never waits for writing, so a stop is always
    // received.
    tokio::select! {
        () = send_updates(outgoing, &shared, guard.id, latest, lock_changes, replies) => {}
        () = receive_commands(incoming, &shared, &guard, reply) => {}
    }
}

#[derive(Serialize)]
struct LockDto {
    you: bool,
    taken: bool,
    viewers: usize,
}

fn lock_dto(shared: &ServerState, viewer: ViewerId) -> String {
    let lock = shared.control_lock();
    let dto = LockDto {
        you: lock.is_held_by(viewer),
        taken: lock.is_held(),
        viewers: lock.viewers(),
    };
    message("seat", 0, &dto)
}

/// Sends changed parts, always the latest.
async fn send_updates(
    mut outgoing: SplitSink<WebSocket, Message>,
    shared: &ServerState,
    viewer: ViewerId,
    mut latest: watch::Receiver<Parts>,
    mut lock_changes: watch::Receiver<u64>,
    mut replies: mpsc::Receiver<Reply>,
) {
    let mut sent = SentRevisions::new();
    let mut pings = tokio::time::interval(PING_EVERY);
    pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
    latest.mark_changed();
    lock_changes.mark_changed();
    loop {
        let mut messages: Vec<Message> = Vec::new();
        let text = |text: String| Message::Text(text.into());
        tokio::select! {
            biased;
            reply = replies.recv() => match reply {
                Some(reply) => messages.push(text(serde_json::to_string(&reply).unwrap_or_default())),
                None => return,
            },
            changed = lock_changes.changed() => match changed {
                Ok(()) => messages.push(text(lock_dto(shared, viewer))),
                Err(_) => return,
            },
            _ = pings.tick(), if shared.control_lock().is_held_by(viewer) => {
                messages.push(Message::Ping(Default::default()));
            }
            changed = latest.changed() => {
                if changed.is_err() {
                    return;
                }
                let parts = Arc::clone(&latest.borrow_and_update());
                messages.extend(changed_parts(&parts, &mut sent).map(text));
            }
        }
        if !send_all(&mut outgoing, messages).await {
            return;
        }
    }
}

/// Revision of each part that a viewer has.
type SentRevisions = HashMap<(&'static str, u64), u64>;

/// Texts of the parts that a viewer does not have in this revision.
fn changed_parts(
    parts: &[Arc<dyn PartMessage>],
    sent: &mut SentRevisions,
) -> impl Iterator<Item = String> {
    let is_new = |part: &&Arc<dyn PartMessage>| {
        sent.insert(part.key(), part.revision()) != Some(part.revision())
    };
    let texts: Vec<_> = parts
        .iter()
        .filter(is_new)
        .map(|part| part.text().to_string())
        .collect();
    sent.retain(|key, _| parts.iter().any(|part| part.key() == *key));
    texts.into_iter()
}

/// Whether all messages could be sent in time.
async fn send_all(outgoing: &mut SplitSink<WebSocket, Message>, messages: Vec<Message>) -> bool {
    for message in messages {
        let sending = tokio::time::timeout(SEND_TIMEOUT, outgoing.send(message));
        if !matches!(sending.await, Ok(Ok(()))) {
            return false;
        }
    }
    true
}

/// Receives the viewer's commands.
async fn receive_commands(
    mut incoming: SplitStream<WebSocket>,
    shared: &ServerState,
    guard: &ViewerGuard,
    reply: mpsc::Sender<Reply>,
) {
    while let Some(Ok(message)) = incoming.next().await {
        shared.control_lock().refresh(guard.id, Instant::now());
        let text = match message {
            Message::Text(text) => text,
            Message::Close(_) => return,
            _ => continue,
        };
        let answer = match serde_json::from_str::<NumberedCommand>(&text) {
            Ok(NumberedCommand { id, command }) => {
                Reply::to(id, execute(shared, guard, command).await)
            }
            Err(error) => Reply::to(0, Err(format!("that is no command: {error}"))),
        };
        if reply.try_send(answer).is_err() {
            // The viewer sends but does not read.
            return;
        }
    }
}

async fn execute(
    shared: &ServerState,
    guard: &ViewerGuard,
    command: PageCommand,
) -> Result<CommandOutcome, String> {
    let viewer = guard.id;
    match &command {
        PageCommand::Steer { token, over } => {
            let taken = shared
                .control_lock()
                .acquire(viewer, token, *over, Instant::now());
            guard.notify_viewers();
            return taken
                .map(|()| CommandOutcome::Done)
                .map_err(|why| why.to_string());
        }
        PageCommand::Leave => {
            shared.control_lock().release(viewer);
            guard.notify_viewers();
            return Ok(CommandOutcome::Done);
        }
        PageCommand::Stop if shared.control_lock().may_stop(viewer) => {}
        _ if shared.control_lock().is_held_by(viewer) => {}
        _ if shared.control_lock().is_held() => return Err(ControlLockError::Taken.to_string()),
        _ => return Err("you only watch: take control to steer".to_owned()),
    }
    let (answer, answered) = oneshot::channel();
    match shared.commands.try_send(PendingCommand { command, answer }) {
        Ok(()) => {}
        Err(TrySendError::Full(_)) => return Err("the robot is busy: try again".to_owned()),
        Err(TrySendError::Disconnected(_)) => return Err(GONE.to_owned()),
    }
    match answered.await {
        Ok(outcome) => outcome.map_err(|refused| refused.0),
        Err(_) => Err(GONE.to_owned()),
    }
}

const GONE: &str = "the robot's loop has ended";
