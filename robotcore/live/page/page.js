// The live page: shows the messages of a run, and presses its e-stop.

import { Connection, LINK_HINT } from "./connection.js";
import { buildControl } from "./controls.js";
import { DeviceCard } from "./drawings.js";
import { Estop } from "./estop.js";
import { Overhead } from "./overhead.js";
import { WheelPlot } from "./plot.js";
import { Pictures, Tabs } from "./pictures.js";
import { Driving } from "./driving.js";
import { hideScreen, offerClosing, showScreen } from "./screen.js";
import { SpeedButtons } from "./speeds.js";

const get = (id) => document.getElementById(id);
const MAX_LOG_LINES = 300;
const QUIET_MS = 1500;
const NOTICE_MS = 1200;
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10, null];
const UNNAMED_CAUSES = ["acceleration limit"]; // it changes nearly every command, and is no problem

const overhead = new Overhead(get("map"));
const plot = new WheelPlot(get("wheels"));
const cameras = new Pictures(get("camera"), new Tabs(get("camera-tabs")), get("camera-card"));
const maps = new Tabs(get("map-tabs"));
let run = null;
let cards = new Map();
let tick = null;
let tickAt = 0;
let hasEnded = false;
const isRecording = document.body.classList.contains("is-recording");
let isDirty = false;
let mapPicture = null;
const notices = new Map();

const send = (message) => connection.send(message);
const driving = new Driving(send);
const estop = new Estop(get("estop"), send);
const speeds = new SpeedButtons(get("speed"), SPEEDS, (speed) => send({ type: "pace", speed }));
const connection = new Connection({ receive, show: showPicture, change: showConnection });

function receive(message) {
  const handlers = { run: beginRun, history: showHistory, tick: showTick, line: addLine, end: showEnd, viewers: showViewers, timing: showTiming };
  handlers[message.type]?.(message);
  requestDrawing();
}

function beginRun(message) {
  [run, tick, mapPicture] = [message, null, null];
  setEnded(false);
  const place = [run.backend, run.robot, run.world, run.seed === null ? null : `seed ${run.seed}`];
  get("app").textContent = run.app;
  document.title = `${run.app} on ${run.backend}`;
  get("where").textContent = place.filter(Boolean).join(" · ");
  overhead.reset(run);
  plot.reset(run.drive);
  cameras.reset();
  maps.reset(["world"]);
  notices.clear();
  for (const id of ["log", "values"]) get(id).replaceChildren();
  for (const id of ["state", "time", "pose"]) get(id).textContent = "";
  get("values-card").hidden = true;
  get("map-card").hidden = get("wheels-card").hidden = !run.drive;
  get("measured-key").hidden = !run.drive?.is_measured;
  get("milestones-card").hidden = !run.milestones.length;
  get("milestones").replaceChildren(...run.milestones.map(buildMilestone));
  driving.reset(run);
  get("pace-card").hidden = !run.can_pace;
  get("timing-card").hidden = true;
  const shown = run.devices.filter((device) => device.kind !== "operator"); // the joystick is its drawing
  cards = new Map(shown.map((device) => [device.name, new DeviceCard(device)]));
  for (const card of cards.values()) {
    const control = buildControl(card.device, run.actuators, send);
    if (control) card.element.append(control);
  }
  get("devices").replaceChildren(...[...cards.values()].map((card) => card.element));
  arrangeDevices();
  offerClosing(false);
  hideScreen();
}

// Fills the rows of the devices evenly, so that the last row does not have one device alone.
function arrangeDevices() {
  const list = get("devices");
  const most = Math.max(1, Math.floor((list.clientWidth + 14) / (172 + 14))); // with the gap of style.css
  const rows = Math.ceil(cards.size / most) || 1;
  list.style.setProperty("--columns", Math.ceil(cards.size / rows) || 1);
}

function buildMilestone(name) {
  const item = document.createElement("li");
  item.dataset.name = name;
  item.append(...[name, ""].map((text) => Object.assign(document.createElement("span"), { textContent: text })));
  return item;
}

function showHistory({ path, lines, wheels }) {
  overhead.setPath(path);
  if (run) plot.reset(run.drive);
  wheels.forEach((each) => plot.add(each));
  get("log").replaceChildren();
  lines.forEach(addLine);
}

