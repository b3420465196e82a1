// Both maps as tiles: rosettes of situations, or of changes with the action as an arrow.
const maps = { situations: [], changes: [], shown: { situations: null, changes: null } };

function buildMap(name) {
  const root = $(name);
  const can = name === "situations";
  const letter = can ? "N" : "A";
  maps[name] = Array.from({ length: 16 }, (_, neuron) => {
    const [x, y] = [100 * (neuron % 4), 100 * Math.floor(neuron / 4)];
    const group = svg("g", { class: `tile${can ? " can" : ""}`, tabindex: neuron ? -1 : 0, role: can ? "button" : "img", transform: `translate(${x} ${y})`, "data-neuron": neuron }, root);
    const tile = { group, back: svg("rect", { class: "back", x: 1.5, y: 1.5, width: 97, height: 97 }, group) };
    svg("circle", { class: "rim", cx: 50, cy: 55, r: 38 }, group);
    tile.now = svg("circle", { class: "now", cx: 50, cy: 55, r: 10 }, group);
    tile.up = svg("path", { class: can ? "bars" : "bars up" }, group);
    tile.down = svg("path", { class: "bars down" }, group);
    svg("circle", { class: "hub", cx: 50, cy: 55, r: can ? 38 * 0.27 : 38 * 0.62 }, group);
    tile.rim = svg("path", { class: "arrow rim", "stroke-width": 5 }, group);
    tile.arrow = svg("path", { class: "arrow", "stroke-width": 2.4 }, group);
    svg("text", { x: 8, y: 17, "font-size": 13.5, "font-weight": 600 }, group).textContent = `${letter}${neuron + 1}`;
    tile.hits = svg("text", { x: 92, y: 17, "font-size": 13, class: "quiet", "text-anchor": "end" }, group);
    tile.next = svg("rect", { class: "next", x: 4, y: 4, width: 92, height: 92 }, group);
    tile.goal = svg("rect", { class: "goal", x: 3, y: 3, width: 94, height: 94 }, group);
    tile.trained = svg("rect", { class: "trained", x: 9, y: 9, width: 82, height: 82 }, group);
    for (const mark of ["now", "next", "goal", "trained"]) tile[mark].style.display = "none";
    if (can) group.addEventListener("click", () => chooseGoal(neuron));
    group.addEventListener("keydown", (event) => mapKey(event, name, neuron));
    for (const kind of ["pointerenter", "focus"]) group.addEventListener(kind, () => look(name, neuron));
    for (const kind of ["pointerleave", "blur"]) group.addEventListener(kind, () => look(name, null));
    return tile;
  });
  if (!can) return;
  maps.walkRim = svg("path", { class: "walk rim", "pointer-events": "none" }, root);
  maps.walk = svg("path", { class: "walk", "pointer-events": "none" }, root);
}

function mapKey(event, name, neuron) {
  const step = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -4, ArrowDown: 4 }[event.key];
  const sideways = step && Math.abs(step) === 1;
  const next = neuron + (step || 0);
  if (event.key === "Enter" && name === "situations") chooseGoal(neuron);
  else if (step && next >= 0 && next < 16 && !(sideways && Math.floor(next / 4) !== Math.floor(neuron / 4))) {
    set(maps[name][neuron].group, { tabindex: -1 });
    set(maps[name][next].group, { tabindex: 0 });
    maps[name][next].group.focus();
  } else if (!step) return;
  event.preventDefault();
}

async function chooseGoal(neuron) {
  if (!view.scene || !view.scene.abilities.drive) return;
  if (!view.seat.you) return notify("You only watch: the steering viewer selects the goal.");
  if (await ask("goal_neuron", { neuron }) && view.now && view.now.mode !== "seek") notify(`Neuron N${neuron + 1} is the goal: press Seek.`);
}

// Selects a neuron: shows its samples and describes it.
function look(name, neuron) {
  maps.shown[name] = neuron;
  describe(name);
  showTrained();
}

function describe(name) {
  const neuron = maps.shown[name];
  const seen = view.maps;
  const note = !seen || !seen.learned ? "" : name === "situations" ? `Shade: U-matrix; number: samples.${view.scene && view.scene.abilities.drive ? " Select a neuron as the goal." : ""}` :
    "Bars: change of situation; arrow: the action.";
  say($(`${name}-detail`), neuron === null || !seen || !seen.learned ? note : words(name, neuron, seen));
}

