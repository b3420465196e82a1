// The arena from above, in centimeters; the y axis points up.
const arena = { root: $("arena"), pieces: new Map(), spots: new Map(), shapes: [], drag: null, unit: 1 };

function buildArena() {
  const root = arena.root;
  for (const name of ["sources-layer", "things", "spots-layer", "cones", "places-layer", "trails", "marks", "way-layer", "signs", "robots"]) arena[name] = svg("g", {}, root);
  arena["spots-layer"].setAttribute("pointer-events", "none");
  arena.cones.setAttribute("pointer-events", "none");
  arena.beams = Array.from({ length: 16 }, () => svg("path", { class: "cone" }, arena.cones));
  arena.heard = svg("circle", { class: "heard" }, arena.cones);
  arena.place = svg("circle", { class: "place" }, arena.marks);
  arena.leader = svg("circle", { class: "leader" }, arena.robots);
  arena.wanted = svg("path", { class: "arrow", opacity: 0.35, "pointer-events": "none" }, arena.robots);
  const robot = svg("g", { class: "robot", tabindex: 0, role: "button" }, arena.robots);
  arena.robots.style.display = "none";
  Object.assign(arena, { robot, body: svg("circle", { class: "body" }, robot), front: svg("path", { class: "front" }, robot) });
  arena.ghost = svg("circle", { class: "ghost", "pointer-events": "none" }, arena.signs);
  arena.scale = svg("path", { fill: "none", stroke: "var(--gray)" }, arena.signs);
  arena.scaleText = svg("text", { class: "quiet halo", "text-anchor": "middle" }, arena.signs);
  arena.start = svg("text", { class: "halo", "text-anchor": "middle" }, arena.signs);
  root.addEventListener("pointermove", dragOn);
  root.addEventListener("pointerup", dragEnd);
  root.addEventListener("pointercancel", dragEnd);
  grabbable(robot, () => ({ what: "move_robot", at: view.now.pose.slice(0, 2) }));
}

const cm = ([x, y]) => [100 * x, -100 * y];
const list = (points) => points.map((point) => cm(point).map((v) => v.toFixed(1)).join(",")).join(" ");

function showScene(scene) {
  const [low, high] = scene.bounds;
  const span = Math.max(high[0] - low[0], high[1] - low[1]);
  arena.unit = span * 100 / 500;
  const margin = arena.unit * 12;
  const [left, top] = cm([low[0], high[1]]);
  const size = [100 * (high[0] - low[0]) + 2 * margin, 100 * (high[1] - low[1]) + 2.6 * margin];
  set(arena.root, { viewBox: [left - margin, top - margin, size[0], size[1]].map((v) => v.toFixed(1)).join(" ") });
  arena.root.parentElement.style.setProperty("--ratio", size[0] / size[1]);
  showShapes(scene);
  const u = arena.unit;
  const [x, y] = [left, -100 * low[1] + 1.4 * margin];
  set(arena.scale, { d: `M${x} ${y - 4 * u}v${4 * u}h100v${-4 * u}`, "stroke-width": 1.4 * u });
  set(arena.scaleText, { x: x + 50, y: y - 3 * u, "font-size": 11 * u, "stroke-width": 3 * u });
  say(arena.scaleText, "1 m");
  const [sx, sy] = cm(scene.start);
  set(arena.start, { x: sx, y: sy + 4 * u, "font-size": 12 * u, "stroke-width": 3 * u });
  say(arena.start, "S");
  const radius = 100 * scene.radii_m[0];
  set(arena.body, { r: radius, "stroke-width": 2.4 * u });
  set(arena.ghost, { r: radius, "stroke-width": 2.2 * u });
  set(arena.leader, { r: radius, "stroke-width": 2.4 * u });
  set(arena.place, { r: 30, "stroke-width": 2.6 * u });
  set(arena.front, { d: `M${radius * 0.95} 0L${radius * 0.45} ${radius * 0.33}L${radius * 0.45} ${-radius * 0.33}Z` });
  for (const [index, piece] of view.trail) showPiece(piece, index);
  for (const [index, spots] of view.heard) showSpots(spots, index);
  $("heard-sign").hidden = scene.shapes.length > 0;
  if (view.now) showRobot(view.now);
}