function showTick(message) {
  [tick, tickAt] = [message, performance.now()];
  offerClosing(true);
  overhead.add(tick);
  (tick.wheels ?? []).forEach((each) => plot.add(each));
  plot.add(tick);
  const until = isRecording ? Infinity : tickAt + NOTICE_MS;
  if (isRecording) notices.clear();
  for (const cause of tick.interventions) {
    if (UNNAMED_CAUSES.includes(cause)) continue;
    notices.set(`${cause} ${cause === "range guard" ? "holds" : "limits"} the robot`, until);
  }
  for (const fault of tick.faults) notices.set(`fault: ${fault}`, until);
  if (isRecording && tick.is_hand_driven) notices.set("a person drives the robot", until);
}

function addLine({ level, time, text }) {
  const log = get("log");
  const isAtEnd = log.scrollTop + log.clientHeight >= log.scrollHeight - 20;
  const item = document.createElement("li");
  item.className = level;
  item.append(
    Object.assign(document.createElement("time"), { textContent: `${time.toFixed(2)} s` }),
    Object.assign(document.createElement("span"), { textContent: text }),
  );
  log.append(item);
  while (log.childElementCount > MAX_LOG_LINES) log.firstChild.remove();
  if (isAtEnd) log.scrollTop = log.scrollHeight;
}