function words(name, neuron, seen) {
  const map = seen[name];
  const hits = `${map.hits[neuron]} sample${map.hits[neuron] === 1 ? "" : "s"}`;
  const u = `U-matrix ${fixed(map.u_matrix[neuron], 2)}`;
  if (name === "changes") {
    const [x, y] = seen.actions_m[neuron];
    const turn = Math.round(Math.atan2(y, x) / (2 * Math.PI) * 16 + 16) % 16;
    return `A${neuron + 1}: ${fixed(100 * Math.hypot(x, y), 1)} cm ${side(turn)}, ${hits}, ${u}`;
  }
  const code = map.code[neuron];
  const most = code.indexOf(Math.max(...code));
  return `N${neuron + 1}: nearest ${side(most)} (${fixed(code[most], 2)}), ${hits}, ${u}`;
}

function showMaps(seen) {
  for (const name of ["situations", "changes"]) {
    $(name).toggleAttribute("hidden", !seen.learned);
    $(`${name}-empty`).hidden = seen.learned;
    describe(name);
  }
  if (!seen.learned) return;
  const shade = (map) => {
    const [low, high] = [Math.min(...map.u_matrix), Math.max(...map.u_matrix)];
    return map.u_matrix.map((u) => high > low ? 100 * (u - low) / (high - low) : 0);
  };
  const full = axisEnd(seen.situations.code.flat());
  let shades = shade(seen.situations);
  seen.situations.code.forEach((code, neuron) => {
    const tile = maps.situations[neuron];
    paint(tile, shades[neuron], seen.situations.hits[neuron]);
    set(tile.up, { d: code.map((value, sensor) => value / full > 0.004 ? bar(50, 55, sensor, 38 * 0.27, 38 * (0.27 + 0.73 * Math.min(value / full, 1))) : "").join("") });
    set(tile.group, { "aria-label": words("situations", neuron, seen) });
  });
  const most = Math.max(...seen.changes.code.flat().map(Math.abs), 1e-6);
  const reach = Math.max(...seen.actions_m.map(([x, y]) => Math.hypot(x, y)), 1e-6);
  shades = shade(seen.changes);
  seen.changes.code.forEach((code, neuron) => {
    const tile = maps.changes[neuron];
    paint(tile, shades[neuron], seen.changes.hits[neuron]);
    const part = (sensor) => Math.max(-1, Math.min(code[sensor] / most, 1)) * 0.38;
    const bars = (sign) => code.map((value, sensor) => sign * part(sensor) > 0.004 ? bar(50, 55, sensor, 38 * 0.62, 38 * (0.62 + part(sensor))) : "").join("");
    set(tile.up, { d: bars(1) });
    set(tile.down, { d: bars(-1) });
    const action = seen.actions_m[neuron];
    const shape = arrow(50, 55, action, 38 * 0.57 * Math.hypot(...action) / reach, 2.4);
    set(tile.rim, { d: shape });
    set(tile.arrow, { d: shape });
    set(tile.group, { "aria-label": words("changes", neuron, seen) });
  });
  if (view.now) showMarks(view.now);
}

function paint(tile, shade, hits) {
  tile.back.style.fill = `color-mix(in srgb, var(--tile-far) ${shade.toFixed(0)}%, var(--tile))`;
  say(tile.hits, String(hits));
}

const show = (element, visible) => { element.style.display = visible ? "" : "none"; };

// Marks the current, next and goal neurons and the walk between them.
function showMarks(now) {
  const plan = now.plan;
  const goal = now.goal.neuron !== null ? now.goal.neuron : plan ? plan.goal : null;
  maps.situations.forEach((tile, neuron) => {
    show(tile.now, plan && plan.current === neuron);
    show(tile.next, plan && plan.intermediate === neuron && plan.intermediate !== plan.current);
    show(tile.goal, goal === neuron);
    set(tile.group, { "aria-pressed": goal === neuron });
  });
  maps.changes.forEach((tile, neuron) => show(tile.next, plan && plan.action === neuron));
  const center = (neuron) => [100 * (neuron % 4) + 50, 100 * Math.floor(neuron / 4) + 55];
  let walk = "";
  if (plan && plan.walk.length > 1) {
    walk = "M" + plan.walk.map((neuron) => center(neuron).join(" ")).join("L");
    const [from, to] = plan.walk.slice(-2).map(center);
    const [dx, dy] = [Math.sign(to[0] - from[0]), Math.sign(to[1] - from[1])];
    walk += `M${to[0] - 13 * dx - 9 * dy} ${to[1] - 13 * dy - 9 * dx}L${to[0]} ${to[1]}L${to[0] - 13 * dx + 9 * dy} ${to[1] - 13 * dy + 9 * dx}`;
  }
  set(maps.walk, { d: walk });
  set(maps.walkRim, { d: walk });
  say($("next-name"), view.scene && view.scene.recalls ? "intermediate" : "expected");
}

buildMap("situations");
buildMap("changes");
showers.maps.push(showMaps);
showers.now.push(showMarks);
