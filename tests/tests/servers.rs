//! Servers and their peers: half-open connections, too many viewers, vanished or flooding peers,
//! closed pages.

use amp::config::Config;
use amp::wire::message::{Counters, DeviceMessage};
use amp::wire::{Frame, Header, Report};
use nomad200::{Greeting, Kind, LaserSetup, NomadCommand, Packet, StateMask};
use remote::link::NodeServer;
use remote::log;
use serde_json::{Value, json};
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::thread::sleep;
use std::time::{Duration, Instant};
use tests::nomad::{Running, ServedRobot, TIMEOUT};
use tests::viewed::{Viewed, Viewer};
use tests::{host_sim, words};

/// Half a request.
const HALF: &[u8] = b"GET / HTTP/1.1\r\nHost: 127.0.0.1";

/// Fetches the page on a new connection.
fn page(host: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("it listens");
    stream.set_read_timeout(Some(TIMEOUT)).expect("a timeout");
    let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).expect("a request");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer
}

/// Whether the server keeps this connection open.
fn is_open(mut stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).expect("a socket");
    loop {
        match stream.read(&mut [0; 1_024]) {
            Ok(0) => return false,
            Ok(_) => {}
            Err(error) if error.kind() == ErrorKind::WouldBlock => return true,
            Err(error) => {
                assert_eq!(error.kind(), ErrorKind::ConnectionReset);
                return false;
            }
        }
    }
}

/// Twice as many half-open connections as the file limit of the process.
#[test]
fn half_open_connections_keep_no_page_out_and_are_closed() {
    let program = host_sim!();
    let viewed = Viewed::start_with_files(&program, 256, "--explore 5");
    let (mut mute, mut half_said) = (Vec::new(), Vec::new());
    for number in 0..512 {
        let mut stream = TcpStream::connect(viewed.host()).expect("it listens");
        if number % 2 == 0 {
            // The server may have closed it to make room.
            let _ = stream.write_all(HALF);
            half_said.push(stream);
        } else {
            mute.push(stream);
        }
        if number % 64 == 63 {
            assert!(page(viewed.host()).starts_with("HTTP/1.1 200"), "{number}");
        }
    }
    assert!(page(viewed.host()).starts_with("HTTP/1.1 200"));
    let last_opened = Instant::now();
    let open = |streams: &[TcpStream]| streams.iter().filter(|stream| is_open(stream)).count();
    // Most have been closed to make room; timeouts close the rest.
    assert!(open(&mute) > 0 && open(&half_said) > 0);
    while last_opened.elapsed() < Duration::from_secs(9) && open(&mute) + open(&half_said) > 0 {
        sleep(Duration::from_millis(50));
    }
    let left = (open(&mute), open(&half_said));
    assert_eq!(left, (0, 0), "said nothing, said half a head");
    let took = last_opened.elapsed();
    assert!(took < Duration::from_secs(10), "{took:?}");
    // Open connections stay open.
    viewed.viewer().wait("now", |now| now["mode"] == "idle");
}

#[test]
fn watchers_without_the_token_keep_no_owner_out() {
    let program = host_sim!();
    let viewed = Viewed::start(&program, "--explore 5");
    let mut watchers: Vec<_> = (0..100).map(|_| viewed.viewer()).collect();
    assert_eq!(viewed.knock(&[]).err(), Some(503));
    let wrong = format!("/socket?token={}", "0".repeat(32));
    assert_eq!(viewed.knock_at(&wrong, &[]).err(), Some(503));
    let mut owner = viewed.owner().expect("an owner is accepted");
    // It may stop the robot before it steers.
    owner.order(json!({"do": "stop"})).expect("it stops");
    let steer = json!({"do": "steer", "token": viewed.token()});
    owner.order(steer).expect("the seat");
    owner.order(json!({"do": "explore"})).expect("it explores");
    // Owners do not count as viewers.
    drop(watchers.pop());
    let _second = viewed.owner().expect("another owner");
    let began = Instant::now();
    while viewed.knock(&[]).is_err() {
        assert!(began.elapsed() < TIMEOUT, "the free place is not given");
        sleep(Duration::from_millis(20));
    }
}

