// The drawing of each kind of device: a function that builds the SVG, and returns a function that shows values.

const NAMESPACE = "http://www.w3.org/2000/svg";
const TURN = 2 * Math.PI;

function add(parent, tag, attributes = {}) {
  const element = document.createElementNS(NAMESPACE, tag);
  set(element, attributes);
  return parent.appendChild(element);
}

function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
}

const clamp = (value, least, most) => Math.min(most, Math.max(least, value));
const point = (angle, radius, x = 0, y = 0) => `${(x + radius * Math.cos(angle)).toFixed(2)},${(y - radius * Math.sin(angle)).toFixed(2)}`;

// A pie from one angle to another, anticlockwise from the right, around a point.
function pie(from, to, radius, x = 0, y = 0) {
  if (to - from >= TURN - 1e-6) return `M${point(0, radius, x, y)}A${radius},${radius} 0 1 0 ${point(Math.PI, radius, x, y)}A${radius},${radius} 0 1 0 ${point(0, radius, x, y)}Z`;
  const large = to - from > Math.PI ? 1 : 0;
  return `M${x},${y}L${point(from, radius, x, y)}A${radius},${radius} 0 ${large} 0 ${point(to, radius, x, y)}Z`;
}

function drawRange(svg, { settings }) {
  set(svg, { viewBox: "0 -42 160 84" });
  const half = clamp((settings.cone_rad ?? 0.3) / 2, 0.09, 0.5);
  const reach = settings.max_range_m ?? 4;
  add(svg, "path", { class: "well", d: pie(-half, half, 144, 10, 0) });
  const beam = add(svg, "path", { class: "soft" });
  const echo = add(svg, "path", { class: "mark" });
  add(svg, "rect", { class: "ink", x: 2, y: -9, width: 8, height: 18, rx: 2 });
  return ({ values: { distance } }) => {
    const radius = distance === null ? 144 : 144 * Math.sqrt(clamp(distance / reach, 0.003, 1)); // near echoes matter most
    set(beam, { d: pie(-half, half, radius, 10, 0) });
    set(echo, { d: distance === null ? "" : `M${point(-half, radius, 10, 0)}A${radius},${radius} 0 0 0 ${point(half, radius, 10, 0)}` });
  };
}

function drawRays(svg, { settings }) {
  set(svg, { viewBox: "-44 -44 88 88" });
  for (const radius of [14, 28, 42]) add(svg, "circle", { class: radius === 42 ? "well" : "faint", r: radius });
  const shape = add(svg, "path", { class: "soft" });
  const echoes = add(svg, "path", { class: "mark", "stroke-width": 2 });
  add(svg, "path", { class: "ink", d: "M0,-5L3.5,4L-3.5,4Z" });
  return ({ rays }) => {
    if (!rays) return;
    const { start, end, distances } = rays;
    const reach = settings.max_range_m ?? Math.max(1, ...distances);
    const angle = (index) => Math.PI / 2 + start + ((end - start) * index) / Math.max(1, distances.length - 1);
    const radii = distances.map((distance) => (distance === null ? null : 42 * Math.sqrt(clamp(distance / reach, 0, 1))));
    set(shape, { d: `M0,0L${radii.map((radius, index) => point(angle(index), radius ?? 42)).join("L")}Z` });
    set(echoes, { d: radii.map((radius, index) => (radius === null ? "" : `M${point(angle(index), radius)}h.01`)).join("") });
  };
}

function drawImu(svg) {
  set(svg, { viewBox: "-80 -42 160 84" });
  add(svg, "circle", { class: "well", cx: -34, r: 38 });
  for (let index = 0; index < 8; index++) {
    const angle = (index * TURN) / 8;
    add(svg, "path", { class: "line", d: `M${point(angle, 33, -34)}L${point(angle, 38, -34)}` });
  }
  const needle = add(svg, "path", { class: "ink" });
  const turn = add(svg, "path", { class: "mark" });
  add(svg, "rect", { class: "well", x: 22, y: -26, width: 52, height: 52, rx: 6 });
  add(svg, "path", { class: "faint", d: "M48,-26v52M22,0h52" });
  const push = add(svg, "circle", { class: "fill", r: 5, cx: 48, cy: 0 });
  return ({ values }) => {
    const angle = Math.PI / 2 + (values.heading ?? 0);
    set(needle, { d: `M${point(angle, 27, -34)}L${point(angle + 2.6, 14, -34)}L${point(angle - 2.6, 14, -34)}Z` });
    const swept = clamp(values.yaw_rate ?? 0, -3, 3);
    const [from, to] = swept > 0 ? [angle, angle + swept] : [angle + swept, angle];
    set(turn, { d: `M${point(from, 38, -34)}A38,38 0 ${to - from > Math.PI ? 1 : 0} 0 ${point(to, 38, -34)}` });
    set(push, {
      cx: 48 - 22 * clamp((values.left_acceleration ?? 0) / 3, -1, 1),
      cy: -22 * clamp((values.forward_acceleration ?? 0) / 3, -1, 1),
    });
  };
}

