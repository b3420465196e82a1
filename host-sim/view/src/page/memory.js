// The lazy memory: a row per sample, with its best neurons.
const memory = { rows: [], looked: null };

// A situation as 16 cells, counter-clockwise from the front.
function strip(values) {
  const cells = values.map((value, place) => {
    const color = value === null ? "transparent" : `color-mix(in srgb, var(--value) ${(100 * value).toFixed(0)}%, var(--card))`;
    return `${color} ${(place * 6.25).toFixed(2)}% ${((place + 1) * 6.25).toFixed(2)}%`;
  });
  return `linear-gradient(to right, ${cells.join(", ")})`;
}

function cell(row, text, kind) {
  const cell = document.createElement("td");
  if (kind) cell.className = kind;
  if (text !== null) cell.textContent = text;
  row.append(cell);
  return cell;
}

function showMemory(samples) {
  $("memory-empty").hidden = samples.length > 0;
  $("rows").hidden = samples.length === 0;
  say($("memory-count"), samples.length ? `${samples.length} moves, cells: sonar 0 to 15` : "");
  const body = $("samples");
  // A new exploration starts with fewer rows.
  if (samples.length < memory.rows.length) { body.replaceChildren(); memory.rows = []; }
  for (let index = memory.rows.length; index < samples.length; index += 1) body.append(sampleRow(samples[index], index));
  showTrained();
}

function sampleRow(sample, index) {
  const row = document.createElement("tr");
  cell(row, String(index + 1));
  for (const place of ["before", "move", "after"]) {
    if (place === "move") {
      const [x, y] = sample.moved_m;
      const turn = Math.round(Math.atan2(y, x) / (2 * Math.PI) * 8 + 8) % 8;
      const still = Math.hypot(x, y) < 0.005;
      cell(row, `${still ? "·" : "↑↖←↙↓↘→↗"[turn]} ${fixed(100 * Math.hypot(x, y), 0)} cm`);
    } else {
      const bars = document.createElement("span");
      bars.style.background = strip(sample[place]);
      cell(row, null, "strip").append(bars);
    }
  }
  const trained = [cell(row, ""), cell(row, "")];
  row.addEventListener("pointerenter", () => { memory.looked = index; showTrained(); });
  row.addEventListener("pointerleave", () => { memory.looked = null; showTrained(); });
  memory.rows.push({ row, trained });
  return row;
}

// Highlights the rows of the selected and the current neuron, and the neurons of the selected row.
function showTrained() {
  const seen = view.maps;
  const pairs = seen && seen.learned ? seen.rows : [];
  const { situations, changes } = maps.shown;
  const here = view.now && view.now.plan ? view.now.plan.current : null;
  memory.rows.forEach(({ row, trained }, index) => {
    const pair = pairs[index];
    say(trained[0], pair ? `N${pair[0] + 1}` : "");
    say(trained[1], pair ? `A${pair[1] + 1}` : "");
    const shown = pair && ((situations !== null && pair[0] === situations) || (changes !== null && pair[1] === changes));
    row.classList.toggle("shown", !!shown);
    row.classList.toggle("here", !!pair && pair[0] === here);
  });
  const pair = memory.looked === null ? null : pairs[memory.looked];
  ["situations", "changes"].forEach((name, place) => maps[name].forEach((tile, neuron) => show(tile.trained, pair && pair[place] === neuron)));
}

let herePlan = null;
showers.memory.push(showMemory);
showers.maps.push(() => showTrained());
showers.now.push((now) => {
  const here = now.plan ? now.plan.current : null;
  if (here !== herePlan) { herePlan = here; showTrained(); }
});
