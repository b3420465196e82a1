// The socket: receives snapshot parts and sends commands.
const view = { scene: null, maps: null, memory: [], places: null, now: null, trail: new Map(), heard: new Map(), seat: { you: false, taken: false, viewers: 0 } };
const showers = { scene: [], maps: [], memory: [], places: [], now: [], trail: [], heard: [], seat: [], gone: [] };
const waiting = new Map();
let socket = null;
let commandCount = 0;

// The token comes in the fragment, which browsers never send, and is removed from the address at once.
function findToken() {
  const found = /^#token=([0-9a-f]+)$/.exec(location.hash);
  if (found) {
    sessionStorage.setItem("token", found[1]);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token");
}
const token = findToken();

function sendCommand(what, details) {
  return new Promise((resolve, reject) => {
    if (!socket || socket.readyState !== WebSocket.OPEN) return reject(new Error("no connection to the program"));
    commandCount += 1;
    waiting.set(commandCount, { resolve, reject });
    socket.send(JSON.stringify({ id: commandCount, do: what, ...details }));
  });
}

// Sends a command and shows a refusal to the user.
const ask = (what, details) => sendCommand(what, details).catch((why) => { notify(why.message); return null; });

function receive(message) {
  if ("reply" in message) {
    const asked = waiting.get(message.reply);
    waiting.delete(message.reply);
    if (!asked) return;
    if (message.error) asked.reject(new Error(message.error)); else asked.resolve(message);
    return;
  }
  if (message.part === "trail" || message.part === "heard") view[message.part].set(message.index, message.value);
  else view[message.part] = message.value;
  for (const show of showers[message.part] || []) show(message.value, message.index);
}

function connect(pause) {
  const query = token ? `?token=${token}` : "";
  socket = new WebSocket(`ws://${location.host}/socket${query}`);
  let next = Math.min(pause * 2, 5000);
  socket.onopen = () => {
    next = 250;
    view.trail.clear();
    view.heard.clear();
    if (token) sendCommand("steer", { token }).catch((why) => notify(why.message));
  };
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = () => {
    for (const asked of waiting.values()) asked.reject(new Error("no connection to the program"));
    waiting.clear();
    view.seat = { you: false, taken: false, viewers: 0 };
    for (const show of showers.gone) show();
    setTimeout(() => connect(next), next);
  };
}

let noticed = 0;
function notify(text) {
  const notice = $("notice");
  notice.textContent = text;
  notice.hidden = false;
  clearTimeout(noticed);
  noticed = setTimeout(() => { notice.hidden = true; }, 5000);
}
