// Commands, counters, control lock.
const SPEEDS = [0.25, 0.5, 1, 2, 4, 10, 40, 200, null];
const speedName = (speed) => speed === null ? "max" : `${speed}×`;

function options(select, names, chosen) {
  const same = select.options.length === names.length && names.every(([value], place) => select.options[place].value === value);
  if (!same) select.replaceChildren(...names.map(([value, text]) => new Option(text, value)));
  if (document.activeElement !== select || !same) select.value = chosen;
}

const NAMED = "\u0000";
const HOME_NEEDS = "home: needs a memory of places (view --places on)";
function showGoalChoice() {
  const [scene, now] = [view.scene, view.now];
  if (!scene || !now) return;
  const names = scene.behaviors.map(([name]) => [name, name]);
  if (scene.abilities.carry && !scene.abilities.places) names.push(["home", HOME_NEEDS]);
  // A chain consists of several behaviors.
  const chained = now.goal.name.split(",").every((part) => scene.behaviors.some(([name]) => name === part));
  $("then-choice").hidden = !chained || !scene.abilities.drive;
  options($("then"), [["", "–"], ...names.filter(([name]) => name !== now.goal.name.split(",").pop())], "");
  const known = names.some(([name]) => name === now.goal.name);
  options($("behavior"), known ? names : [[NAMED, now.goal.name], ...names], known ? now.goal.name : NAMED);
  const about = scene.behaviors.find(([name]) => name === now.goal.name);
  $("behavior").title = about ? about[1] : now.goal.name;
  for (const option of document.querySelectorAll("option[value='home']")) option.disabled = !scene.abilities.places;
  $("tour-choice").hidden = !now.goal.tour;
  if (now.goal.tour && document.activeElement !== $("tour")) $("tour").value = now.goal.tour[1];
}

const MODES = { idle: "stands", babble: "moves to find its sensors", calibrate: "works out where its sensors are", explore: "explores", learn: "learns", seek: "seeks", stopped: "stopped", failed: "has failed" };
// Of a chain, the current part; before the way home, how far the tour is.
function goalName({ name, part, tour }) {
  if (tour && tour[0] < tour[1]) return `${name}, tour ${tour[0]} of ${tour[1]}`;
  const parts = name.split(",");
  return part === null || part === undefined ? name : `${parts[part]} (${part + 1} of ${parts.length})`;
}

let announced = "";
let pendingSwitch = null;

function showMode(now) {
  const goal = now.mode === "seek" ? `: ${goalName(now.goal)}` : "";
  const paused = now.pace.paused ? ", paused" : "";
  say($("mode"), MODES[now.mode] + goal + paused);
  set($("mode"), { "data-mode": now.mode });
  const busy = ["babble", "calibrate", "explore", "learn"].includes(now.mode);
  $("done").hidden = !busy;
  if (busy) $("done").value = now.done;
  say($("time"), `${fixed(now.time_s, 1)} s`);
  $("alarm").hidden = !now.why;
  const again = view.scene && view.scene.abilities.reset ? " Press Restart to continue." : "";
  if (now.why) say($("alarm"), `${now.why}.${again}`);
  $("note").hidden = !now.note;
  if (now.note) say($("note"), `${now.note}.`);
  const text = MODES[now.mode] + goal;
  if (text !== announced) { announced = text; say($("status"), `The robot ${text}`); }
  const learned = view.maps && view.maps.learned;
  $("resume").disabled = !now.resumes;
  $("learn").disabled = !view.memory.length || busy;
  $("seek").disabled = !learned || now.mode === "learn" || now.mode === "seek";
  $("explore").disabled = busy;
  const next = !view.memory.length ? "explore" : !learned ? "learn" : "seek";
  for (const id of ["explore", "learn", "seek"]) $(id).classList.toggle("primary", id === next && !$(id).disabled);
  const over = recording() && now.pace.standing;
  say($("pause"), over ? "Play again" : now.pace.paused ? (recording() ? "Play" : "Continue") : "Pause");
  $("pause").classList.toggle("primary", now.pace.paused || over);
  $("step").disabled = over;
  $("back").disabled = $("first").disabled = now.at === 0;
  const speeds = SPEEDS.includes(now.pace.speed) ? SPEEDS : [now.pace.speed, ...SPEEDS];
  options($("speed"), speeds.map((speed) => [String(speed), speedName(speed)]), String(now.pace.speed));
  for (const id of ["shield", "online"]) if (pendingSwitch !== id) $(id).checked = now[id];
  const [records, steps] = now.shown || [false, 0];
  say($("record"), records ? `Recording ${steps}` : "Record");
  $("record").setAttribute("aria-pressed", records);
  $("goal-shown").disabled = steps < 10;
  showGoalChoice();
}

