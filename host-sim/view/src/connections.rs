//! Limits number and age of the page's HTTP connections.
//!
//! A connection that becomes a WebSocket leaves this list; [`control_lock`](super::control_lock)
//! limits those.

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::cmp::Reverse;
use std::net::IpAddr;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;

/// Maximum number of connections. A browser needs two; a process may have about 1000 files and
/// sockets.
const MAX_CONNECTIONS: usize = 128;

/// Time limit for the head of a request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(5);

/// Time limit for a connection; the page has 100 KB.
const MAX_AGE: Duration = Duration::from_secs(30);

/// Pause after a failed accept, for example without a free file descriptor.
const ACCEPT_PAUSE: Duration = Duration::from_millis(50);

/// Serves the page until the task ends. If the limit is reached, a new connection replaces an old
/// one, which is likely to be idle because a browser sends its request at once.
pub(super) async fn serve(listener: TcpListener, router: Router) {
    let mut open: Vec<(IpAddr, AbortHandle)> = Vec::new();
    loop {
        let Ok((stream, peer)) = listener.accept().await else {
            tokio::time::sleep(ACCEPT_PAUSE).await;
            continue;
        };
        open.retain(|(_, task)| !task.is_finished());
        if open.len() >= MAX_CONNECTIONS {
            let peers: Vec<_> = open.iter().map(|(peer, _)| *peer).collect();
            if let Some(index) = oldest_of_busiest(&peers) {
                open.remove(index).1.abort();
            }
            // The aborted task closes its socket before the next one is accepted.
            tokio::task::yield_now().await;
        }
        let task = tokio::spawn(serve_connection(stream, router.clone()));
        open.push((peer.ip(), task.abort_handle()));
    }
}

async fn serve_connection(stream: TcpStream, router: Router) {
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router))
        .with_upgrades();
    // A connection that fails affects only its own peer.
    let _ = tokio::time::timeout(MAX_AGE, connection).await;
}

/// The oldest connection of the peer with the most connections; `peers` are ordered from old to
/// new.
fn oldest_of_busiest(peers: &[IpAddr]) -> Option<usize> {
    let count = |peer: &IpAddr| peers.iter().filter(|other| *other == peer).count();
    (0..peers.len()).max_by_key(|&index| (peers.get(index).map(count), Reverse(index)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_connection_of_the_busiest_peer_makes_room() {
        let peers = |last: &[u8]| -> Vec<IpAddr> {
            let address = |&last: &u8| IpAddr::from([10, 0, 0, last]);
            last.iter().map(address).collect()
        };
        assert_eq!(oldest_of_busiest(&[]), None);
        assert_eq!(oldest_of_busiest(&peers(&[1, 1, 1])), Some(0));
        assert_eq!(oldest_of_busiest(&peers(&[1, 2, 2, 3])), Some(1));
        assert_eq!(oldest_of_busiest(&peers(&[1, 2, 3])), Some(0));
    }
}
