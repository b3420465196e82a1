// The history: a column per decision, the oldest on the left, and the nearest range as a line.
const trail = { root: $("trail"), looked: null, queued: false };

function allMarks() {
  const first = view.now && view.now.at === null ? view.now.trail[0] : 0;
  const pieces = [...view.trail.entries()].filter(([index]) => index >= first).sort((a, b) => a[0] - b[0]);
  return pieces.flatMap(([, marks]) => marks);
}

function drawTrail() {
  trail.queued = false;
  const canvas = trail.root;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const scale = window.devicePixelRatio || 1;
  if (!width) return;
  if (canvas.width !== Math.round(width * scale)) { canvas.width = Math.round(width * scale); canvas.height = Math.round(height * scale); }
  const pen = canvas.getContext("2d");
  const style = getComputedStyle(document.documentElement);
  const color = (name) => style.getPropertyValue(`--${name}`).trim();
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  const marks = allMarks();
  trail.marks = marks;
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = color("gray");
  if (!marks.length) {
    pen.font = "13px system-ui, sans-serif";
    pen.fillText("No decisions yet.", 8, height / 2 + 4);
    return sayTrail();
  }
  const [left, top, bottom] = [34, 4, height - 26];
  // A few decisions do not fill the whole width.
  const step = Math.min((width - left - 4) / marks.length, 6);
  trail.scale = { left, step };
  const reach = view.scene ? view.scene.near_far_m[1] : 4;
  const y = (range) => bottom - (bottom - top) * Math.min(range < 0 ? reach : range, reach) / reach;
  pen.strokeStyle = color("faint");
  pen.strokeRect(left + 0.5, top + 0.5, Math.max(step * marks.length, 1), bottom - top);
  pen.textAlign = "right";
  pen.fillText(`${fixed(reach, 1)} m`, left - 3, top + 9);
  pen.fillText("0", left - 3, bottom + 2);
  const at = view.now && view.now.at !== null ? view.now.at : marks.length;
  marks.forEach((mark, index) => {
    if (index === at) pen.globalAlpha = 0.35;
    const x = left + index * step;
    const wide = Math.max(step, 0.6);
    pen.fillStyle = color(mark[3] ? "value" : "explore");
    pen.fillRect(x, bottom + 3, wide, 7);
    if (mark[4] & 4) { pen.fillStyle = color("held"); pen.fillRect(x, bottom + 11, wide, 5); }
    if (mark[4] & 2) { pen.fillStyle = color("goal"); pen.fillRect(x, bottom + 17, wide, 5); }
    if (mark[4] & 1) { pen.fillStyle = color("up"); pen.globalAlpha *= 0.6; pen.fillRect(x, top, Math.max(wide, 1.5), bottom - top); pen.globalAlpha = index < at ? 1 : 0.35; }
  });
  pen.globalAlpha = 1;
  pen.lineWidth = 1.2;
  for (const [from, to, name] of [[Math.max(at - 1, 0), marks.length, "pale"], [0, Math.min(at, marks.length), "ink"]]) {
    pen.beginPath();
    marks.slice(from, to).forEach((mark, index) => pen[index ? "lineTo" : "moveTo"](left + (from + index + 0.5) * step, y(mark[6])));
    pen.strokeStyle = color(name);
    pen.stroke();
  }
  if (at < marks.length || (view.now && view.now.at !== null)) {
    // The current position in the recording.
    const x = left + at * step;
    pen.fillStyle = color("down");
    pen.fillRect(x - 1, 0, 2, bottom + 22);
    pen.beginPath();
    pen.moveTo(x - 5, 0);
    pen.lineTo(x + 5, 0);
    pen.lineTo(x, 7);
    pen.fill();
  }
  if (trail.looked !== null && trail.looked < marks.length) {
    pen.fillStyle = color("down");
    pen.fillRect(left + (trail.looked + 0.5) * step - 1, 0, 2, height);
  }
  sayTrail();
}

function sayTrail() {
  const marks = trail.marks || [];
  const mark = trail.looked === null ? null : marks[trail.looked];
  showGhost(mark);
  const last = Math.max(marks.length - 1, 0);
  set(trail.root, { "aria-valuemax": last, "aria-valuenow": trail.looked === null ? last : trail.looked });
  const text = mark ? `Decision ${trail.looked + 1} at ${fixed(mark[0], 1)} s: ${mark[3] ? "seeking" : "exploring"}${mark[5] >= 0 ? ` in N${mark[5] + 1}` : ""}, ` +
    `nearest ${mark[6] < 0 ? "none" : meters(mark[6])}${mark[4] & 1 ? ", touched" : ""}${mark[4] & 2 ? ", shield" : ""}${mark[4] & 4 ? ", at the goal" : ""}` :
    marks.length && recording() ? `${view.now.at} of ${marks.length} decisions: click one to jump there.` :
    marks.length ? `${marks.length} decisions${marks.length >= 6400 ? " (the latest ones)" : ""}: point at one to see where the robot was.` : "";
  set(trail.root, { "aria-valuetext": text });
  say($("trail-detail"), text);
}

const recording = () => !!view.scene && view.scene.abilities.jump;

// Jumps within a recording; of several requests during a jump only the latest counts.
function jump(to) {
  trail.target = to;
  if (trail.jumping) return;
  trail.jumping = true;
  const next = () => {
    const target = trail.target;
    trail.target = null;
    if (target === null) { trail.jumping = false; return; }
    ask("jump", { to: target }).then(next);
  };
  next();
}

function pointed(event) {
  if (!trail.scale || !trail.marks.length) return null;
  const index = Math.floor((event.offsetX - trail.scale.left) / trail.scale.step);
  return index >= 0 && index < trail.marks.length ? index : null;
}

function queueTrail() {
  if (!trail.queued) { trail.queued = true; requestAnimationFrame(drawTrail); }
}

trail.root.addEventListener("pointermove", (event) => {
  trail.looked = pointed(event);
  if (recording() && event.buttons & 1 && trail.looked !== null) jump(trail.looked + 1);
  queueTrail();
});
trail.root.addEventListener("pointerdown", (event) => {
  const index = pointed(event);
  if (recording() && index !== null) jump(index + 1);
});
$("at").addEventListener("input", (event) => jump(Number(event.target.value)));
trail.root.addEventListener("pointerleave", () => { trail.looked = null; queueTrail(); });
trail.root.addEventListener("blur", () => { trail.looked = null; queueTrail(); });
trail.root.addEventListener("keydown", (event) => {
  const count = (trail.marks || []).length;
  const at = trail.looked === null ? count - 1 : trail.looked;
  if (event.key === "Enter" && recording() && trail.looked !== null) return jump(trail.looked + 1);
  const next = { ArrowLeft: at - 1, ArrowRight: at + 1, PageUp: at - 20, PageDown: at + 20, Home: 0, End: count - 1 }[event.key];
  if (next === undefined || !count) return;
  event.preventDefault();
  trail.looked = Math.max(0, Math.min(next, count - 1));
  queueTrail();
});
window.addEventListener("resize", queueTrail);
showers.trail.push(queueTrail);
showers.now.push(queueTrail);
showers.now.push((now) => {
  if (now.at === null) return;
  const count = allMarks().length;
  set($("at"), { max: count, "aria-valuetext": `${now.at} of ${count} decisions` });
  if (!trail.jumping) $("at").value = now.at;
});
showers.scene.push((scene) => {
  $("at").hidden = !scene.abilities.jump;
  trail.root.classList.toggle("can", scene.abilities.jump);
});