function showShapes(scene) {
  const keep = arena.shapes.length === scene.shapes.length && arena.world === scene.world;
  if (!keep) {
    arena.things.replaceChildren();
    arena.shapes = scene.shapes.map((shape, index) => {
      const tag = shape.wall ? "polyline" : shape.box ? "polygon" : "circle";
      const loose = !shape.wall && scene.abilities.carry;
      const thing = svg(tag, { class: shape.wall ? "wall" : `thing${loose ? " loose" : ""}` }, arena.things);
      if (loose) {
        set(thing, { tabindex: 0, role: "button", "data-shape": index });
        grabbable(thing, () => ({ what: "move_shape", shape: index, at: middle(view.scene.shapes[index]) }));
      }
      return thing;
    });
    arena.world = scene.world;
  }
  scene.shapes.forEach((shape, index) => {
    const thing = arena.shapes[index];
    set(thing, { "stroke-width": (shape.wall ? 2.6 : 1.4) * arena.unit });
    if (arena.drag && arena.drag.element === thing) return;
    if (shape.circle) {
      const [center, radius] = shape.circle;
      const [cx, cy] = cm(center);
      set(thing, { cx, cy, r: 100 * radius });
    } else set(thing, { points: list(shape.wall || shape.box) });
    set(thing, { transform: "" });
    if (!shape.wall) {
      const at = middle(shape).map((v) => fixed(v, 2)).join(", ");
      set(thing, { "aria-label": `${shape.box ? "Box" : "Post"} at ${at} m: arrow keys move it` });
    }
  });
}

function middle(shape) {
  if (shape.circle) return shape.circle[0];
  const points = shape.box;
  return [0, 1].map((axis) => points.reduce((sum, point) => sum + point[axis], 0) / points.length);
}

function showRobot(now) {
  const scene = view.scene;
  if (!scene) return;
  arena.robots.style.display = "";
  const [x, y, heading] = now.pose;
  if (!(arena.drag && arena.drag.element === arena.robot)) place(arena.robot, x, y, heading, glide(now));
  arena.body.classList.toggle("hit", now.touched);
  set(arena.robot, { "aria-label": `Robot at ${fixed(x, 2)}, ${fixed(y, 2)} m: arrow keys move it` });
  const [hx, hy, ring] = now.heard_at;
  const half = scene.half_angle_rad;
  const face = scene.radii_m[1];
  const reach = Math.min(scene.near_far_m[1], 4);
  if (scene.sensors) showBeams(now, scene, half, reach);
  else arena.beams.forEach((beam, sensor) => {
    const range = now.ranges_m[sensor];
    const none = range === null || range > reach;
    const axis = ring + bearingOf(sensor);
    const at = (distance, angle) => cm([hx + distance * Math.cos(angle), hy + distance * Math.sin(angle)]).map((v) => v.toFixed(1)).join(" ");
    const far = face + (none ? reach : range);
    const arc = 100 * far;
    set(beam, { d: now.on[sensor] ? `M${at(face, axis)}L${at(far, axis + half)}A${arc} ${arc} 0 0 1 ${at(far, axis - half)}Z` : "",
      class: `cone${none ? " none" : range < 0.35 ? " near" : ""}`, "stroke-width": arena.unit });
  });
  const [ax, ay] = now.allowed_m;
  const length = 100 * Math.hypot(ax, ay);
  const moving = now.plan && ["seek", "explore"].includes(now.mode) && length > 1;
  const [cx, cy] = cm([hx, hy]);
  set(arena.wanted, { d: moving ? arrow(0, 0, now.allowed_m, length, 3 * arena.unit) : "", "stroke-width": 2 * arena.unit,
    transform: `translate(${cx} ${cy}) rotate(${90 - ring * 180 / Math.PI})` });
  set(arena.heard, { cx, cy, r: 100 * face, "stroke-width": 1.2 * arena.unit });
  arena.leader.style.display = now.leader ? "" : "none";
  if (now.leader) { const [lx, ly] = cm(now.leader); set(arena.leader, { cx: lx, cy: ly }); }
  arena.place.style.display = now.goal.place ? "" : "none";
  if (now.goal.place) { const [gx, gy] = cm(now.goal.place); set(arena.place, { cx: gx, cy: gy }); }
  if (scene.abilities.jump) showPast(now);
  else {
    for (const [index, shown] of arena.pieces) if (index < now.trail[0]) { shown.group.remove(); arena.pieces.delete(index); }
    for (const index of view.trail.keys()) if (index < now.trail[0]) view.trail.delete(index);
  }
  for (const [index, shown] of arena.spots) if (index < now.heard[0]) { shown.remove(); arena.spots.delete(index); }
  for (const index of view.heard.keys()) if (index < now.heard[0]) view.heard.delete(index);
}