// What the robot's other sensors read.
function sensedRows(sensed) {
  if (!sensed) return [];
  const percent = (share) => `${fixed(100 * share, 0)} %`;
  return [["scent", percent(sensed.scent)], ["light", percent(sensed.light)], ["floor", sensed.floor]];
}

function showCounts(now) {
  const counts = now.counts;
  const share = (part) => counts.steps ? `${fixed(100 * part / counts.steps, 0)} %` : "–";
  const [moves, hurt] = counts.explored;
  const mind = view.scene ? view.scene.mind : "";
  const all = [["random moves", hurt ? `${moves} (${hurt} touched)` : `${moves}`, hurt > 0], ["decisions", `${counts.steps}`],
    ["contacts", `${counts.contacts}`, counts.contacts > 0], ["shield", `${counts.shielded}`],
    ["goal held", share(counts.at_goal)], ["distance", `${fixed(counts.distance_m, 1)} m`],
    ["least gap", counts.clearance_m === null ? "–" : meters(counts.clearance_m)], ["area swept", counts.coverage_m2 === null ? "–" : `${fixed(counts.coverage_m2, 1)} m²`],
    ...sensedRows(now.sensed), ["controller", mind, false], ["link", now.link ? (now.why ? "lost" : "connected") : "–", !!now.link && !!now.why]];
  // Unknown values are hidden.
  const rows = all.filter(([, text]) => text !== "–" || !view.scene || view.scene.abilities.carry).filter(([name, text]) => name !== "link" || text !== "–");
  const root = $("counts");
  const names = rows.map(([name]) => name).join();
  if (root.dataset.names !== names) root.replaceChildren(...rows.map(([name]) => {
    const pair = document.createElement("div");
    pair.append(document.createElement("dt"), document.createElement("dd"));
    pair.firstChild.textContent = name;
    return pair;
  }));
  root.dataset.names = names;
  rows.forEach(([, text, bad], place) => {
    const value = root.children[place].lastChild;
    say(value, text);
    value.classList.toggle("bad", !!bad);
  });
}

function showSetup(scene) {
  say($("what"), `${scene.abilities.jump ? "recording · " : ""}${scene.world} · ${scene.preset} · ${scene.robot ? `robot ${scene.robot}, sensors ${scene.sonar}` : `sonars ${scene.sonar}, ring ${scene.turret}`} · seed ${scene.seed}`);
  options($("world"), [...scene.worlds, "random:"].map((name) => [name, name === "random:" ? "a random room" : name]), scene.world);
  options($("preset"), scene.presets.map((name) => [name, name]), scene.preset);
  if (document.activeElement !== $("seed")) $("seed").value = scene.seed;
  const can = scene.abilities;
  for (const [ids, ability] of [[["explore", "learn", "seek", "resume", "here", "stop", "goal-choice", "then-choice", "goal-files"], can.drive],
    [["pause", "step", "speed-choice"], can.pace], [["show-goal"], can.show], [["save-mind"], can.save], [["load-mind"], can.load], [["anew"], can.reset],
    [["first", "back"], can.jump]]) for (const id of ids) $(id).hidden = !ability;
  for (const id of ["shield", "online"]) $(id).disabled = !can.configure;
  document.body.classList.toggle("recording", can.jump);
  for (const id of ["arena-card", "ranges-half"]) $(id).hidden = can.unplaced;
  if (can.unplaced) $("here").hidden = true;
}

function showSeat(seat) {
  const others = seat.viewers > 1 ? `, ${seat.viewers} watch` : "";
  say($("seat"), (seat.you ? "you steer" : seat.taken ? "another viewer steers" : token ? "no viewer steers" : "you only watch") + others);
  $("seat").title = token ? "" : "To steer, open the full address that the program printed.";
  $("steer").hidden = !token || seat.you;
  $("steer").textContent = seat.taken ? "Take over" : "Steer";
  for (const id of ["orders", "setup"]) $(id).disabled = !seat.you;
  $("stop").disabled = !token;
}

function saveFile(file) {
  if (!file) return;
  const bytes = file.hex ? Uint8Array.from(file.hex.match(/../g), (pair) => parseInt(pair, 16)) : file.text;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([bytes]));
  link.download = file.name;
  link.click();
  URL.revokeObjectURL(link.href);
}

