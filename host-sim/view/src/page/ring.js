// Ranges as a polar plot, the situation as a rosette, and its change as bars.
const ring = { sensors: [], full: 0 };

function buildRing() {
  const root = $("ranges");
  ring.circles = svg("g", {}, root);
  for (let sensor = 0; sensor < 16; sensor += 1) {
    const group = svg("g", { class: "sonar", role: "switch", tabindex: sensor ? -1 : 0, "data-sonar": sensor }, root);
    const parts = { group, field: svg("path", { class: "field", d: bar(0, 0, sensor, 12, 108) }, group),
      beam: svg("path", { class: "beam" }, group), cross: svg("path", { class: "cross" }, group) };
    group.addEventListener("click", () => switchSonar(sensor));
    group.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: 15, ArrowDown: 15 }[event.key];
      if (event.key === "Enter") switchSonar(sensor);
      else if (step) {
        const next = ring.sensors[(sensor + step) % 16].group;
        set(group, { tabindex: -1 }); set(next, { tabindex: 0 }); next.focus();
      } else return;
      event.preventDefault();
    });
    for (const kind of ["pointerenter", "focus"]) group.addEventListener(kind, () => { ring.looked = sensor; if (view.now) showRing(view.now); });
    for (const kind of ["pointerleave", "blur"]) group.addEventListener(kind, () => { ring.looked = undefined; if (view.now) showRing(view.now); });
    ring.sensors.push(parts);
  }
  signs(root);
  const other = $("situation");
  svg("circle", { class: "rim", r: 104, "stroke-width": 1.5 }, other);
  ring.asked = svg("path", { class: "bars asked", opacity: 0.55 }, other);
  ring.values = svg("path", { class: "bars" }, other);
  svg("circle", { class: "hub", r: 28, "stroke-width": 1.5 }, other);
  signs(other);
}

function signs(root) {
  const texts = [["front 0", 0, -112, "middle"], ["back 8", 0, 121, "middle"], ["left 4", -108, -3, "start"], ["right 12", 108, -3, "end"]];
  for (const [text, x, y, anchor] of texts) {
    const turned = anchor === "middle" ? {} : { transform: `translate(${x < 0 ? -113 : 120} 0) rotate(-90)`, x: 0, y: 0, "text-anchor": "middle" };
    const sign = svg("text", { class: "quiet", "font-size": 12, x, y, "text-anchor": anchor, ...turned }, root);
    sign.textContent = text;
  }
}

function switchSonar(sensor) {
  if (view.now && view.seat.you && view.scene.abilities.configure) ask("sonar", { number: sensor, on: !view.now.on[sensor] });
}

function showRing(now) {
  const scene = view.scene;
  if (!scene) return;
  const reach = Math.min(scene.near_far_m[1], 6.5);
  if (ring.full !== reach) {
    ring.full = reach;
    ring.circles.replaceChildren();
    const step = reach > 3 ? 1 : reach > 1.2 ? 0.5 : 0.25;
    for (let range = step; range <= reach + 1e-9; range += step) svg("circle", { class: "grid", r: 12 + 92 * range / reach }, ring.circles);
    say($("ranges-note"), `ranges to ${fixed(reach, 1)} m, rings ${step} m`);
  }
  ring.sensors.forEach(({ group, beam, cross }, sensor) => {
    const [range, on] = [now.ranges_m[sensor], now.on[sensor]];
    const length = range === null ? 0 : Math.min(range / reach, 1);
    set(beam, { d: on && length > 0 ? bar(0, 0, sensor, 12, 12 + 92 * length) : "", class: `beam${range !== null && range < 0.35 ? " near" : ""}` });
    const [a, b] = [toward(0, 0, bearingOf(sensor), 48), toward(0, 0, bearingOf(sensor), 72)];
    set(cross, { d: on ? "" : `M${a.join(" ")}L${b.join(" ")}` });
    group.classList.toggle("off", !on);
    set(group, { "aria-checked": on, "aria-label": `Sonar ${sensor}, ${side(sensor)}: ${heard(range, on)}` });
  });
  set(ring.values, { d: now.situation.map((value, sensor) => value > 0.004 ? bar(0, 0, sensor, 28, 28 + 76 * value) : "").join("") });
  set(ring.asked, { d: now.goal.travels ? "" : now.goal.asked.map((ends, sensor) => ends ? asked(sensor, ends) : "").join("") });
  const note = now.goal.travels ? "The goal depends on the direction of travel, so it has no fixed place on the ring." : scene.abilities.configure ? "Select a sonar to switch it on or off." : "Point at a sonar to see its range.";
  const looked = ring.looked;
  say($("ranges-detail"), looked === undefined ? note : `Sonar ${looked}, ${side(looked)}: ${heard(now.ranges_m[looked], now.on[looked])}`);
}