// The cones of sensors that stand on the body.
function showBeams(now, scene, half, reach) {
  const [hx, hy, heading] = now.heard_at;
  arena.beams.forEach((beam, index) => {
    const sensor = scene.sensors[index];
    if (!sensor) return set(beam, { d: "" });
    const [range, axis] = [now.beams_m[index], heading + sensor[2]];
    const none = range === null || range > reach;
    const far = none ? reach : range;
    const tip = [hx + sensor[0] * Math.cos(heading) - sensor[1] * Math.sin(heading), hy + sensor[0] * Math.sin(heading) + sensor[1] * Math.cos(heading)];
    const at = (angle) => cm([tip[0] + far * Math.cos(angle), tip[1] + far * Math.sin(angle)]).map((v) => v.toFixed(1)).join(" ");
    const arc = (100 * far).toFixed(1);
    const near = range !== null && range < 0.1 * reach;
    set(beam, { d: `M${cm(tip).map((v) => v.toFixed(1)).join(" ")}L${at(axis + half)}A${arc} ${arc} 0 0 1 ${at(axis - half)}Z`,
      class: `cone${none ? " none" : near ? " near" : ""}`, "stroke-width": arena.unit });
  });
}

// In a recording, draws only the decisions before the current position, of the current start.
function showPast(now) {
  let before = 0;
  for (const [index, marks] of [...view.trail.entries()].sort((a, b) => a[0] - b[0])) {
    const count = index < now.trail[0] ? 0 : Math.max(0, Math.min(marks.length, now.at - before));
    before += marks.length;
    const shown = arena.pieces.get(index);
    if (shown && shown.count === count) continue;
    showPiece(marks, index, count);
  }
}

// Places of echoes, as dots.
function showSpots(spots, index) {
  if (!arena.spots.has(index)) arena.spots.set(index, svg("path", { class: "spot" }, arena["spots-layer"]));
  const r = Math.max(2, 1.6 * arena.unit);
  const dot = (spot) => { const [x, y] = cm(spot); return `M${(x - r).toFixed(1)} ${y.toFixed(1)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`; };
  set(arena.spots.get(index), { d: spots.map(dot).join("") });
}

// Duration of the animation between two poses, ms.
function glide(now) {
  if (matchMedia("(prefers-reduced-motion: reduce)").matches || !now.pace.speed || now.pace.standing) return 0;
  return Math.min(1000 * now.step_s / now.pace.speed, 600);
}

function place(element, x, y, heading, ms) {
  const [px, py] = cm([x, y]);
  element.style.transition = ms > 120 ? `transform ${ms.toFixed(0)}ms linear` : "none";
  element.style.transform = `translate(${px}px, ${py}px) rotate(${-heading}rad)`;
}