function choose(accept, read) {
  const input = $("file");
  input.accept = accept;
  input.value = "";
  input.onchange = async () => { if (input.files[0]) read(input.files[0]); };
  input.click();
}

async function loadMind(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (bytes.length > 120000) return notify(`${file.name} is too large.`);
  const hex = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
  if (await ask("load_mind", { hex })) notify(`${file.name} is loaded: select a goal and press Seek.`);
}

async function loadGoal(file) {
  if (await ask("goal_file", { text: (await file.text()).slice(0, 100000) })) notify(`${file.name} is the goal now.`);
}

function askBehavior(name) {
  const tour = $("tour").value.trim();
  if (!/^\d{1,6}$/.test(tour)) return notify("A tour has a whole number of steps, up to 999999.");
  ask("behavior", { name, tour: Number(tour) });
}

function restart() {
  const seed = $("seed").value.trim();
  if (!/^\d+$/.test(seed) || !Number.isSafeInteger(Number(seed))) return notify("The seed must be a whole number up to 9007199254740991.");
  const world = $("world").value === "random:" ? `random:${seed}` : $("world").value;
  ask("reset", { seed: Number(seed), world, preset: $("preset").value });
}

async function playOrPause() {
  const now = view.now;
  if (!now) return;
  if (recording() && now.pace.standing) {
    if (await ask("jump", { to: 0 })) ask("pause", { paused: false });
  } else ask("pause", { paused: !now.pace.paused });
}

function bindControls() {
  for (const id of ["stop", "explore", "learn", "seek", "resume", "step"]) $(id).addEventListener("click", () => ask(id));
  $("pause").addEventListener("click", playOrPause);
  $("first").addEventListener("click", () => jump(0));
  $("back").addEventListener("click", async () => { if (await ask("pause", { paused: true })) jump(Math.max(0, view.now.at - 1)); });
  $("then").addEventListener("change", (event) => {
    if (event.target.value) ask("behavior", { name: `${view.now.goal.name},${event.target.value}` });
    event.target.value = "";
    event.target.blur();
  });
  $("here").addEventListener("click", async () => { if (await ask("goal_here") && view.now.mode !== "seek") notify("The goal is set: move the robot away and press Seek."); });
  $("speed").addEventListener("change", (event) => ask("speed", { factor: event.target.value === "null" ? null : Number(event.target.value) }).then(() => event.target.blur()));
  $("behavior").addEventListener("change", (event) => { if (event.target.value !== NAMED) askBehavior(event.target.value); event.target.blur(); });
  $("tour").addEventListener("change", (event) => { askBehavior(view.now.goal.name); event.target.blur(); });
  for (const id of ["shield", "online"]) $(id).addEventListener("change", async (event) => {
    pendingSwitch = id;
    await ask(id, { on: event.target.checked });
    setTimeout(() => { pendingSwitch = null; if (view.now) event.target.checked = view.now[id]; }, 300);
  });
  $("reset").addEventListener("click", restart);
  $("save-mind").addEventListener("click", async () => { const reply = await ask("save_mind"); if (reply) saveFile(reply.file); });
  $("save-goal").addEventListener("click", async () => { const reply = await ask("save_goal"); if (reply) saveFile(reply.file); });
  $("record").addEventListener("click", () => ask("record", { on: !(view.now.shown && view.now.shown[0]) }));
  $("goal-shown").addEventListener("click", async () => { if (await ask("goal_shown")) notify("The goal is what was shown."); });
  $("load-mind").addEventListener("click", () => choose(".mind", loadMind));
  $("load-goal").addEventListener("click", () => choose(".toml", loadGoal));
  $("steer").addEventListener("click", () => ask("steer", { token, over: true }));
  // The space bar stops the robot whatever has the focus; Enter presses buttons.
  const space = (event) => {
    if (event.code !== "Space" || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.type !== "keydown" || event.repeat) return;
    if (recording()) playOrPause(); else ask("stop");
  };
  window.addEventListener("keydown", space, true);
  window.addEventListener("keyup", space, true);
}

bindControls();
showers.now.push(showMode, showCounts);
showers.maps.push(() => { if (view.now) showMode(view.now); });
showers.memory.push(() => { if (view.now) showMode(view.now); });
showers.scene.push(showSetup, showGoalChoice);
showers.seat.push(showSeat);
showers.gone.push(() => { showSeat(view.seat); say($("seat"), "no connection to the program: trying again"); });
