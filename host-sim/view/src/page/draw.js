// Drawing helpers. In rosettes the front of the ring is up, as in the printed pictures.
const $ = (id) => document.getElementById(id);

function svg(tag, attributes, parent) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  set(element, attributes || {});
  if (parent) parent.append(element);
  return element;
}

function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    const text = String(value);
    if (element.getAttribute(name) !== text) element.setAttribute(name, text);
  }
}

function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

const fixed = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const meters = (value) => `${fixed(value, 2)} m`;

// The point at `radius` in direction `bearing`; 0 is up, counter-clockwise.
const toward = (x, y, bearing, radius) => [x - radius * Math.sin(bearing), y - radius * Math.cos(bearing)];
const bearingOf = (sensor) => (2 * Math.PI * sensor) / 16;

// Outline of a rosette's bar between two radii.
function bar(x, y, sensor, from, to) {
  const half = 0.36 * 2 * Math.PI / 16;
  const at = (radius, side) => toward(x, y, bearingOf(sensor) + side * half, radius).map((v) => v.toFixed(1)).join(" ");
  return `M${at(from, 1)}L${at(to, 1)}L${at(to, -1)}L${at(from, -1)}Z`;
}

// The smallest round axis limit that covers all values.
function axisEnd(values) {
  const largest = values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
  return [0.1, 0.25, 0.5].find((end) => largest <= end && largest > 0) || 1;
}

// An arrow from (x, y) towards a displacement in the ring's frame.
function arrow(x, y, [forward, left], length, width) {
  if (!(length > 3)) return `M${x - 2} ${y}a2 2 0 1 0 4 0a2 2 0 1 0 -4 0`;
  const bearing = Math.atan2(left, forward);
  const head = Math.min(3.2 * width, 0.7 * length);
  const tip = toward(x, y, bearing, length);
  const neck = toward(x, y, bearing, length - head * 0.8);
  const back = toward(x, y, bearing, length - head);
  const wing = (side) => toward(back[0], back[1], bearing + side * Math.PI / 2, head * 0.5);
  const text = (point) => point.map((v) => v.toFixed(1)).join(" ");
  return `M${x} ${y}L${text(neck)}M${text(tip)}L${text(wing(1))}L${text(wing(-1))}Z`;
}

// A bearing in words.
function side(sensor) {
  const words = ["ahead", "ahead left", "left", "behind left", "behind", "behind right", "right", "ahead right"];
  return words[Math.round(sensor / 2) % 8];
}
