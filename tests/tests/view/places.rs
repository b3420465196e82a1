//! The memory of places on the page.

use super::{fits, keep, keep_aside, number};
use remote::link::{Machine, build_image};
use serde_json::json;
use tests::browser::Browser;
use tests::host_sim;
use tests::viewed::Viewed;

#[test]
fn a_robot_is_led_home_and_the_page_draws_its_places() {
    let program = host_sim!();
    let viewed = Viewed::start(
        &program,
        "--robot p3dx --ranges nomad --behavior home --tour 2000 --world office --speed max --seed 3",
    );
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    page.wait("document.getElementById('places-signs').offsetParent");
    page.wait("document.getElementById('tour').value === '2000'");
    fits(&mut page);
    page.click("#explore");
    page.wait("view.memory.length === 100 && view.now.mode === 'idle'");
    page.click("#learn");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    page.eval("ask('speed', {factor: 40}).then(() => ask('seek'))");
    // From so far away it has to go by a place.
    let far = "(a, b) => Math.hypot(a[0] - b[0], a[1] - b[1])";
    page.wait(&format!(
        "view.now.goal.tour[0] > 60 && ({far})(view.now.pose, view.scene.start) > 4.2"
    ));
    page.click("#pause");
    page.wait("view.now.pace.paused && view.now.way");
    page.wait("document.getElementById('mode').textContent.startsWith('seeks: home, tour ')");
    fits(&mut page);
    its_places_are_drawn(&mut page);
    // The way home begins at once when the tour is over.
    page.eval("document.getElementById('tour').value = '0', document.getElementById('tour').dispatchEvent(new Event('change'))");
    page.wait("view.now.goal.tour[1] === 0");
    let leads_home = format!(
        "!!view.now.way && view.now.way.length > 1 && ({far})(view.now.way.at(-1), view.scene.start) < 0.1"
    );
    // The first decisions may still lead it to where it has not been.
    for step in 0.. {
        assert!(step < 20, "{}", page.eval("view.now.way"));
        let steps = page.eval("view.now.counts.steps");
        page.click("#step");
        page.wait(&format!("view.now.counts.steps > {steps}"));
        if page.eval(&leads_home) == true {
            break;
        }
    }
    page.wait("places.line.getAttribute('d').split('L').length === view.now.way.length + 1");
    keep("view-home.png", &mut page);
    page.eval("ask('speed', {factor: null})");
    page.click("#pause");
    page.wait("view.now.mode === 'stopped' && view.now.note === 'home is reached'");
    page.wait(&format!("({far})(view.now.pose, view.scene.start) < 0.1"));
    page.wait("!places.line.getAttribute('d')");
    a_click_on_the_floor_is_a_goal(&mut page);
    assert_eq!(page.errors(), [""; 0]);
}

/// An emulated chip is the controller.
#[test]
fn a_chip_is_led_home_and_the_page_draws_its_places() {
    let image = build_image(&Machine::OLIMEX_H405_PLACES).unwrap_or_else(|error| panic!("{error}"));
    let image = image.display();
    let flags = "--robot p3dx --behavior home --tour 500 --explore 40 --world office --speed max";
    let flags = format!("{flags} --seed 3 --mind qemu --firmware {image}");
    let viewed = Viewed::start(&host_sim!(), &flags);
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    page.wait("view.now.link === 'qemu' && document.getElementById('places-signs').offsetParent");
    page.click("#explore");
    page.wait("view.memory.length === 40 && view.now.mode === 'idle'");
    page.click("#learn");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    page.click("#seek");
    page.wait("view.places.places.length > 8 && view.now.way");
    page.click("#pause");
    page.wait("view.now.pace.paused");
    its_places_are_drawn(&mut page);
    keep_aside("view-chip-places.png", &mut page);
    page.eval("document.getElementById('tour').value = '0', document.getElementById('tour').dispatchEvent(new Event('change'))");
    page.wait("view.now.goal.tour[1] === 0");
    page.click("#pause");
    page.wait("view.now.mode === 'stopped' && view.now.note === 'home is reached'");
    assert_eq!(page.errors(), [""; 0]);
}

fn its_places_are_drawn(page: &mut Browser) {
    let drawn =
        |name: &str| format!("(places.{name}.getAttribute('d') || '').split('M').length - 1");
    for (name, part) in [
        ("dots", "places"),
        ("links", "links"),
        ("frontiers", "frontiers"),
    ] {
        let count = page.eval(&format!("view.places.{part}.length"));
        assert!(number(&count) > 2.0, "{part}: {count}");
        page.wait(&format!("{} === {count}", drawn(name)));
    }
    // The first place is where the random moves began.
    page.wait("places.dots.getAttribute('d').startsWith('M' + at(view.places.places[0]))");
    page.wait("[0, 1].every((axis) => Math.abs(view.places.places[0][axis] - view.scene.start[axis]) < 0.02)");
    assert_eq!(page.eval("places.next.style.display"), "");
    // A ghost stands where it thinks that it is, if that is elsewhere.
    for (off_m, shown) in [(0.0, "none"), (0.2, "")] {
        page.eval(&format!(
            "showWay({{...view.now, thinks: [view.now.pose[0] + {off_m}, ...view.now.pose.slice(1)]}})"
        ));
        assert_eq!(page.eval("places.ghost.style.display"), shown, "{off_m}");
    }
    // They can be hidden.
    let shown = "['places-layer', 'way-layer'].map((layer) => arena[layer].style.display)";
    assert_eq!(page.eval(shown), json!(["", ""]));
    page.click("#show-places");
    assert_eq!(page.eval(shown), json!(["none", "none"]));
    page.click("#show-places");
    assert_eq!(page.eval(shown), json!(["", ""]));
}

