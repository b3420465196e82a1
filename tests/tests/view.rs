//! The view in a real browser, and with clients that must be refused.

use amp::config::Config;
use remote::link::NodeServer;
use serde_json::{Value, json};
use std::fs;
use std::time::{Duration, Instant};
use tests::browser::Browser;
use tests::nomad::ServedRobot;
use tests::viewed::{Viewed, Viewer, is_idle};
use tests::{host_sim, root};

mod places;
mod senses;

/// Saves a screenshot to the documentation if `UPDATE_PICTURES=1`, else nowhere.
fn keep(name: &str, browser: &mut Browser) {
    let picture = browser.picture();
    assert!(picture.len() > 20_000, "{name}: an empty picture");
    if std::env::var_os("UPDATE_PICTURES").is_some() {
        let path = root().join("docs/pictures").join(name);
        fs::write(path, picture).expect("a picture in docs/pictures");
    }
}

/// Saves a screenshot for inspection, in the folder VIEW_PICTURES.
fn keep_aside(name: &str, browser: &mut Browser) {
    let picture = browser.picture();
    assert!(picture.len() > 20_000, "{name}: an empty picture");
    if let Some(folder) = std::env::var_os("VIEW_PICTURES") {
        fs::write(std::path::Path::new(&folder).join(name), picture).expect("a picture");
    }
}

/// Checks that nothing extends beyond the window and no text is cut off.
fn fits(browser: &mut Browser) {
    let wide = browser.eval("document.documentElement.scrollWidth - window.innerWidth");
    assert!(wide.as_f64() <= Some(0.0), "{wide} px too wide");
    let cut = browser.eval(
        "[...document.querySelectorAll('button, h2, dd, .chip, .legend span')]\
         .filter(e => e.offsetParent && e.scrollWidth > e.clientWidth + 1 && e.clientWidth > 0 && getComputedStyle(e).display !== 'inline')\
         .map(e => e.id || e.textContent)",
    );
    assert_eq!(cut, json!([]), "cut off");
}