/// A robot that explores, steered by the first viewer and watched by the second.
fn exploring(viewed: &Viewed) -> (Viewer, Viewer) {
    let mut watcher = viewed.viewer();
    let mut steerer = viewed.steerer();
    steerer
        .order(json!({"do": "explore"}))
        .expect("it explores");
    watcher.wait("now", |now| now["mode"] == "explore");
    (steerer, watcher)
}

fn stopped_unattended(now: &Value) -> bool {
    let note = now["note"].as_str().unwrap_or_default();
    now["mode"] == "stopped" && note.contains("no page")
}

/// Sends a command of the steering page; returns the time after it.
fn heard(viewed: &Viewed, steerer: &mut Viewer) -> Instant {
    let steer = json!({"do": "steer", "token": viewed.token()});
    steerer.order(steer).expect("it has the seat");
    Instant::now()
}

/// Waits until the robot has stopped because no page has steered it since `left`.
fn stops_in_time(watcher: &mut Viewer, left: Instant) {
    watcher.wait("now", stopped_unattended);
    let took_s = left.elapsed().as_secs_f64();
    // 2 s unless another timeout is set.
    assert!((1.5..4.0).contains(&took_s), "{took_s} s");
}

#[test]
fn a_robot_whose_steering_page_is_gone_stops() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 5 --world room");
    let flags = format!("--nomad tcp:{} --explore 1000", robot.place);
    let viewed = Viewed::start(&program, &flags);
    // Page closed.
    let (mut steerer, mut watcher) = exploring(&viewed);
    let left = heard(&viewed, &mut steerer);
    drop(steerer);
    stops_in_time(&mut watcher, left);
    assert_eq!(watcher.latest("now")["resumes"], true);
    // Page open but silent: it answers no ping, because its socket is not read.
    let (mut silent, mut watcher) = exploring(&viewed);
    let left = heard(&viewed, &mut silent);
    stops_in_time(&mut watcher, left);
    // A page that answers may let it explore beyond the timeout.
    let over = json!({"do": "steer", "token": viewed.token(), "over": true});
    let mut steerer = viewed.owner().expect("an owner");
    steerer.order(over).expect("the seat");
    steerer.order(json!({"do": "resume"})).expect("it goes on");
    let began = Instant::now();
    let moment = steerer.moment();
    steerer.wait_after(moment, "now", |now| {
        now["mode"] == "explore" && began.elapsed() > Duration::from_secs(4)
    });
    drop(viewed);
    sleep(Duration::from_millis(500));
    let mut host = robot.connect();
    let state = host.request(&NomadCommand::GetState).expect("an answer");
    assert!(tests::nomad::stands(state), "{state:?}");
}

/// Its own ring may take 20 s: it still explores, waiting for its first echo, when the page is
/// closed.
#[test]
fn a_board_whose_steering_page_is_gone_stops() {
    let program = host_sim!();
    let mut config = Config::recommended();
    config.robot.ring_period_ms = 10_000;
    let served = NodeServer::with_ring(config).expect("a mind behind a socket");
    let flags = format!("--board tcp:{} --explore 20", served.host());
    let viewed = Viewed::start(&program, &flags);
    // Page closed.
    let (mut steerer, mut watcher) = exploring(&viewed);
    let left = heard(&viewed, &mut steerer);
    drop(steerer);
    stops_in_time(&mut watcher, left);
    assert_eq!(watcher.latest("now")["resumes"], true);
    // Page open but silent.
    let (mut silent, mut watcher) = exploring(&viewed);
    let left = heard(&viewed, &mut silent);
    stops_in_time(&mut watcher, left);
    // The reason stays until something else happens.
    let moment = watcher.moment();
    watcher.wait_after(moment, "now", |now| {
        assert!(stopped_unattended(now), "{now}");
        left.elapsed() > Duration::from_secs(5)
    });
}

#[test]
fn a_robot_may_be_left_alone_on_request() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 5 --world room");
    let flags = format!(
        "--nomad tcp:{} --explore 1000 --steering-timeout off",
        robot.place
    );
    let viewed = Viewed::start(&program, &flags);
    let (steerer, mut watcher) = exploring(&viewed);
    drop(steerer);
    let left = Instant::now();
    watcher.wait("seat", |seat| seat["taken"] == false);
    let moment = watcher.moment();
    watcher.wait_after(moment, "now", |now| {
        assert_eq!(now["mode"], "explore");
        left.elapsed() > Duration::from_secs(5)
    });
}

