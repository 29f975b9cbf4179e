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
  const input = addInput(fields, settings.is_rgb ? { type: "color", value: "#000000" } : { type: "range", min: 0, max: 1, step: 0.01, value: 0 });
  input.setAttribute("aria-label", `brightness of ${name}`);
  input.addEventListener("input", () => {
    if (!settings.is_rgb) return command(...Array(3).fill(Number(input.value)));
    command(...[1, 3, 5].map((place) => parseInt(input.value.slice(place, place + 2), 16) / 255));
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
  for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) button.addEventListener(type, () => play(false));
}