#[test]
fn a_person_explores_learns_seeks_and_stops() {
    let program = host_sim!();
    let viewed = Viewed::start(
        &program,
        "--world random:7 --explore 60 --speed max --seed 5",
    );
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    assert_eq!(
        page.eval("location.hash"),
        "",
        "the token stays in the address"
    );
    page.wait("document.getElementById('situations-empty').offsetParent");
    page.wait("document.getElementById('seek').disabled");
    fits(&mut page);

    page.click("#explore");
    page.wait("view.now.mode === 'explore' || view.memory.length === 60");
    page.wait("view.memory.length === 60 && view.now.mode === 'idle'");
    assert_eq!(
        page.eval("document.querySelectorAll('#samples tr').length"),
        60
    );
    page.click("#learn");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    assert_eq!(
        page.eval("view.maps.situations.hits.reduce((a, b) => a + b)"),
        60
    );
    page.click("#seek");
    page.wait("view.now.mode === 'seek' && view.now.counts.steps > 20");
    page.wait(
        "view.now.plan && document.getElementById('delta').getBoundingClientRect().height > 50",
    );

    // One click stops, and so does the space bar, wherever the focus is.
    page.click("#stop");
    page.wait("view.now.mode === 'stopped' && view.now.pace.standing");
    let stood = page.eval("view.now.counts.steps");
    page.click("#resume");
    page.wait(&format!(
        "view.now.mode === 'seek' && view.now.counts.steps > {stood}"
    ));
    page.eval("document.getElementById('explore').focus()");
    page.press(" ", "Space");
    page.wait("view.now.mode === 'stopped'");

    // Selects a neuron as the goal.
    page.eval("document.getElementById('speed').value = '4', document.getElementById('speed').dispatchEvent(new Event('change'))");
    page.click("[data-neuron='9']");
    page.wait("view.now.goal.neuron === 9");
    page.click("#seek");
    page.wait("view.now.mode === 'seek' && document.querySelectorAll('.tile .goal')[9].style.display === ''");
    page.wait("view.now.plan.walk.length >= 1 && view.now.goal.name === 'neuron N10'");

    an_obstacle_in_the_way(&mut page);
    by_keyboard(&mut page);
    pictures(&mut page);
    assert_eq!(page.errors(), [""; 0]);
    let own = page
        .requests()
        .iter()
        .filter(|url| !url.starts_with(&viewed.watch));
    let foreign: Vec<_> = own.filter(|url| !url.starts_with("data:")).collect();
    assert!(foreign.is_empty(), "{foreign:?}");
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Drags a box into the path: the ring measures it there.
fn an_obstacle_in_the_way(page: &mut Browser) {
    page.press(" ", "Space");
    page.wait("view.now.pace.standing");
    let from = page.middle(".thing.loose");
    let robot = page.eval(
        "(() => { const r = arena.robot.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2, r.width]; })()",
    );
    let [x, y, wide] = [0, 1, 2].map(|place| number(&robot[place]));
    let shape = page.eval("document.querySelector('.thing.loose').dataset.shape");
    let shape = shape.as_str().expect("a number").to_owned();
    let before = page.eval(&format!("JSON.stringify(view.scene.shapes[{shape}])"));
    let least = "Math.min(...view.now.ranges_m.filter(m => m !== null))";
    // There is free space toward the middle of the arena.
    let center = page.middle("#arena");
    let side = if center[0] > x { 1.0 } else { -1.0 };
    page.drag(from, [x + side * wide * 1.7, y]);
    page.wait(&format!(
        "JSON.stringify(view.scene.shapes[{shape}]) !== {before}"
    ));
    page.wait(&format!("{least} < 0.8"));
    page.click("#seek");
    page.wait("view.now.mode === 'seek'");
}

/// Sonars, switches and tiles react to keys.
fn by_keyboard(page: &mut Browser) {
    page.eval("document.querySelector('[data-sonar=\"0\"]').focus()");
    page.press("ArrowLeft", "ArrowLeft");
    page.press("Enter", "Enter");
    page.wait("view.now.on[1] === false");
    page.press("Enter", "Enter");
    page.wait("view.now.on[1] === true");
    page.eval("document.querySelector('[data-neuron=\"0\"]').focus()");
    page.press("ArrowRight", "ArrowRight");
    assert_eq!(page.eval("document.activeElement.dataset.neuron"), "1");
    page.press("Enter", "Enter");
    page.wait("view.now.goal.neuron === 1");
}

fn pictures(page: &mut Browser) {
    page.eval("ask('reset', {seed: 18, world: 'paper', preset: 'default'})");
    page.wait("view.scene.world === 'paper' && view.scene.seed === '18'");
    page.eval("ask('behavior', {name: 'avoid'}).then(() => ask('speed', {factor: null})).then(() => ask('explore'))");
    page.wait("view.memory.length === 60 && view.now.mode === 'idle'");
    page.eval("ask('learn')");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    page.eval("ask('seek').then(() => ask('speed', {factor: 10}))");
    page.wait(
        "view.now.counts.steps > 60 && !view.now.plan.at_goal && view.now.plan.walk.length > 1",
    );
    page.eval("ask('pause', {paused: true})");
    page.wait("view.now.pace.paused");
    page.eval("document.activeElement.blur(), document.getElementById('notice').hidden = true");
    fits(page);
    keep("view-light.png", page);
    page.set_dark(true);
    std::thread::sleep(Duration::from_millis(150));
    keep("view-dark.png", page);
    page.resize(390, 844);
    page.eval("window.scrollTo(0, 0)");
    std::thread::sleep(Duration::from_millis(150));
    fits(page);
    page.set_dark(false);
    std::thread::sleep(Duration::from_millis(150));
    keep("view-phone.png", page);
    for i in 1..5 {
        page.eval(&format!("window.scrollTo(0, {})", i * 640));
    }
}

/// A log on the same page: played, paused, sought, to its end.
/// The robot is told nothing of its 16 sensors, whose wires are permuted.
#[test]
fn a_robot_finds_its_sensors_and_the_page_draws_them() {
    let program = host_sim!();
    let viewed = Viewed::start(
        &program,
        "--robot p3dx --geometry learned --scramble 1 --world random:7 --explore 60 --speed max --seed 5",
    );
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    page.wait("document.getElementById('body-card').offsetParent");
    fits(&mut page);
    page.click("#explore");
    // 12 of the moves are for the sensors.
    page.wait("view.memory.length === 48 && view.now.mode === 'idle'");
    page.click("#learn");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    // The maps may come before the state in which the last moves count for the sensors.
    page.wait(
        "parseFloat(document.getElementById('body-detail').textContent.split(' ').pop()) < 12",
    );
    assert_eq!(page.eval("view.now.found.filter((s) => s).length"), 16);
    assert_eq!(page.eval("view.scene.sensors.length"), 16);
    let said = page.eval("document.getElementById('body-detail').textContent");
    let said = said.as_str().expect("a sentence").to_owned();
    let words: Vec<_> = said.split_whitespace().collect();
    assert_eq!(words[..3], ["16", "of", "16"], "{said}");
    let worst: f64 = words
        .last()
        .expect("degrees")
        .trim_end_matches('°')
        .parse()
        .expect("a number");
    assert!(worst > 0.5, "{said}");
    page.click("#seek");
    page.wait("view.now.counts.steps > 20");
    assert_eq!(page.eval("view.now.counts.contacts"), 0);
    assert_eq!(
        page.eval("arena.beams.filter((b) => b.getAttribute('d')).length"),
        16
    );
    assert_eq!(page.errors(), [""; 0]);
}

/// A memory of places leads the robot. The page draws what it remembers and the way that it is led.
#[test]
fn a_recording_is_played_back_and_forth() {
    let program = host_sim!();
    let run =
        program.ok("run --world paper --explore 60 --steps 240 --seed 18 --log a.mcap --json");
    assert!(run.contains("\"steps\":240"), "{run}");
    let viewed = Viewed::start(&program, "--replay a.mcap --speed 10");
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    page.wait("view.now.at > 3");
    for absent in ["stop", "explore", "seek", "here", "reset", "behavior"] {
        let seen = format!("!!document.getElementById('{absent}').offsetParent");
        assert_eq!(page.eval(&seen), false, "{absent}");
    }
    page.click("#pause");
    page.wait("view.now.pace.paused");
    let at = page.eval("view.now.at");
    page.click("#step");
    page.wait(&format!("view.now.at === {at} + 1"));
    page.click("#back");
    page.wait(&format!("view.now.at === {at}"));
    // A click on the time line seeks, and so does the slider.
    let jump = |share: &str| {
        format!(
            "(() => {{ const r = trail.root.getBoundingClientRect(); \
             const x = trail.scale.left + trail.scale.step * trail.marks.length * {share}; \
             return [r.x + x, r.y + r.height / 2]; }})()"
        )
    };
    page.middle("#trail");
    let spot = page.eval(&jump("0.75"));
    let spot = [0, 1].map(|axis| number(&spot[axis]));
    page.drag(spot, spot);
    page.wait("view.now.at > 215 && view.now.at < 235 && view.now.mode === 'seek'");
    page.wait("view.maps.learned && view.now.plan && view.now.counts.steps > 150");
    page.eval("document.getElementById('at').focus()");
    page.press("Home", "Home");
    page.wait("view.now.at === 0 && !view.maps.learned");
    page.press("End", "End");
    page.wait("view.now.at === trail.marks.length");
    page.eval("ask('jump', {to: 190})");
    page.wait("view.now.at === 190");
    page.eval("document.activeElement.blur(), document.getElementById('notice').hidden = true");
    page.wait("document.querySelectorAll('.path.seek').length > 0");
    recording_pictures(&mut page);
    // The space bar resumes it; at the end the page shows it.
    page.eval("ask('speed', {factor: null})");
    page.press(" ", "Space");
    page.wait("view.now.pace.standing && view.now.at === trail.marks.length");
    page.wait("document.getElementById('note').textContent.startsWith('The recording ends here')");
    fits(&mut page);
    page.click("#pause");
    page.wait("view.now.pace.standing === false || view.now.at === trail.marks.length");
    assert_eq!(page.errors(), [""; 0]);
}

fn recording_pictures(page: &mut Browser) {
    fits(page);
    keep("view-replay.png", page);
    page.set_dark(true);
    std::thread::sleep(Duration::from_millis(150));
    keep_aside("view-replay-dark.png", page);
    page.resize(390, 844);
    page.eval("document.querySelector('.trail').scrollIntoView({block: 'end'})");
    std::thread::sleep(Duration::from_millis(150));
    fits(page);
    keep_aside("view-replay-phone-dark.png", page);
    page.set_dark(false);
    page.eval("window.scrollTo(0, 0)");
    std::thread::sleep(Duration::from_millis(150));
    keep_aside("view-replay-phone.png", page);
    page.resize(1400, 900);
}

/// A robot behind its own protocol: its echoes are the only map of its surroundings.
#[test]
fn a_nomad_explores_learns_and_seeks_and_stops() {
    let program = host_sim!();
    let robot = ServedRobot::at_a_port(&program, "--speed 20 --world room");
    let flags = format!("--nomad tcp:{} --explore 10 --log nomad.mcap", robot.place);
    let viewed = Viewed::start(&program, &flags);
    let mut steerer = viewed.steerer();
    let scene = steerer.latest("scene");
    assert_eq!(scene["shapes"], json!([]));
    assert_eq!(scene["abilities"]["pace"], false);
    for order in [
        json!({"do": "pause", "paused": true}),
        json!({"do": "step"}),
        json!({"do": "reset"}),
        json!({"do": "move_robot", "x": 0.0, "y": 0.0}),
        json!({"do": "seek"}),
        json!({"do": "behavior", "name": "follow"}),
    ] {
        assert!(steerer.order(order.clone()).is_err(), "{order}");
    }
    steerer.explore_and_learn(10);
    steerer.wait("heard", |spots| {
        spots.as_array().is_some_and(|spots| spots.len() > 5)
    });
    steerer.order(json!({"do": "seek"})).expect("it seeks");
    steerer.decided(6);
    steerer.wait("now", |now| {
        let moved = now["counts"]["distance_m"].as_f64() > Some(0.2);
        moved && now["plan"].is_object() && now["link"].is_string()
    });
    nomad_pictures(&viewed, &mut steerer);
    steerer.order(json!({"do": "stop"})).expect("it stops");
    steerer.wait("now", |now| {
        now["mode"] == "stopped" && now["resumes"] == true
    });
    steerer
        .order(json!({"do": "sonar", "number": 2, "on": false}))
        .expect("it stands and is told");
    steerer.order(json!({"do": "resume"})).expect("it goes on");
    steerer.decided(9);
    assert_eq!(viewed.end(), Some(0));
    let said = program.ok("replay nomad.mcap");
    assert!(said.contains("every one identical"), "{said}");
    // The base stands still after braking, and so do its wheels: the next client finds it so.
    std::thread::sleep(Duration::from_millis(1_700));
    let mut host = robot.connect();
    let state = host.request(&nomad200::NomadCommand::GetState);
    assert!(tests::nomad::stands(state.expect("an answer")));
}

fn nomad_pictures(viewed: &Viewed, steerer: &mut Viewer) {
    if std::env::var_os("UPDATE_PICTURES").is_none() {
        return;
    }
    let mut page = Browser::open(&viewed.watch);
    page.resize(1400, 900);
    // The robot stops when nobody steers it for 2 s.
    steerer.wait("now", |now| now["counts"]["steps"].as_u64() > Some(40));
    page.wait("view.now && view.now.counts.steps > 40");
    fits(&mut page);
    keep("view-nomad.png", &mut page);
    assert_eq!(page.errors(), [""; 0]);
}

/// A controller by its own clock, whose ring has no echoes: it learns, and stops for that reason.
#[test]
fn a_board_is_taught_and_steered_over_its_link() {
    let program = host_sim!();
    let viewed = Viewed::start(&program, "--explore 20 --speed max --world room");
    let mut steerer = viewed.steerer();
    steerer.explore_and_learn(20);
    let saved = steerer.order(json!({"do": "save_mind"})).expect("a mind");
    let hex = saved["file"]["hex"].clone();
    let maps = steerer.latest("maps");
    drop(viewed);

    let served = NodeServer::with_ring(Config::recommended()).expect("a mind behind a socket");
    let flags = format!("--board tcp:{} --explore 20", served.host());
    let viewed = Viewed::start(&program, &flags);
    let mut steerer = viewed.steerer();
    steerer.wait("now", |now| now["note"].is_null());
    let scene = steerer.latest("scene");
    assert_eq!(scene["abilities"]["unplaced"], true);
    steerer.wait("maps", |maps| maps["learned"] == false);
    for order in [
        json!({"do": "seek"}),
        json!({"do": "goal_neuron", "neuron": 3}),
        json!({"do": "pause", "paused": true}),
        json!({"do": "sonar", "number": 3, "on": false}),
        json!({"do": "load_mind", "hex": "00"}),
    ] {
        assert!(steerer.order(order.clone()).is_err(), "{order}");
    }
    let load = json!({"do": "load_mind", "hex": hex});
    steerer.order(load).expect("it takes the file");
    steerer.wait("maps", |maps| maps["learned"] == true);
    steerer.wait("memory", |rows| {
        rows.as_array().is_some_and(|rows| rows.len() == 20)
    });
    let taken = steerer.latest("maps");
    for map in ["situations", "changes"] {
        assert_eq!(taken[map]["code"], maps[map]["code"], "{map}");
    }
    let moment = steerer.moment();
    steerer.order(json!({"do": "learn"})).expect("it learns");
    steerer.wait_after(moment, "now", is_idle);
    let neuron = json!({"do": "goal_neuron", "neuron": 3});
    // The last shown state may be from before it learned.
    while steerer.order(neuron.clone()).is_err() {
        std::thread::sleep(Duration::from_millis(50));
    }
    steerer.order(json!({"do": "seek"})).expect("it seeks");
    steerer.wait("now", |now| {
        let note = now["note"].as_str().unwrap_or_default();
        now["mode"] == "stopped" && note.contains("a sonar did not report")
    });
    board_page(&viewed);
    drop(served);
    steerer.wait("now", |now| {
        now["mode"] == "failed" && now["why"].is_string()
    });
}

#[test]
fn a_board_without_sonars_says_that_it_will_not_move() {
    let program = host_sim!();
    let served = NodeServer::start(Config::recommended()).expect("a mind behind a socket");
    let viewed = Viewed::start(&program, &format!("--board tcp:{}", served.host()));
    viewed.steerer().wait("now", |now| {
        let note = now["note"].as_str().unwrap_or_default();
        note.contains("no sonars of its own")
    });
}

fn board_page(viewed: &Viewed) {
    let mut page = Browser::open(&viewed.watch);
    page.resize(1400, 900);
    page.wait("view.now && view.now.mode === 'stopped' && view.maps.learned");
    page.wait("!document.getElementById('arena-card').offsetParent");
    fits(&mut page);
    keep_aside("view-board.png", &mut page);
    assert_eq!(page.errors(), [""; 0]);
}

#[test]
fn what_cannot_be_watched_is_refused_in_one_sentence() {
    let program = host_sim!();
    program.put("text.mcap", "not a log");
    for (flags, word) in [
        ("--replay none.mcap", "none.mcap"),
        ("--replay text.mcap", "MCAP"),
        ("--replay text.mcap --world room", "--world"),
        ("--nomad tcp:127.0.0.1:1 --log new.mcap", "tcp:127.0.0.1:1"),
        ("--nomad tcp:127.0.0.1:1 --preset touzet", "touzet"),
        ("--nomad tcp:127.0.0.1:1 --speed 2", "--speed"),
        ("--board tcp:127.0.0.1:1", "tcp:127.0.0.1:1"),
        ("--board qemu --nomad tcp:127.0.0.1:1", "--nomad"),
        ("--log text.mcap", "there already"),
    ] {
        let output = program.run(&tests::words(&format!("view --listen 127.0.0.1:0 {flags}")));
        assert_eq!(
            (output.code, output.stdout.as_str()),
            (Some(2), ""),
            "{flags}"
        );
        assert!(output.stderr.contains(word), "{flags}: {}", output.stderr);
    }
    assert!(!program.folder().join("new.mcap").exists());
}

#[test]
fn strangers_are_refused_and_watchers_cannot_steer() {
    let program = host_sim!();
    let viewed = Viewed::start(&program, "--explore 5");
    let own = format!("http://{}", viewed.host());
    assert!(viewed.knock(&[("Origin", &own)]).is_ok());
    for foreign in [
        "http://evil.example",
        "null",
        "http://127.0.0.1",
        "https://localhost",
    ] {
        assert_eq!(
            viewed.knock(&[("Origin", foreign)]).err(),
            Some(403),
            "{foreign}"
        );
    }
    // A foreign host name that resolves to this machine.
    let port = viewed.host().rsplit(':').next().expect("a port");
    let name = format!("evil.example:{port}");
    assert_eq!(viewed.knock(&[("Host", &name)]).err(), Some(403));
    let own_name = format!("http://{name}");
    let both = [("Host", name.as_str()), ("Origin", own_name.as_str())];
    assert_eq!(viewed.knock(&both).err(), Some(403));

    let mut watcher = viewed.viewer();
    watcher.wait("now", |now| now["mode"] == "idle");
    for order in ["explore", "stop", "learn", "reset", "save_mind"] {
        let refused = watcher.order(json!({"do": order})).expect_err(order);
        assert!(refused.contains("take control"), "{order}: {refused}");
    }
    for token in ["", "0", &"0".repeat(32)] {
        let refused = watcher.order(json!({"do": "steer", "token": token, "over": true}));
        assert!(refused.expect_err(token).contains("not the token"));
    }
    // One viewer steers; the other sees it, may take over, and may always stop.
    let mut first = viewed.steerer();
    watcher.wait("seat", |seat| seat["taken"] == true && seat["you"] == false);
    let token = viewed.token();
    let refused = watcher.order(json!({"do": "steer", "token": token}));
    assert_eq!(refused, Err("another viewer steers".to_owned()));
    first.order(json!({"do": "explore"})).expect("it explores");
    assert!(watcher.order(json!({"do": "explore"})).is_err());
    watcher.order(json!({"do": "stop"})).expect("it stops");
    first.wait("now", |now| now["mode"] == "stopped");
    let over = json!({"do": "steer", "token": token, "over": true});
    watcher.order(over).expect("the seat");
    first.wait("seat", |seat| seat["you"] == false && seat["taken"] == true);
    assert!(first.order(json!({"do": "explore"})).is_err());
    drop(watcher);
    first.wait("seat", |seat| seat["taken"] == false);
}

/// Explores, learns and takes thirty decisions; returns the controller's state.
fn learned(viewed: &Viewed) -> Value {
    let mut steerer = viewed.steerer();
    steerer
        .order(json!({"do": "explore"}))
        .expect("it explores");
    steerer.wait("now", |now| {
        now["mode"] == "idle" && now["counts"]["explored"][0] == 40
    });
    steerer.order(json!({"do": "learn"})).expect("it learns");
    let learned = steerer.wait_after(0, "maps", |maps| maps["learned"] == true);
    steerer.wait_after(learned, "now", is_idle);
    steerer
        .order(json!({"do": "pause", "paused": true}))
        .expect("it pauses");
    steerer.order(json!({"do": "seek"})).expect("it seeks");
    for step in 1..=30 {
        steerer.order(json!({"do": "step"})).expect("a step");
        steerer.wait("now", |now| {
            now["counts"]["steps"].as_u64() >= Some(step - 1) && now["pace"]["paused"] == true
        });
    }
    let saved = steerer.order(json!({"do": "save_mind"})).expect("a mind");
    saved["file"]["hex"].clone()
}

#[test]
fn fifty_viewers_and_a_slow_one_change_nothing() {
    let flags = "--explore 40 --speed max --sonar nomad --seed 9";
    let program = host_sim!();
    let alone = learned(&Viewed::start(&program, flags));
    let viewed = Viewed::start(&program, flags);
    let mut viewers: Vec<_> = (0..50).map(|_| viewed.viewer()).collect();
    // It requests dozens of files and reads none of them.
    let mut slow = viewed.viewer();
    let token = viewed.token();
    slow.order(json!({"do": "steer", "token": token}))
        .expect("the seat");
    for _ in 0..400 {
        slow.send(json!({"do": "save_mind"}));
    }
    slow.send(json!({"do": "leave"}));
    let began = Instant::now();
    let mut other = viewed.viewer();
    let over = json!({"do": "steer", "token": token, "over": true});
    other.order(over).expect("the seat");
    other.order(json!({"do": "leave"})).expect("it rises");
    assert!(
        began.elapsed() < Duration::from_secs(3),
        "the slow one was waited for"
    );
    assert_eq!(learned(&viewed), alone);
    for viewer in &mut viewers {
        viewer.wait("now", |now| now["counts"]["steps"].as_u64() >= Some(29));
    }
    // The slow one is disconnected: 50 viewers and this one remain.
    other.wait("seat", |seat| seat["viewers"].as_u64() <= Some(51));
}

#[test]
fn a_mind_at_the_end_of_a_link_is_watched_until_it_is_lost() {
    let served = NodeServer::start(Config::recommended()).expect("a mind behind a socket");
    let program = host_sim!();
    let flags = format!("--explore 6 --speed max --mind tcp:{}", served.host());
    let viewed = Viewed::start(&program, &flags);
    let mut steerer = viewed.steerer();
    steerer.wait("scene", |scene| scene["abilities"]["load"] == false);
    steerer
        .order(json!({"do": "explore"}))
        .expect("it explores");
    steerer.wait("memory", |rows| {
        rows.as_array().is_some_and(|rows| rows.len() == 6)
    });
    steerer.order(json!({"do": "learn"})).expect("it learns");
    steerer.wait("maps", |maps| maps["learned"] == true);
    let seek = json!({"do": "seek"});
    while steerer.order(seek.clone()).is_err() {
        std::thread::sleep(Duration::from_millis(50));
    }
    let linked = |now: &Value| {
        now["link"]
            .as_str()
            .is_some_and(|link| link.starts_with("tcp:"))
    };
    steerer.wait("now", |now| {
        now["counts"]["steps"].as_u64() > Some(3) && linked(now)
    });
    drop(served);
    steerer.wait("now", |now| {
        now["mode"] == "failed" && now["why"].is_string()
    });
    let refused = steerer.order(seek).expect_err("the mind is gone");
    assert!(refused.contains("restart"), "{refused}");
}