/// The kernel's timer of the server's end of a connection, from /proc/net/tcp: its kind, and ticks
/// of 1/100 s left.
#[cfg(target_os = "linux")]
fn timer(server: u16, client: u16) -> Option<(String, u64)> {
    let table = std::fs::read_to_string("/proc/net/tcp").expect("the kernel's table");
    let ends_with = |field: &str, port: u16| field.ends_with(&format!(":{port:04X}"));
    let row = table.lines().find_map(|line| {
        let fields: Vec<_> = line.split_whitespace().collect();
        let ends = ends_with(fields.get(1)?, server) && ends_with(fields.get(2)?, client);
        ends.then(|| fields.get(5).map(|field| (*field).to_owned()))?
    })?;
    let (kind, ticks) = row.split_once(':')?;
    Some((kind.to_owned(), u64::from_str_radix(ticks, 16).ok()?))
}

/// A vanished peer sends nothing; keep-alive probes of the kernel detect it.
#[cfg(target_os = "linux")]
#[test]
fn a_program_that_vanishes_is_probed_for() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "");
    let mut idle = TcpStream::connect(&robot.place).expect("a robot");
    idle.read_exact(&mut [0; 11]).expect("a greeting");
    let port = |address: std::io::Result<std::net::SocketAddr>| address.expect("a port").port();
    let (server, client) = (port(idle.peer_addr()), port(idle.local_addr()));
    let began = Instant::now();
    loop {
        // "02" is the keep-alive timer; others run until the greeting is acknowledged.
        match timer(server, client) {
            Some((kind, ticks)) if kind == "02" => {
                assert!(ticks <= 1_100, "a probe after {ticks} ticks");
                return;
            }
            seen => assert!(began.elapsed() < Duration::from_secs(5), "{seen:?}"),
        }
        sleep(Duration::from_millis(20));
    }
}

#[test]
fn a_robot_is_served_to_other_machines_only_on_request() {
    let program = host_sim!();
    for (address, named) in [("0.0.0.0:0", "0.0.0.0:0"), ("[::]:0", "[::]:0")] {
        let mut served = Running::start(&program, &format!("nomad serve --listen {address}"));
        let (code, stdout, stderr) = served.end(TIMEOUT);
        assert_eq!((code, stdout.as_str()), (Some(2), ""), "{stderr}");
        assert!(stderr.contains(&format!(
            "--listen {named}: others could reach it: say --allow-remote"
        )));
    }
    let served = Running::start(&program, "nomad serve --listen 0.0.0.0:0 --allow-remote");
    assert!(served.line().starts_with("listening on 0.0.0.0:"));
}

/// A peer that sends `first` once and `bytes` without end to every client, and reads nothing.
fn flood(first: &[u8], bytes: &[u8]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a socket");
    let place = listener.local_addr().expect("its address").to_string();
    let (first, bytes) = (first.to_vec(), bytes.to_vec());
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.expect("a peer");
            let (first, bytes) = (first.clone(), bytes.clone());
            std::thread::spawn(move || {
                let begun = stream.write_all(&first).is_ok();
                while begun && stream.write_all(&bytes).is_ok() {}
            });
        }
    });
    place
}

/// Checks that the program disconnects from its peer at `place` within `limit`; returns its
/// sentence.
fn gives_up(program: &tests::Program, line: &str, place: &str, limit: Duration) -> String {
    let mut running = Running::start(program, line);
    let (code, stdout, stderr) = running.end(limit);
    assert_eq!(code, Some(2), "{line}: {stderr}");
    // The bridge prints the result so far.
    assert!(stdout.is_empty() || line.starts_with("bridge"), "{stdout}");
    assert_eq!(stderr.lines().count(), 1, "{line}: {stderr}");
    assert!(stderr.contains(place), "{line}: {stderr}");
    stderr
}

/// Valid frames of a session that was never opened.
fn stray_frames() -> Vec<u8> {
    let frame = |seq| {
        let session = 48_879;
        let report: Report<16> = Report {
            device_ms: 0,
            message: DeviceMessage::Counters(Counters::NONE),
        };
        let frame = Frame::pack(Header { session, seq }, &report).expect("a frame");
        frame.as_bytes().to_vec()
    };
    (0..1_000).flat_map(frame).collect()
}