function drawEncoder(svg) {
  set(svg, { viewBox: "-44 -44 88 88" });
  add(svg, "circle", { class: "ink", r: 40 });
  add(svg, "circle", { class: "well", r: 31 });
  const spokes = add(svg, "g");
  for (let index = 0; index < 5; index++) {
    const angle = Math.PI / 2 + (index * TURN) / 5;
    add(spokes, "path", { class: index ? "line" : "mark", d: `M0,0L${point(angle, 29)}` });
  }
  add(svg, "circle", { class: "ink", r: 5 });
  return ({ values }) => set(spokes, { transform: `rotate(${(((values.angle ?? 0) % TURN) * 360) / TURN})` });
}

function drawMotor(svg, { settings }) {
  set(svg, { viewBox: "-80 -42 160 84" });
  const most = settings.max_velocity_rad_s ?? 10;
  add(svg, "rect", { class: "well", x: -74, y: -14, width: 148, height: 28, rx: 8 });
  const bar = add(svg, "rect", { class: "fill", y: -14, height: 28, rx: 4 });
  add(svg, "path", { class: "line", d: "M0,-21v42" });
  return ({ values }) => {
    const end = 74 * clamp((values.command ?? 0) / most, -1, 1);
    set(bar, { x: Math.min(0, end), width: Math.abs(end) });
  };
}

function drawBattery(svg, { settings }) {
  set(svg, { viewBox: "-80 -42 160 84" });
  add(svg, "rect", { class: "well", x: -58, y: -26, width: 110, height: 52, rx: 9 });
  add(svg, "rect", { class: "ink", x: 54, y: -11, width: 7, height: 22, rx: 3 });
  const level = add(svg, "rect", { x: -52, y: -20, height: 40, rx: 5 });
  return ({ values }) => {
    const limit = settings.warn_below_v;
    const isLow = limit !== null && limit !== undefined && values.voltage < limit;
    set(level, { class: isLow ? "bad" : "good", width: isLow ? 22 : 98 });
  };
}

function drawLineSensor(svg, { settings }) {
  const count = settings.count ?? 3;
  set(svg, { viewBox: "-80 -42 160 84" });
  const width = 148 / count;
  const cells = Array.from({ length: count }, (_, index) => {
    const box = { x: -74 + index * width + 1.5, y: -22, width: width - 3, height: 44, rx: 5 };
    add(svg, "rect", { class: "well", ...box });
    return add(svg, "rect", { class: "ink", ...box });
  });
  return ({ values }) => cells.forEach((cell, index) => set(cell, { "fill-opacity": clamp(values.values?.[index] ?? 0, 0, 1) }));
}

function drawBumper(svg, { settings }) {
  set(svg, { viewBox: "-44 -44 88 88" });
  const middle = Math.PI / 2 + (settings.direction_rad ?? 0);
  const half = (settings.width_rad ?? Math.PI) / 2;
  const sector = add(svg, "path", { class: "well", d: pie(middle - half, middle + half, 42) });
  add(svg, "circle", { class: "well", r: 30 });
  add(svg, "path", { class: "ink", d: "M0,-12L7,7L-7,7Z" });
  return ({ values }) => set(sector, { class: values.is_pressed ? "bad" : "well" });
}

function drawButton(svg) {
  set(svg, { viewBox: "-44 -44 88 88" });
  add(svg, "rect", { class: "well", x: -36, y: -36, width: 72, height: 72, rx: 14 });
  const cap = add(svg, "circle", { class: "ink", r: 23 });
  return ({ values }) => set(cap, values.is_pressed ? { class: "fill", r: 20 } : { class: "ink", r: 23 });
}

function drawLed(svg) {
  set(svg, { viewBox: "-44 -44 88 88" });
  const glow = add(svg, "circle", { r: 40 });
  add(svg, "circle", { class: "well", r: 24 });
  const light = add(svg, "circle", { r: 24, class: "faint" });
  return ({ values }) => {
    const parts = values.command ?? [0, 0, 0];
    const most = Math.max(...parts);
    const paint = `rgb(${parts.map((part) => Math.round(255 * (most ? part / most : 0))).join(" ")})`;
    set(glow, { fill: paint, "fill-opacity": 0.28 * most });
    light.style.fill = paint;
    light.style.fillOpacity = most;
  };
}

