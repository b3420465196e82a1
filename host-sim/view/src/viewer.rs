//! One viewer: what it is sent, and what it asks for.

use super::order::{Done, Numbered, Order, Reply};
use super::seat::{SeatError, ViewerId};
use super::server::{Asked, Parts, Shared};
use super::snapshot::message;
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

/// A viewer that takes nothing for so long is dropped.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time between two pings of the viewer that steers: a quarter of the shortest steering time-out.
const PING_EVERY: Duration = Duration::from_millis(250);

/// Replies that may wait for a viewer.
const MAX_REPLIES: usize = 64;

/// Gives up a viewer's place, however it ends.
pub(super) struct Leaving {
    shared: Arc<Shared>,
    id: ViewerId,
}

impl Leaving {
    pub fn new(shared: Arc<Shared>, id: ViewerId) -> Self {
        let leaving = Self { shared, id };
        leaving.tell_all();
        leaving
    }

    fn tell_all(&self) {
        self.shared.seating.send_modify(|changes| *changes += 1);
    }
}

impl Drop for Leaving {
    fn drop(&mut self) {
        self.shared.seat().leave(self.id);
        self.tell_all();
    }
}

/// Serves a viewer until it goes.
pub(super) async fn attend(socket: WebSocket, shared: Arc<Shared>, leaving: Leaving) {
    let (outgoing, incoming) = socket.split();
    let (reply, replies) = mpsc::channel(MAX_REPLIES);
    let latest = shared.latest.clone();
    let seating = shared.seating.subscribe();
    // Whichever ends first ends the other; reading never waits for writing, so that a stop is always heard.
    tokio::select! {
        () = tell(outgoing, &shared, leaving.id, latest, seating, replies) => {}
        () = hear(incoming, &shared, &leaving, reply) => {}
    }
}

#[derive(Serialize)]
struct SeatSeen {
    you: bool,
    taken: bool,
    viewers: usize,
}

fn seat_seen(shared: &Shared, viewer: ViewerId) -> String {
    let seat = shared.seat();
    let seen = SeatSeen {
        you: seat.steers(viewer),
        taken: seat.is_taken(),
        viewers: seat.viewers(),
    };
    message("seat", 0, &seen)
}

/// Sends what has changed, always the latest.
async fn tell(
    mut outgoing: SplitSink<WebSocket, Message>,
    shared: &Shared,
    viewer: ViewerId,
    mut latest: watch::Receiver<Parts>,
    mut seating: watch::Receiver<u64>,
    mut replies: mpsc::Receiver<Reply>,
) {
    let mut sent = HashMap::new();
    let mut pings = tokio::time::interval(PING_EVERY);
    pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
    latest.mark_changed();
    seating.mark_changed();
    loop {
        let mut messages: Vec<Message> = Vec::new();
        let text = |text: String| Message::Text(text.into());
        tokio::select! {
            biased;
            reply = replies.recv() => match reply {
                Some(reply) => messages.push(text(serde_json::to_string(&reply).unwrap_or_default())),
                None => return,
            },
            changed = seating.changed() => match changed {
                Ok(()) => messages.push(text(seat_seen(shared, viewer))),
                Err(_) => return,
            },
            _ = pings.tick(), if shared.seat().steers(viewer) => {
                messages.push(Message::Ping(Default::default()));
            }
            changed = latest.changed() => {
                if changed.is_err() {
                    return;
                }
                let parts = Arc::clone(&latest.borrow_and_update());
                let news = parts.iter().filter(|part| {
                    sent.insert(part.key(), part.revision()) != Some(part.revision())
                });
                messages.extend(news.map(|part| text(part.text().to_string())));
                sent.retain(|key, _| parts.iter().any(|part| part.key() == *key));
            }
        }
        for message in messages {
            let sending = outgoing.send(message);
            if !matches!(tokio::time::timeout(PATIENCE, sending).await, Ok(Ok(()))) {
                return;
            }
        }
    }
}

/// Takes the viewer's orders.
async fn hear(
    mut incoming: SplitStream<WebSocket>,
    shared: &Shared,
    leaving: &Leaving,
    reply: mpsc::Sender<Reply>,
) {
    while let Some(Ok(heard)) = incoming.next().await {
        shared.seat().heard(leaving.id, Instant::now());
        let text = match heard {
            Message::Text(text) => text,
            Message::Close(_) => return,
            _ => continue,
        };
        let answer = match serde_json::from_str::<Numbered>(&text) {
            Ok(Numbered { id, order }) => Reply::to(id, obey(shared, leaving, order).await),
            Err(error) => Reply::to(0, Err(format!("that is no order: {error}"))),
        };
        if reply.try_send(answer).is_err() {
            // It asks and does not listen.
            return;
        }
    }
}

async fn obey(shared: &Shared, leaving: &Leaving, order: Order) -> Result<Done, String> {
    let viewer = leaving.id;
    match &order {
        Order::Steer { token, over } => {
            let taken = shared.seat().take(viewer, token, *over, Instant::now());
            leaving.tell_all();
            return taken.map(|()| Done::Well).map_err(|why| why.to_string());
        }
        Order::Leave => {
            shared.seat().rise(viewer);
            leaving.tell_all();
            return Ok(Done::Well);
        }
        Order::Stop if shared.seat().may_stop(viewer) => {}
        _ if shared.seat().steers(viewer) => {}
        _ if shared.seat().is_taken() => return Err(SeatError::Taken.to_string()),
        _ => return Err("you watch: take the seat to steer".to_owned()),
    }
    let (answer, answered) = oneshot::channel();
    match shared.orders.try_send(Asked { order, answer }) {
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
