// The body from above: where its sensors are, and where the controller takes them to be.
const bodyCard = { root: $("body"), sensors: [] };

// The point of the card for a place on the body, in units of its radius; the front is up.
const onCard = ([x, y]) => [-78 * y, -78 * x];

function buildBody(scene) {
  $("body-card").hidden = !scene.sensors;
  bodyCard.root.replaceChildren();
  bodyCard.sensors = [];
  if (!scene.sensors) return;
  const radius = scene.radii_m[0];
  bodyCard.scale = 1 / radius;
  svg("circle", { class: "rim", r: 78, "stroke-width": 1.5 }, bodyCard.root);
  svg("path", { class: "hub", d: "M0 -34L12 -8L-12 -8Z" }, bodyCard.root);
  bodyCard.sensors = scene.sensors.map((sensor, index) => {
    const group = svg("g", {}, bodyCard.root);
    svg("path", { d: sensorWedge(sensor, scene.half_angle_rad), fill: "var(--gray)", opacity: 0.3 }, group);
    const line = svg("path", { fill: "none", stroke: "var(--value)", "stroke-width": 2.4, "stroke-linecap": "round" }, group);
    const name = svg("text", { "font-size": 11, "text-anchor": "middle" }, group);
    name.textContent = String(index);
    return { line, name };
  });
}

// A cone from a sensor's place outwards.
function sensorWedge([x, y, axis], half) {
  const from = onCard([x * bodyCard.scale, y * bodyCard.scale]);
  const at = (angle) => toward(from[0], from[1], angle, 30).map((v) => v.toFixed(1)).join(" ");
  const wide = Math.max(half, 0.06);
  return `M${from.map((v) => v.toFixed(1)).join(" ")}L${at(axis + wide)}L${at(axis - wide)}Z`;
}

function showBody(now) {
  if (!bodyCard.sensors.length || !view.scene.sensors) return;
  let [count, worst] = [0, 0];
  bodyCard.sensors.forEach(({ line, name }, index) => {
    const sensor = now.found ? now.found[index] : null;
    line.style.display = name.style.display = sensor ? "" : "none";
    if (!sensor) return;
    const from = onCard([sensor[0] * bodyCard.scale, sensor[1] * bodyCard.scale]);
    const to = toward(from[0], from[1], sensor[2], 26);
    set(line, { d: `M${from.map((v) => v.toFixed(1)).join(" ")}L${to.map((v) => v.toFixed(1)).join(" ")}` });
    const [x, y] = toward(from[0], from[1], sensor[2], 36);
    set(name, { x: x.toFixed(1), y: (y + 4).toFixed(1) });
    const off = Math.abs(sensor[2] - view.scene.sensors[index][2]) % (2 * Math.PI);
    worst = Math.max(worst, Math.min(off, 2 * Math.PI - off));
    count += 1;
  });
  const all = bodyCard.sensors.length;
  const degrees = fixed(worst * 180 / Math.PI, 1);
  say($("body-detail"), now.found ? `${count} of ${all} sensors found, none off by more than ${degrees}°` : "What a remote controller has found is not shown.");
}

showers.scene.push((scene) => { buildBody(scene); if (view.now) showBody(view.now); });
showers.now.push(showBody);