function drawBuzzer(svg) {
  set(svg, { viewBox: "-44 -44 88 88" });
  add(svg, "path", { class: "ink", d: "M-34,-10h14l16,-15v50l-16,-15h-14Z" });
  const waves = [14, 25, 36].map((radius) => add(svg, "path", { class: "mark", d: `M${point(-0.7, radius, -2)}A${radius},${radius} 0 0 0 ${point(0.7, radius, -2)}` }));
  return ({ values }) => waves.forEach((wave) => set(wave, { "stroke-opacity": values.command ? 1 : 0.12 }));
}

function drawServo(svg, { settings }) {
  set(svg, { viewBox: "-80 -62 160 84" });
  const [least, most] = [settings.min_angle_rad ?? -1.57, settings.max_angle_rad ?? 1.57];
  add(svg, "path", { class: "well", d: pie(Math.PI / 2 + least, Math.PI / 2 + most, 58) });
  const arm = add(svg, "path", { class: "mark" });
  add(svg, "circle", { class: "ink", r: 8 });
  return ({ values }) => set(arm, { d: `M0,0L${point(Math.PI / 2 + clamp(values.command ?? 0, least, most), 54)}` });
}

function drawGamepad(svg) {
  set(svg, { viewBox: "-80 -42 160 84" });
  add(svg, "rect", { class: "well", x: -76, y: -32, width: 152, height: 64, rx: 30 });
  const sticks = ["left", "right"].map((side, index) => {
    const x = index ? 16 : -46;
    add(svg, "circle", { class: "faint", cx: x, cy: 4, r: 17 });
    return { side, x, knob: add(svg, "circle", { class: "ink", cx: x, cy: 4, r: 9 }) };
  });
  const places = { south: [54, 16], east: [66, 4], north: [54, -8], west: [42, 4], start: [6, -20], select: [-18, -20] };
  const buttons = Object.entries(places).map(([name, [cx, cy]]) => ({ name, dot: add(svg, "circle", { cx, cy, r: 5 }) }));
  return ({ values }) => {
    for (const { side, x, knob } of sticks) set(knob, { cx: x + 9 * (values[`${side}_x`] ?? 0), cy: 4 - 9 * (values[`${side}_y`] ?? 0) });
    for (const { name, dot } of buttons) set(dot, { class: values[name] ? "fill" : "faint" });
  };
}

const DRAWINGS = {
  battery: drawBattery, bumper: drawBumper, button: drawButton, buzzer: drawBuzzer, encoder: drawEncoder,
  gamepad: drawGamepad, imu: drawImu, led: drawLed, lidar: drawRays, line_sensor: drawLineSensor, motor: drawMotor,
  range_sensor: drawRange, servo: drawServo,
};
const OLD_S = 0.5;

// The card of a device. A kind without a drawing has its values as text.
export class DeviceCard {
  constructor(device) {
    this.device = device;
    this.element = document.createElement("article");
    this.element.className = "card device is-silent";
    this.element.dataset.device = device.name;
    this.element.innerHTML = '<header><h3></h3><span></span></header><p class="kind"></p><p class="value"></p>';
    this.element.querySelector("h3").textContent = device.name;
    this.element.querySelector(".kind").textContent = device.kind.replaceAll("_", " ");
    this.age = this.element.querySelector("header span");
    this.value = this.element.querySelector(".value");
    this.value.textContent = device.is_sensor ? "not read yet" : "no command yet";
    this.show = null;
  }

  // A camera and a display have their newest picture as their drawing.
  drawPicture(picture) {
    this.canvas ??= this.element.insertBefore(document.createElement("canvas"), this.value);
    Object.assign(this.canvas, { width: picture.width, height: picture.height });
    this.canvas.getContext("2d").drawImage(picture, 0, 0);
  }

  update(sample) {
    this.element.classList.toggle("is-silent", !sample);
    if (!sample) return;
    const draw = DRAWINGS[this.device.kind] ?? (sample.rays ? drawRays : null);
    if (!this.show && draw) {
      const svg = document.createElementNS(NAMESPACE, "svg");
      this.element.insertBefore(svg, this.value);
      this.show = draw(svg, this.device);
    }
    this.show?.(sample);
    if (this.value.textContent !== sample.text) {
      this.value.textContent = sample.text;
      this.value.classList.toggle("is-long", sample.text.length > 32);
    }
    if ((sample.age ?? null) === null) return;
    this.age.textContent = sample.age < 1 ? `${Math.round(sample.age * 1000)} ms` : `${sample.age.toFixed(1)} s`;
    this.age.title = "the age of the sample";
    this.age.classList.toggle("is-old", sample.age > OLD_S && this.device.kind !== "battery");
  }
}
