// The player: one page for each recording, and one time for all of them.

import { LINK_HINT, readToken } from "./connection.js";
import { SpeedButtons } from "./speeds.js";

const get = (id) => document.getElementById(id);
const RETRY_MS = 1000;
const SPEEDS = [0.1, 0.5, 1, 2, 5, 10];
const SHOWN_S = 0.05; // a smaller difference of times is a rounding error of the slider

let recordings = [];
let socket = null;
let isBusy = false; // the server has not answered the last message
let wanted = null; // the newest message that waits for this answer
let stepsLeft = 0; // the steps that wait for it
let time = 0;
let isPlaying = false;
let speed = null;
let frameAt = 0;

function connect() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  socket = new WebSocket(`${scheme}//${location.host}/player`);
  socket.onopen = () => socket.send(JSON.stringify({ type: "hello", token }));
  socket.onmessage = (event) => receive(JSON.parse(event.data));
  socket.onclose = (event) => {
    setPlaying(false);
    [isBusy, stepsLeft] = [false, 0];
    if (event.code === 4401) return add(get("screens"), "p", LINK_HINT);
    get("clock").textContent = "not connected";
    setTimeout(connect, RETRY_MS);
  };
}

function receive(message) {
  if (message.type === "player") return begin(message);
  isBusy = false;
  if (wanted) return flush();
  if (stepsLeft) return sendStep();
  if (!isPlaying) show(message.time);
}

function begin(message) {
  recordings = message.recordings;
  get("screens").replaceChildren(...recordings.map(buildScreen)); // those of a new command may be others
  document.title = recordings.map((each) => each.name).join(", ");
  get("slider").min = Math.min(...recordings.map((each) => each.begin));
  get("slider").max = Math.max(...recordings.map((each) => each.end));
  show(message.time);
}

function add(parent, tag, textContent = "") {
  return parent.appendChild(Object.assign(document.createElement(tag), { textContent }));
}

function buildScreen(recording, index) {
  const screen = document.createElement("section");
  const head = add(screen, "h2");
  add(head, "span", recording.name);
  add(head, "span").className = "ended";
  const problems = add(screen, "ul");
  problems.className = "problems";
  for (const text of recording.problems) add(problems, "li", text);
  const frame = add(screen, "iframe");
  frame.title = recording.name;
  frame.src = `${index + 1}/`;
  return screen;
}

function send(message) {
  wanted = message;
  if (!isBusy) flush();
}

function flush() {
  if (socket.readyState !== WebSocket.OPEN) return;
  socket.send(JSON.stringify(wanted));
  [wanted, isBusy] = [null, true];
}

function show(seconds) {
  time = seconds;
  get("slider").value = time;
  get("clock").textContent = `${time.toFixed(2)} s of ${Number(get("slider").max).toFixed(2)} s`;
  document.querySelectorAll(".ended").forEach((label, index) => {
    const { begin: first, end } = recordings[index];
    label.textContent = time > end + SHOWN_S ? `ended at ${end.toFixed(2)} s` : time < first - SHOWN_S ? `begins at ${first.toFixed(2)} s` : "";
  });
}

function seek(seconds) {
  stepsLeft = 0;
  show(Math.min(Number(get("slider").max), Math.max(Number(get("slider").min), seconds)));
  send({ type: "seek", time });
}

// end: "min" or "max", the first tick or the last one.
function jump(end) {
  setPlaying(false);
  seek(Number(get("slider")[end]));
}

function step(by) {
  setPlaying(false);
  stepsLeft += by;
  if (!isBusy) sendStep();
}

function sendStep() {
  const by = Math.sign(stepsLeft);
  if (!by) return;
  stepsLeft -= by;
  send({ type: "step", by });
}

function setPlaying(value) {
  isPlaying = value;
  get("play").textContent = isPlaying ? "Pause" : "Play";
  frameAt = performance.now();
  if (isPlaying) requestAnimationFrame(play);
}

function play(now) {
  if (!isPlaying) return;
  if (!isBusy) {
    const passed = Math.max(0, now - frameAt) / 1000;
    frameAt = now;
    seek(time + passed * speed);
    if (time >= Number(get("slider").max)) return setPlaying(false);
  }
  requestAnimationFrame(play);
}

function setSpeed(value) {
  speed = value;
  speeds.show(speed);
}

function toggle() {
  if (!isPlaying && time >= Number(get("slider").max)) show(Number(get("slider").min));
  setPlaying(!isPlaying);
}

const token = readToken(); // before the pages of the recordings, which read it from the session
const speeds = new SpeedButtons(get("speed"), SPEEDS, setSpeed);
setSpeed(1);
connect();
get("play").addEventListener("click", toggle);
get("back").addEventListener("click", () => step(-1));
get("forward").addEventListener("click", () => step(1));
get("slider").addEventListener("input", () => {
  setPlaying(false);
  seek(Number(get("slider").value));
});
const KEYS = new Map([["Space", toggle], ["ArrowLeft", () => step(-1)], ["ArrowRight", () => step(1)], ["Home", () => jump("min")], ["End", () => jump("max")]]);
window.addEventListener("message", ({ origin, data }) => origin === location.origin && KEYS.get(data)?.()); // a key in a page
for (const type of ["keydown", "keyup"]) {
  window.addEventListener(type, (event) => {
    if (!KEYS.has(event.code) || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault(); // the key must not also press the button, or move the slider, that has the focus
    if (type === "keydown" && !(event.repeat && event.code === "Space")) KEYS.get(event.code)();
  });
}
