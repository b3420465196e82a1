//! What can be perceived beside ranges, on the page.

use super::{fits, keep, number};
use tests::browser::Browser;
use tests::host_sim;
use tests::viewed::Viewed;

#[test]
fn a_robot_finds_a_scent_and_the_page_draws_it() {
    let program = host_sim!();
    let viewed = Viewed::start(
        &program,
        "--robot p3dx --ranges nomad --behavior scent:strongest --tour 1000 --world office --speed max --seed 4",
    );
    let mut page = Browser::open(&viewed.steer);
    page.set_dark(false);
    page.resize(1400, 900);
    page.wait("document.getElementById('seat').textContent.startsWith('you steer')");
    // The office has no scent: one is put into it, where it can be dragged.
    page.wait("view.scene.sources.length === 1 && document.querySelectorAll('.source.scent.loose').length === 1");
    let source = page.middle(".source .mark");
    let before = page.eval("view.scene.sources[0].at");
    page.drag(source, [source[0] + 20.0, source[1]]);
    page.wait(&format!(
        "view.scene.sources[0].at[0] > {} + 0.05",
        number(&before[0])
    ));
    page.click("#explore");
    page.wait("view.memory.length === 100 && view.now.mode === 'idle'");
    page.click("#learn");
    page.wait("view.maps.learned && view.now.mode === 'idle'");
    page.eval("ask('speed', {factor: 100}).then(() => ask('seek'))");
    page.wait("view.now.goal.tour[0] > 450");
    page.eval("ask('speed', {factor: 40})");
    page.click("#pause");
    page.wait("view.now.pace.paused && view.places.sensed.length > 40");
    page.wait("document.querySelectorAll('.felt').length === view.places.sensed.length");
    // It remembers the strongest where it is strongest.
    let off = "(place) => Math.hypot(...[0, 1].map((axis) => place[axis] - view.scene.sources[0].at[axis]))";
    let strongest = "view.places.sensed.reduce((most, one) => one[1] > most[1] ? one : most)[0]";
    page.wait(&format!("({off})({strongest}) < 0.6"));
    page.wait(
        "[...document.querySelectorAll('#counts dt')].some((name) => name.textContent === 'scent')",
    );
    fits(&mut page);
    keep("view-scent.png", &mut page);
    page.eval("ask('speed', {factor: null})");
    page.click("#pause");
    page.wait("view.now.mode === 'stopped' && view.now.note === 'scent:strongest is reached'");
    page.wait(&format!("({off})(view.now.pose) < 0.6"));
    // A color that the office does not have.
    page.eval("ask('behavior', {name: 'floor:red', tour: 0})");
    page.wait("view.scene.sources.map((one) => one.kind).join() === 'floor,scent'");
    page.wait("document.querySelectorAll('.source').length === 2");
    assert_eq!(page.errors(), [""; 0]);
}