const heard = (range, on) => !on ? "off" : range === null ? "no echo" : meters(range);

// The goal's bounds for a sonar: a band, or a line for a single value.
function asked(sensor, [low, high]) {
  const [from, to] = [28 + 76 * low, 28 + 76 * high];
  return to - from < 3 ? bar(0, 0, sensor, from - 2, from + 2) : high < 1 && low === 0 ? bar(0, 0, sensor, to - 1, to + 2.5) : bar(0, 0, sensor, from, to);
}

const delta = { root: $("delta"), bars: [] };

function buildDelta() {
  const root = delta.root;
  delta.zero = svg("path", { class: "grid", d: "M30 62H416" }, root);
  delta.ends = [svg("text", { x: 26, y: 18, "font-size": 11, class: "quiet", "text-anchor": "end" }, root),
    svg("text", { x: 26, y: 112, "font-size": 11, class: "quiet", "text-anchor": "end" }, root)];
  const zero = svg("text", { x: 26, y: 66, "font-size": 11, class: "quiet", "text-anchor": "end" }, root);
  zero.textContent = "0";
  for (let sensor = 0; sensor < 16; sensor += 1) {
    const x = 34 + 24 * sensor;
    const name = svg("text", { x: x + 10, y: 128, "font-size": 11, class: "quiet", "text-anchor": "middle" }, root);
    name.textContent = String(sensor);
    delta.bars.push({ wanted: svg("rect", { x, width: 9, fill: "var(--value)" }, root),
      known: svg("rect", { x: x + 10, width: 9, fill: "var(--goal)" }, root), came: svg("circle", { cx: x + 9.5, r: 2.8, fill: "var(--ink)" }, root) });
  }
}

function showDelta(now) {
  const plan = now.plan;
  delta.root.toggleAttribute("hidden", !plan);
  $("delta-empty").hidden = !!plan;
  say($("why"), plan ? reason(now) : "");
  if (!plan) return;
  const full = axisEnd([...plan.wanted, ...plan.known]);
  const height = (value) => 48 * Math.min(Math.abs(value) / full, 1);
  const put = (rect, value) => set(rect, { y: value > 0 ? 62 - height(value) : 62, height: height(value).toFixed(1) });
  delta.bars.forEach(({ wanted, known, came }, sensor) => {
    put(wanted, plan.wanted[sensor]);
    put(known, plan.known[sensor]);
    const brought = now.changed ? now.changed[sensor] : null;
    came.style.display = brought === null ? "none" : "";
    if (brought !== null) set(came, { cy: (62 - Math.sign(brought) * height(brought)).toFixed(1) });
  });
  say(delta.ends[0], `+${full}`);
  say(delta.ends[1], `−${full}`);
  say($("wanted-name"), view.scene && view.scene.recalls ? "wanted change" : "expected change");
  say($("known-name"), `stored in A${plan.action + 1}`);
}

// Describes the plan in a sentence.
function reason(now) {
  const [x, y] = now.wanted_m;
  const length = 100 * Math.hypot(x, y);
  const turn = Math.round(Math.atan2(y, x) / (2 * Math.PI) * 16 + 16) % 16;
  const cut = Math.hypot(...now.allowed_m) < Math.hypot(x, y) - 0.002 ? `, shortened by the shield to ${fixed(100 * Math.hypot(...now.allowed_m), 0)} cm` : "";
  const way = length < 1 ? "no move" : `${fixed(length, 0)} cm ${side(turn)}`;
  return `N${now.plan.current + 1} → N${now.plan.intermediate + 1} → goal N${now.plan.goal + 1}; ${now.plan.why}: ${way}${cut}`;
}

buildRing();
buildDelta();
showers.scene.push(() => { if (view.now) showRing(view.now); });
showers.now.push(showRing, showDelta);