// A chunk of the history, joined to the end of the one before.
function showPiece(all, index, behind) {
  const jump = view.scene && view.scene.abilities.jump;
  const known = arena.pieces.get(index);
  const count = behind === undefined ? (jump ? (known ? known.count : 0) : all.length) : behind;
  const marks = all.slice(0, count);
  if (!arena.pieces.has(index)) {
    const group = svg("g", { "pointer-events": "none" }, arena.trails);
    const lines = { 0: svg("path", { class: "path explore" }, group), 1: svg("path", { class: "path seek" }, group) };
    arena.pieces.set(index, { group, lines, touches: svg("path", { class: "touch" }, group) });
    // Old chunks are pale.
    for (const [other, piece] of arena.pieces) piece.group.classList.toggle("old", !jump && other < index - 1);
  }
  const before = view.trail.get(index - 1);
  let last = before && before.length ? before[before.length - 1] : null;
  const text = { 0: "", 1: "" };
  let touches = "";
  const u = arena.unit;
  for (const mark of marks) {
    const [x, y] = cm([mark[1], mark[2]]);
    const from = last ? cm([last[1], last[2]]) : [x, y];
    // The robot was carried.
    const jump = Math.hypot(x - from[0], y - from[1]) > 60;
    text[mark[3]] += jump ? `M${x.toFixed(1)} ${y.toFixed(1)}` : `M${from.map((v) => v.toFixed(1)).join(" ")}L${x.toFixed(1)} ${y.toFixed(1)}`;
    if (mark[4] & 1) touches += `M${x - 4 * u} ${y - 4 * u}l${8 * u} ${8 * u}m0 ${-8 * u}l${-8 * u} ${8 * u}`;
    last = mark;
  }
  const shown = arena.pieces.get(index);
  shown.count = count;
  for (const kind of [0, 1]) set(shown.lines[kind], { d: text[kind], "stroke-width": (kind ? 2 : 1.5) * u });
  set(shown.touches, { d: touches, "stroke-width": 2.2 * u });
}

function showGhost(mark) {
  arena.ghost.style.display = mark ? "" : "none";
  if (mark) { const [cx, cy] = cm([mark[1], mark[2]]); set(arena.ghost, { cx, cy }); }
}

// Moves an element by dragging or with the arrow keys.
function grabbable(element, begin) {
  element.addEventListener("pointerdown", (event) => {
    if (!view.seat.you || !view.scene.abilities.carry) return;
    event.preventDefault();
    element.focus();
    arena.root.setPointerCapture(event.pointerId);
    arena.drag = { element, ...begin(), from: pointer(event), sent: 0, to: null };
    arena.root.classList.add("dragging");
  });
  element.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const { what, shape, source, at } = begin();
    ask(what, { shape, source, x: at[0] + 0.05 * way[0], y: at[1] + 0.05 * way[1] });
  });
}

function pointer(event) {
  const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(arena.root.getScreenCTM().inverse());
  return [point.x / 100, -point.y / 100];
}

function dragOn(event) {
  const drag = arena.drag;
  if (!drag) return;
  const here = pointer(event);
  const way = [here[0] - drag.from[0], here[1] - drag.from[1]];
  drag.to = [drag.at[0] + way[0], drag.at[1] + way[1]];
  const [dx, dy] = cm(way);
  if (drag.what === "move_robot") place(drag.element, drag.to[0], drag.to[1], view.now.pose[2], 0);
  else set(drag.element, { transform: `translate(${dx} ${dy})` });
  // An obstacle moves while it is dragged; the robot moves once at the end.
  if (drag.what !== "move_robot" && performance.now() - drag.sent > 150) {
    drag.sent = performance.now();
    sendCommand(drag.what, { shape: drag.shape, source: drag.source, x: drag.to[0], y: drag.to[1] }).catch(() => {});
  }
}

function dragEnd() {
  const drag = arena.drag;
  arena.drag = null;
  arena.root.classList.remove("dragging");
  if (!drag) return;
  const settle = () => { if (view.scene) { showShapes(view.scene); showSources(view.scene); } if (view.now) showRobot(view.now); };
  if (!drag.to) return settle();
  ask(drag.what, { shape: drag.shape, source: drag.source, x: drag.to[0], y: drag.to[1] }).then(settle);
}

buildArena();
showers.scene.push(showScene);
showers.now.push(showRobot);
showers.trail.push((piece, index) => showPiece(piece, index));
showers.heard.push(showSpots);