/// The robot goes there. One that is dragged has no other goal, and finds out where it is.
fn a_click_on_the_floor_is_a_goal(page: &mut Browser) {
    let spot = page.eval(
        "(() => { const [x, y] = cm(view.places.places[12]); \
         const p = new DOMPoint(x, y).matrixTransform(arena.root.getScreenCTM()); return [p.x, p.y]; })()",
    );
    let spot = [0, 1].map(|axis| number(&spot[axis]));
    page.drag(spot, spot);
    page.wait("view.now.goal.name === 'a place'");
    let off = |what: &str| {
        format!("Math.hypot(...[0, 1].map((axis) => {what}[axis] - view.places.places[12][axis]))")
    };
    page.wait(&format!("{} < 0.05", off("view.now.goal.place")));
    page.click("#seek");
    page.wait("view.now.mode === 'stopped' && view.now.note === 'a place is reached'");
    page.wait(&format!("{} < 0.15", off("view.now.pose")));
    page.eval("ask('behavior', {name: 'home', tour: 0})");
    page.wait("view.now.goal.name === 'home'");
    let robot = page.middle(".robot .body");
    let before = page.eval("view.now.pose[0]");
    page.drag(robot, [robot[0] + 12.0, robot[1]]);
    page.wait(&format!("view.now.pose[0] !== {before}"));
    page.wait("view.places.places.length === 0 && !places.dots.getAttribute('d')");
    assert_eq!(page.eval("view.now.goal.name"), "home");
    page.eval("ask('speed', {factor: 40}).then(() => ask('seek'))");
    page.wait("view.places.places.length > 32");
    page.click("#pause");
    page.wait("view.now.pace.paused");
    keep_aside("view-set-down.png", page);
    page.eval("ask('speed', {factor: null})");
    page.click("#pause");
    page.wait("view.now.mode === 'stopped' && view.now.note === 'home is reached'");
    page.wait(
        "Math.hypot(...[0, 1].map((axis) => view.now.pose[axis] - view.scene.start[axis])) < 0.3",
    );
}

#[test]
fn a_robot_without_places_is_not_sent_home() {
    let program = host_sim!();
    let viewed = Viewed::start(&program, "--world room --speed max");
    let mut page = Browser::open(&viewed.steer);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    let home = "document.querySelector(\"#behavior option[value='home']\")";
    page.wait(&format!("{home}.disabled"));
    let said = page.eval(&format!("{home}.textContent"));
    assert_eq!(said, "home: needs a memory of places (view --places on)");
    for absent in ["places-signs", "tour-choice"] {
        let seen = format!("!!document.getElementById('{absent}').offsetParent");
        assert_eq!(page.eval(&seen), false, "{absent}");
    }
    // A click on the floor is none.
    page.click("#arena");
    page.click("#explore");
    page.wait("view.memory.length > 5");
    assert_eq!(page.eval("view.now.goal.name"), "avoid");
    assert_eq!(page.eval("document.getElementById('notice').hidden"), true);
    fits(&mut page);
    assert_eq!(page.errors(), [""; 0]);
}

/// A robot that drove around was carried elsewhere: the recording shows where its places are, where
/// it thinks that it is, and the way on which they lead it.
#[test]
fn a_recording_draws_the_places_of_its_robot() {
    let program = host_sim!();
    let run = "run --robot p3dx --ranges nomad --behavior nest --tour 200 --world office --seed 3";
    let said = program.ok(&format!("{run} --log a.mcap"));
    assert!(said.contains("office"), "{said}");
    let viewed = Viewed::start(&program, "--replay a.mcap --speed 10");
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    page.click("#pause");
    page.wait("view.now.pace.paused");
    page.eval("ask('jump', {to: 200})");
    page.wait("view.now.at === 200 && view.now.way");
    its_places_are_drawn(&mut page);
    page.wait("view.scene.sensors.length === 16 && view.now.beams_m.length === 16");
    keep_aside("view-replay-places.png", &mut page);
    // It has been carried, and does not know yet where it is.
    for at in (300..).step_by(2) {
        assert!(at < 400, "it guesses nothing");
        page.eval(&format!("ask('jump', {{to: {at}}})"));
        page.wait(&format!("view.now.at === {at}"));
        if page.eval("view.places.guesses.length > 3") == true {
            break;
        }
    }
    page.wait("document.querySelectorAll('.guess').length === view.places.guesses.length");
    fits(&mut page);
    keep("view-lost.png", &mut page);
    page.eval("document.getElementById('at').focus()");
    page.press("End", "End");
    page.wait("view.now.note === 'The recording ends here'");
    // It has found out where it is, and is at its nest.
    let off = |from: &str| {
        format!("Math.hypot(...[0, 1].map((axis) => view.now.pose[axis] - {from}[axis])) < 0.3")
    };
    page.wait(&off("view.now.thinks"));
    page.wait(&off("view.scene.start"));
    fits(&mut page);
    keep_aside("view-replay-nest.png", &mut page);
    assert_eq!(page.errors(), [""; 0]);
}
