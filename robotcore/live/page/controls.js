// The controls of servos, lights and buzzers. Only the viewer who drives can use them.

const BUILDERS = { servo: buildServo, led: buildLed, buzzer: buildBuzzer };

// Returns the control of a device, or null for a device that a person cannot command.
// send: sends a message to the server.
export function buildControl(device, actuators, send) {
  const build = actuators.includes(device.name) ? BUILDERS[device.kind] : null;
  if (!build) return null;
  const fields = document.createElement("fieldset");
  fields.className = "control";
  build(fields, device, (...value) => send({ type: "actuate", device: device.name, value, sent: performance.now() }));
  return fields;
}

function addInput(fields, attributes) {
  return fields.appendChild(Object.assign(document.createElement("input"), attributes));
}

function buildServo(fields, { name, settings }, command) {
  const input = addInput(fields, { type: "range", min: settings.min_angle_rad, max: settings.max_angle_rad, step: 0.01, value: 0 });
  input.setAttribute("aria-label", `angle of ${name}`);
  input.addEventListener("input", () => command(Number(input.value)));
}

function buildLed(fields, { name, settings }, command) {
  const inputs = (settings.is_rgb ? ["red", "green", "blue"] : ["brightness"]).map((part) => {
    const input = addInput(fields, { type: "range", min: 0, max: 1, step: 0.01, value: 0 });
    input.setAttribute("aria-label", `${part} of ${name}`);
    input.style.accentColor = part; // a brightness keeps the colour of the page
    return input;
  });
  fields.addEventListener("input", () => {
    const values = inputs.map((input) => Number(input.value));
    command(...(settings.is_rgb ? values : Array(3).fill(values[0])));
  });
}

function buildBuzzer(fields, { name, settings }, command) {
  const input = addInput(fields, { type: "range", min: 100, max: Math.min(2000, settings.max_frequency_hz ?? 2000), step: 10, value: 440 });
  input.setAttribute("aria-label", `tone of ${name}`);
  const button = fields.appendChild(Object.assign(document.createElement("button"), { type: "button", textContent: "play" }));
  let isPlaying = false;
  const play = (isOn) => {
    if (isOn || isPlaying) command(isOn ? Number(input.value) : 0);
    isPlaying = isOn;
  };
  button.addEventListener("pointerdown", (event) => {
    button.setPointerCapture(event.pointerId);
    play(true);
  });
  button.addEventListener("keydown", (event) => event.code === "Enter" && !event.repeat && play(true));
  for (const type of ["pointerup", "pointercancel", "lostpointercapture", "keyup", "blur"]) button.addEventListener(type, () => play(false));
}
