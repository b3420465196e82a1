// The memory of places over the arena: where the robot thinks they are, open ways, and its way.
const places = {};

function buildPlaces() {
  const [known, way] = [arena["places-layer"], arena["way-layer"]];
  for (const layer of [known, way]) layer.setAttribute("pointer-events", "none");
  places.guesses = svg("g", {}, known);
  for (const name of ["links", "blocked", "frontiers", "dots"]) places[name] = svg("path", { class: `places-${name}` }, known);
  places.rim = svg("path", { class: "way rim" }, way);
  places.line = svg("path", { class: "way" }, way);
  places.next = svg("circle", { class: "way-next" }, way);
  places.ghost = svg("g", { class: "thinks", "pointer-events": "none" }, arena.robots);
  places.body = svg("circle", {}, places.ghost);
  places.front = svg("path", {}, places.ghost);
}

const at = (place) => cm(place).map((v) => v.toFixed(1)).join(" ");
const between = ([x, y], [toX, toY], share) => [x + share * (toX - x), y + share * (toY - y)];

function showPlaces() {
  const scene = view.scene;
  if (!scene) return;
  const can = scene.abilities.places;
  $("places-signs").hidden = !can;
  for (const layer of ["places-layer", "way-layer"]) arena[layer].style.display = can && $("show-places").checked ? "" : "none";
  arena.root.classList.toggle("goes", can && scene.abilities.drive && view.seat.you);
  if (!can || !view.places) return;
  const known = view.places;
  const u = arena.unit;
  const lines = (pairs) => pairs.map(([one, other]) => `M${at(known.places[one])}L${at(known.places[other])}`).join("");
  set(places.links, { d: lines(known.links), "stroke-width": 1.3 * u });
  set(places.blocked, { d: lines(known.blocked), "stroke-width": 1.6 * u });
  // Their beginning would hide the place.
  const open = known.frontiers.map(([from, end]) => `M${at(between(from, end, 0.25))}L${at(end)}`).join("");
  set(places.frontiers, { d: open, "stroke-width": 1.4 * u });
  const r = (2.2 * u).toFixed(1);
  const dot = (place) => `M${at(place)}m${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
  set(places.dots, { d: known.places.map(dot).join("") });
  showGuesses(known.guesses);
}

// Where a robot that was set down elsewhere may be: the darker, the more speaks for it.
function showGuesses(guesses) {
  const drawn = places.guesses;
  $("guess-sign").hidden = !guesses.length;
  while (drawn.children.length > guesses.length) drawn.lastChild.remove();
  while (drawn.children.length < guesses.length) svg("circle", { class: "guess" }, drawn);
  guesses.forEach(([place, strength], index) => {
    const [cx, cy] = cm(place);
    set(drawn.children[index], { cx, cy, r: 100 * view.scene.radii_m[0], "fill-opacity": (0.1 + 0.5 * strength).toFixed(2) });
  });
}

// The way from where the robot thinks that it is, and a ghost of it if it is elsewhere.
function showWay(now) {
  const scene = view.scene;
  if (!scene || !scene.abilities.places) return;
  const u = arena.unit;
  const way = now.thinks && now.way ? now.way : [];
  const d = way.length ? `M${at(now.thinks)}${way.map((place) => `L${at(place)}`).join("")}` : "";
  set(places.rim, { d, "stroke-width": 5.5 * u });
  set(places.line, { d, "stroke-width": 2.6 * u });
  places.next.style.display = way.length ? "" : "none";
  if (way.length) { const [cx, cy] = cm(way[0]); set(places.next, { cx, cy, r: 5 * u, "stroke-width": 2 * u }); }
  const off = now.thinks ? Math.hypot(now.thinks[0] - now.pose[0], now.thinks[1] - now.pose[1]) : 0;
  const turned = now.thinks ? Math.abs(Math.sin((now.thinks[2] - now.pose[2]) / 2)) : 0;
  const differs = $("show-places").checked && (off > 0.05 || turned > 0.03);
  places.ghost.style.display = differs ? "" : "none";
  if (!differs) return;
  const radius = 100 * scene.radii_m[0];
  set(places.ghost, { "stroke-width": 2 * u });
  set(places.body, { r: radius });
  set(places.front, { d: `M${0.55 * radius} 0H${0.95 * radius}` });
  place(places.ghost, now.thinks[0], now.thinks[1], now.thinks[2], glide(now));
}

// A click on the floor is the goal of a robot that its places lead.
function bindPlaces() {
  let pressed = false;
  arena.root.addEventListener("pointerdown", (event) => { pressed = !event.target.closest("[role='button']"); });
  arena.root.addEventListener("click", async (event) => {
    const can = view.scene && view.scene.abilities;
    if (!pressed || !can || !can.places || !can.drive) return;
    if (!view.seat.you) return notify("You only watch: the steering viewer selects the goal.");
    const [x, y] = pointer(event);
    if (await ask("goal_position", { x, y }) && view.now.mode !== "seek") notify("That place is the goal: press Seek.");
  });
  $("show-places").addEventListener("change", () => { showPlaces(); if (view.now) showWay(view.now); });
}

buildPlaces();
bindPlaces();
showers.places.push(showPlaces);
showers.seat.push(showPlaces);
showers.scene.push(() => { showPlaces(); if (view.now) showWay(view.now); });
showers.now.push(showWay);