function showTiming({ phases }) {
  const names = Object.keys(phases);
  get("timing-card").hidden = !names.length;
  get("timing").replaceChildren(...names.map((name) => {
    const { p50, p99, worst } = phases[name];
    const row = document.createElement("tr");
    const texts = [name, ...[p50, p99, worst].map((us) => (us / 1000).toFixed(2))];
    row.append(...texts.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
}

function showViewers({ count, operator }) {
  showOperator(operator);
  get("viewers").textContent = count === 1 ? "1 viewer" : `${count} viewers`;
}

// operator: "you", "other" or "none"; without a connection, "lost".
function showOperator(operator) {
  const shown = hasEnded ? "ended" : operator;
  driving.showOperator(shown);
  get("pace-card").inert = ["lost", "ended"].includes(shown);
  for (const control of document.querySelectorAll(".control")) control.disabled = shown !== "you";
}

function setEnded(value) {
  hasEnded = value;
  document.body.classList.toggle("has-ended", hasEnded);
  hasEnded ? estop.end() : estop.reset();
}

async function showPicture(name, blob) {
  if (name === "@world") {
    overhead.world = await createImageBitmap(blob);
  } else if (name === "@map") {
    mapPicture = await createImageBitmap(blob);
    maps.add("map");
    get("map-card").hidden = false;
  } else {
    await cameras.show(name, blob, cards.get(name));
  }
  requestDrawing();
}

function requestDrawing() {
  if (!isDirty) requestAnimationFrame(draw);
  isDirty = true;
}

// The value of a name that an app or a robot's file has chosen, such as "constructor".
function getOwn(values, name) {
  return Object.hasOwn(values, name) ? values[name] : undefined;
}

function draw() {
  isDirty = false;
  if (!run) return;
  if (!get("map-card").hidden) maps.chosen === "map" && mapPicture ? drawMap() : overhead.draw();
  if (!get("wheels-card").hidden) plot.draw();
  if (!tick) return;
  if (!hasEnded) get("state").textContent = tick.state;
  get("time").textContent = `${tick.time.toFixed(1)} s`;
  for (const [name, card] of cards) card.update(getOwn(tick.devices, name));
  for (const item of get("milestones").children) {
    const time = getOwn(tick.milestones, item.dataset.name);
    item.classList.toggle("is-reached", time !== undefined);
    item.lastChild.textContent = time === undefined ? "" : `${time.toFixed(1)} s`;
  }
  showPose();
  showPace();
  driving.show(tick.is_hand_driven);
  get("overruns").textContent = tick.overruns === 1 ? "1 overrun" : `${tick.overruns} overruns`;
  showValues();
  showNotices();
}

function showPace() {
  if (!tick.pace) return;
  const { speed, is_paused: isPaused } = tick.pace;
  get("pace-state").textContent = isPaused ? "paused" : "";
  get("pause").textContent = isPaused ? "Resume" : "Pause";
  get("step").disabled = !isPaused;
  speeds.show(speed);
}

// The values that the app logs.
function showValues() {
  const list = get("values");
  const names = Object.keys(tick.logged);
  get("values-card").hidden = !names.length;
  if (names.join("\n") !== [...list.querySelectorAll("dt")].map((name) => name.textContent).join("\n")) {
    list.replaceChildren(...names.flatMap((name) => [Object.assign(document.createElement("dt"), { textContent: name }), document.createElement("dd")]));
  }
  names.forEach((name, index) => {
    const { value, unit } = tick.logged[name];
    const text = typeof value === "number" && !Number.isInteger(value) ? value.toFixed(3) : String(value ?? "not a number");
    list.children[2 * index + 1].textContent = `${text} ${unit}`.trim();
  });
}

function drawMap() {
  const canvas = get("map");
  const context = canvas.getContext("2d");
  [canvas.width, canvas.height] = [mapPicture.width, mapPicture.height];
  context.drawImage(mapPicture, 0, 0);
}

function showPose() {
  const pose = tick.truth ?? tick.pose;
  if (!pose || pose.includes(null)) return;
  const [x, y, heading] = pose;
  const degrees = ((heading * 180) / Math.PI).toFixed(0);
  get("pose").textContent = `${tick.truth ? "true pose" : "odometry"}: x ${x.toFixed(2)} m, y ${y.toFixed(2)} m, heading ${degrees}°`;
}

function showNotices() {
  const now = performance.now();
  for (const [text, until] of notices) if (until < now) notices.delete(text);
  const list = get("notices");
  const wanted = [...notices.keys()];
  if (wanted.join("\n") === [...list.children].map((item) => item.textContent).join("\n")) return;
  list.replaceChildren(...wanted.map((text) => Object.assign(document.createElement("li"), { textContent: text })));
}

const STATES = { open: "open", lost: "lost", token: "lost", full: "lost" };

function showConnection(state) {
  if (state === "token" || state === "full") setEnded(false); // a run answers, which the page cannot show
  get("link").dataset.state = hasEnded ? "quiet" : STATES[state];
  if (state === "open") return;
  showOperator("lost");
  get("viewers").textContent = "not connected";
  if (state === "token") {
    showScreen("bad", "!", "This page needs its whole link", LINK_HINT);
  } else if (state === "full") {
    showScreen("fair", "!", "Too many viewers", "Close the page in another window or on another device, then load it here again.");
  } else if (isRecording) {
    showScreen("fair", "■", "The viewer has ended", "Start robotcore view again.");
  } else if (!hasEnded) {
    showScreen("fair", "…", "Connection lost", "The page connects again by itself. The robot may still move: the stop button keeps trying.");
  }
}

function showEnd({ headline, reason, exit_status: status, notes }) {
  setEnded(true);
  showOperator("ended");
  get("state").textContent = `ended: ${headline}`;
  const isStopped = headline.startsWith("stopped");
  showScreen(status === 0 ? "good" : "bad", status === 0 ? "✓" : isStopped ? "■" : "✕", `The run has ended: ${headline}`, reason, notes);
}

// The keys of the player, which contains the page of a recording.
function passKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (!["Space", "ArrowLeft", "ArrowRight", "Home", "End"].includes(event.code)) return;
  event.preventDefault();
  if (event.type === "keydown" && !(event.repeat && event.code === "Space")) parent.postMessage(event.code, location.origin);
}

maps.onchoose = cameras.tabs.onchoose = requestDrawing;
for (const type of ["keydown", "keyup"]) {
  window.addEventListener(type, (event) => {
    isRecording ? passKey(event) : estop.handleKey(event);
  }, { capture: true });
}
get("pause").addEventListener("click", () => send({ type: "pace", is_paused: !tick?.pace.is_paused }));
get("step").addEventListener("click", () => send({ type: "pace", steps: 1 }));
window.addEventListener("resize", () => {
  arrangeDevices();
  requestDrawing();
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", requestDrawing);
setInterval(() => {
  const isQuiet = tick && !hasEnded && !isRecording && performance.now() - tickAt > QUIET_MS; // such as a paused run
  if (connection.isOpen && tick) get("link").dataset.state = isQuiet ? "quiet" : "open";
  showNotices();
}, 300);
