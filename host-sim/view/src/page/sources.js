// What else can be perceived: colored floor, scents, lamps, and where the robot remembers them.
const sources = { all: [] };

const SOURCE_NAMES = { floor: "Colored floor", scent: "Scent", light: "Lamp" };

function buildSources() {
  sources.layer = arena["sources-layer"];
  sources.felt = svg("g", { "pointer-events": "none" }, arena["places-layer"]);
}

function showSources(scene) {
  const loose = scene.abilities.carry;
  const same = sources.world === scene.world && sources.all.length === scene.sources.length
    && sources.all.every(({ kind }, index) => kind === scene.sources[index].kind);
  if (!same) {
    sources.layer.replaceChildren();
    sources.world = scene.world;
    sources.all = scene.sources.map((source, index) => {
      const group = svg("g", { class: `source ${source.kind}${loose ? " loose" : ""}` }, sources.layer);
      const rings = source.kind === "floor" ? [] : [1, 0.5, 0.25].map(() => svg("circle", { class: "reach", "pointer-events": "none" }, group));
      const mark = svg(source.kind === "floor" ? "polygon" : "circle", { class: "mark" }, group);
      if (loose) {
        set(group, { tabindex: 0, role: "button", "data-source": index });
        grabbable(group, () => ({ what: "move_source", source: index, at: view.scene.sources[index].at }));
      }
      return { kind: source.kind, group, rings, mark };
    });
  }
  const u = arena.unit;
  scene.sources.forEach((source, index) => {
    const { group, rings, mark } = sources.all[index];
    if (arena.drag && arena.drag.element === group) return;
    set(group, { transform: "", "aria-label": `${SOURCE_NAMES[source.kind]} at ${source.at.map((v) => fixed(v, 2)).join(", ")} m: arrow keys move it` });
    const [cx, cy] = cm(source.at);
    rings.forEach((ring, place) => set(ring, { cx, cy, r: 100 * source.reach_m * [1, 0.5, 0.25][place], "stroke-width": u }));
    if (source.kind === "floor") set(mark, { points: list(source.outline), fill: source.color });
    else set(mark, { cx, cy, r: 7 * u, "stroke-width": 1.6 * u });
  });
}

// Where what is sought was perceived: the darker, the stronger.
function showFelt() {
  if (!view.places || !view.scene) return;
  const u = arena.unit;
  const felt = view.places.sensed;
  $("felt-sign").hidden = !felt.length;
  while (sources.felt.children.length > felt.length) sources.felt.lastChild.remove();
  while (sources.felt.children.length < felt.length) svg("circle", { class: "felt" }, sources.felt);
  felt.forEach(([place, strength], index) => {
    const [cx, cy] = cm(place);
    set(sources.felt.children[index], { cx, cy, r: 6 * u, "fill-opacity": (0.75 * strength).toFixed(2) });
  });
}

buildSources();
showers.scene.push(showSources);
showers.places.push(showFelt);
showers.scene.push(showFelt);