#[test]
fn a_peer_that_sends_sound_messages_without_end_is_given_up() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 5");
    let place = flood(&[], &stray_frames());
    for line in [
        format!("link --to tcp:{place} hello"),
        format!("bridge --nomad tcp:{} --mind tcp:{place}", robot.place),
        format!("run --steps 1 --mind tcp:{place}"),
        format!("view --listen 127.0.0.1:0 --board tcp:{place}"),
    ] {
        let why = gives_up(&program, &line, &place, Duration::from_secs(10));
        assert!(why.contains("no answer within 2 s"), "{line}: {why}");
    }
    // A robot that greets, and then sends unrequested answers.
    let answers = Packet::new(Kind::Tk, vec![0; 80]).to_bytes().repeat(1_000);
    let greeting = Greeting {
        mask: StateMask::ALL,
        laser: LaserSetup::default(),
    };
    let place = flood(&greeting.to_bytes(), &answers);
    let line = format!("bridge --nomad tcp:{place}");
    let why = gives_up(&program, &line, &place, Duration::from_secs(10));
    assert!(why.contains("has not answered within 1 s"), "{why}");
}

#[test]
fn a_peer_that_sends_garbage_without_end_is_given_up() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 5");
    for bytes in [&[0x55; 997][..], &[0; 1_000], b"\x01\x02\x00\x07\x0a\x5c"] {
        let place = flood(&[], bytes);
        for line in [
            format!("link --to tcp:{place} hello"),
            format!("bridge --nomad tcp:{place}"),
            format!("bridge --nomad tcp:{} --mind tcp:{place}", robot.place),
            format!("run --steps 1 --mind tcp:{place}"),
        ] {
            let _ = gives_up(&program, &line, &place, TIMEOUT);
        }
    }
}

/// The time of the last readable message of a log, s.
fn logged_s(path: &std::path::Path) -> f64 {
    let log = log::read(path).expect("a log");
    let latest = log.messages().map(|message| message.time_ns).max();
    latest.unwrap_or(0) as f64 / 1e9
}

/// The longest time between the first and the last message of a chunk, s: the most that an
/// interruption can lose.
fn longest_chunk_s(path: &std::path::Path) -> f64 {
    let file = std::fs::read(path).expect("a log");
    // MCAP's magic, then records: opcode, length, content. A chunk (6) starts with its times.
    let mut rest = &file[8..];
    let mut longest_ns = 0;
    while let [opcode, number @ ..] = rest
        && let Some((length, content)) = number.split_first_chunk::<8>()
        && let Some((record, behind)) =
            content.split_at_checked(u64::from_le_bytes(*length) as usize)
    {
        if *opcode == 6 {
            let time = |at| u64::from_le_bytes(record[at..at + 8].try_into().expect("8 bytes"));
            longest_ns = longest_ns.max(time(8) - time(0));
        }
        rest = behind;
    }
    longest_ns as f64 / 1e9
}

#[test]
fn a_drive_that_is_killed_is_logged_but_for_two_seconds() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--world room");
    let at = format!("tcp:{}", robot.place);
    let line = format!("bridge --nomad {at} --explore 100 --log drive.mcap");
    let mut bridge = Running::start(&program, &line);
    // Six seconds of the robot's own time, which is real time.
    let path = program.folder().join("drive.mcap");
    let began = Instant::now();
    while !path.exists() {
        assert!(began.elapsed() < TIMEOUT, "no log");
        sleep(Duration::from_millis(10));
    }
    sleep(Duration::from_secs(6));
    bridge.kill();
    let (logged, chunk) = (logged_s(&path), longest_chunk_s(&path));
    assert!(logged >= 3.5, "{logged} s");
    assert!((0.5..1.3).contains(&chunk), "a chunk of {chunk} s");
    let output = program.run(&words("log drive.mcap"));
    assert_eq!(output.code, Some(0), "{}", output.stderr);

    // The same for the page.
    drop(robot);
    let robot = ServedRobot::at_a_port(&program, "--world room");
    let flags = format!("--nomad tcp:{} --log page.mcap", robot.place);
    let viewed = Viewed::start(&program, &flags);
    let (mut steerer, _) = exploring(&viewed);
    let began = Instant::now();
    steerer.wait("now", |_| began.elapsed() > Duration::from_secs(6));
    viewed.kill();
    let logged = logged_s(&program.folder().join("page.mcap"));
    assert!(logged >= 3.5, "{logged} s");
}
