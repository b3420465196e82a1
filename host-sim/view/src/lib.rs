//! The bench view: a page in a browser that shows a robot think, and lets one person steer it.
//!
//! ```text
//! robot's thread                         server's thread (tokio)             browser
//! Source::step ── Stage (pace) ──► latest Snapshot ──► a task per viewer ──► page
//!        ▲                                                    │
//!        └───────────── orders, one after the other ◄─────────┘ (who holds the seat)
//! ```
//!
//! The robot's loop runs in a thread of its own. At most ten times a second, and only while somebody watches, it leaves a
//! [`Snapshot`] in a channel that holds the latest one only; a viewer that is slow skips what it missed, and one that takes
//! nothing for five seconds is dropped. Nobody is ever waited for, and nothing a viewer does but an order reaches the
//! robot: the same seed gives the same decisions with and without viewers.
//!
//! [`Stage`] is a pure stepping object: it is handed the time. Only [`serve`] knows the wall clock.
//!
//! # What can be watched
//!
//! Whatever is a [`Source`]: a [`Simulator`], a [Nomad](WatchedNomad), either with the mind in this process or at the end of a
//! link, a [log](Recorded), and a [board](Board) whose ring and base are its own. A source says what can be asked of it ([`Abilities`]), the page leaves out the rest.
//!
//! # The socket
//!
//! JSON texts over a WebSocket at `/socket`. The server sends *parts*, each whole and only when it has changed:
//!
//! ```json
//! {"part": "now", "index": 0, "value": {"time_s": 12.8, "mode": "seek"}}
//! ```
//!
//! | part | what | changes |
//! |---|---|---|
//! | `scene` | [`Scene`](snapshot::Scene): world, ring, menus, abilities | when the world does |
//! | `maps` | [`Maps`](snapshot::Maps): both maps, hits, U-matrices, which neurons each sample trained | with each learning |
//! | `memory` | [`Row`](snapshot::Row)s of the lazy memory | with each sample |
//! | `trail` | [`Mark`](snapshot::Mark)s of the decisions so far, in pieces of 64 (`index`) | with each decision |
//! | `heard` | places where something was heard, in pieces of 64, where nobody said what stands around | with each echo |
//! | `now` | [`Now`](snapshot::Now): pose, ranges, situation, plan, goal, counters, pace, link | always |
//! | `seat` | `{"you", "taken", "viewers"}`: who steers | when somebody comes, goes or sits down |
//!
//! The page sends *orders*: an [`Order`](order::Order) with a number, `{"id": 7, "do": "explore"}`, each answered by
//! `{"reply": 7}`, with `"error": "why not"` when it was not done, or with `"file": {"name", "text"}` (or `"hex"`).
//!
//! # Who may
//!
//! A request must name this machine in its `Host` header and come from this very page ([`guard`]). To steer, a viewer
//! shows the token of the printed address and takes the one seat ([`seat`]); whoever has shown the token may stop the
//! robot at any time. A socket opened at `/socket?token=TOKEN` has shown it already, and takes no watcher's place.
//!
//! The server pings the viewer that steers. A real robot stops when that viewer has been silent for the steering time-out.

mod board;
mod choices;
mod connections;
mod goal;
pub mod guard;
mod heard;
mod nomad;
pub mod order;
pub mod pace;
mod page;
mod recorded;
pub mod seat;
mod seen;
mod server;
mod sim;
pub mod snapshot;
pub mod source;
mod stage;
mod trail;
mod viewer;

pub use board::Board;
pub use guard::Token;
pub use nomad::{NomadStart, WatchedNomad};
pub use recorded::Recorded;
pub use server::{Door, ServeOptions, serve};
pub use sim::{PresetChoice, Simulator, Start};
pub use snapshot::Snapshot;
pub use source::{Abilities, Refused, Source, Stepped};
pub use stage::Stage;
