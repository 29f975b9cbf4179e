// Hand driving: keys, a joystick for a finger or a mouse, and a gamepad.

const PERIOD_MS = 50; // several times in the lease, after which the wheels stop
const DEAD_ZONE = 0.12;
const KEYS = {
  ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0],
  ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1], KeyD: [0, -1],
};

const get = (id) => document.getElementById(id);
const clamp = (value) => Math.min(1, Math.max(-1, value));

export class Driving {
  // send: sends a message to the server.
  constructor(send) {
    this.send = send;
    this.keys = new Set();
    this.stick = null;
    this.operator = "none";
    get("take").addEventListener("click", () => this.send({ type: "take" }));
    get("release").addEventListener("click", () => this.release());
    get("limit").addEventListener("input", () => this.showLimit());
    window.addEventListener("keydown", (event) => this.press(event));
    window.addEventListener("keyup", (event) => (event.key === "Meta" ? this.releaseInputs() : this.keys.delete(event.code)));
    window.addEventListener("contextmenu", (event) => event.defaultPrevented || this.releaseInputs());
    for (const type of ["blur", "pagehide", "focusin"]) window.addEventListener(type, () => this.releaseInputs());
    document.addEventListener("visibilitychange", () => document.hidden && this.releaseInputs());
    this.listenToStick(get("stick"));
    this.showLimit();
    setInterval(() => this.drive(), PERIOD_MS);
  }

  reset(run) {
    this.run = run;
    this.releaseInputs();
    get("drive-card").hidden = !(run.has_operator && run.drive);
    this.showOperator("none");
  }

  showOperator(operator) {
    if (operator !== "you") this.releaseInputs();
    this.operator = operator;
    get("drive-card").dataset.operator = operator;
    get("drive-card").inert = ["lost", "ended"].includes(operator);
    if (operator === "you" && getComputedStyle(get("drive-card")).position === "fixed") window.scrollTo(0, 0); // to the camera
    this.isHinted = false;
    this.show(this.isHandDriven ?? false);
  }

  // isHandDriven: whether the robot waits for a person in place of the app.
  show(isHandDriven) {
    this.isHandDriven = isHandDriven;
    const texts = {
      you: "you drive", other: "another viewer drives", lost: "not connected", ended: "the run has ended",
      none: isHandDriven ? "no viewer drives, the app waits" : "the app drives",
    };
    const button = this.operator === "other" ? "Take over" : "Drive";
    const isHinted = this.isHinted || (this.run?.app === "teleop" && !isHandDriven); // that app only stands
    const canTake = ["none", "other"].includes(this.operator);
    get("drive-state").textContent = isHinted && canTake ? `press ${button} first` : texts[this.operator];
    get("take").textContent = button;
    get("take").hidden = this.operator === "you";
    get("release").hidden = this.operator === "other" || !(isHandDriven || this.operator === "you");
  }

  showLimit() {
    this.limit = Number(get("limit").value) / 100;
    get("limit-text").textContent = `${get("limit").value} %`;
  }

  release() {
    this.releaseInputs();
    this.send({ type: "release" });
  }

  // Releases each input where the release of a key may get lost: in a menu, another window or a key combination.
  releaseInputs() {
    this.keys.clear();
    this.moveStick(null);
  }

  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return this.releaseInputs();
    if (!KEYS[event.code]) return;
    if (event.target.matches("input[type=range]") && event.code.startsWith("Arrow")) return;
    if (this.operator !== "you") return this.hint();
    event.preventDefault();
    this.keys.add(event.code);
  }

  // Shows how to take the robot, because an input of a viewer who does not drive has no effect.
  hint() {
    this.isHinted = true;
    this.show(this.isHandDriven ?? false);
  }

  listenToStick(stick) {
    const move = (event) => {
      const box = stick.getBoundingClientRect();
      const half = box.width / 2;
      this.moveStick([(event.clientX - box.left - half) / half, (event.clientY - box.top - half) / half]);
    };
    stick.addEventListener("contextmenu", (event) => event.preventDefault()); // a long touch asks for this menu
    stick.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      if (this.operator !== "you") return this.hint();
      stick.setPointerCapture(event.pointerId);
      move(event);
    });
    stick.addEventListener("pointermove", (event) => {
      if (!stick.hasPointerCapture(event.pointerId)) return;
      event.buttons & 1 ? move(event) : this.moveStick(null); // the pointerup of a chord comes with its last button
    });
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"]) stick.addEventListener(type, () => this.moveStick(null));
  }

  // place: the place of the finger, from -1 to 1 to the right and down; null without a finger.
  moveStick(place) {
    const length = place ? Math.max(1, Math.hypot(...place)) : 1;
    this.stick = place && place.map((part) => part / length);
    const [x, y] = this.stick ?? [0, 0];
    get("knob").style.transform = `translate(${x * 52}px, ${y * 52}px)`;
  }

  readGamepad() {
    const pad = [...(navigator.getGamepads?.() ?? [])].find(Boolean);
    if (!pad || document.hidden) return [0, 0];
    const [x, y] = pad.axes.map((value) => (Math.abs(value) < DEAD_ZONE ? 0 : value));
    return [-y || 0, -x || 0];
  }

  drive() {
    if (this.operator !== "you" || !this.run) return;
    const inputs = [...this.keys].map((code) => KEYS[code]);
    inputs.push(this.stick ? [-this.stick[1], -this.stick[0]] : [0, 0], this.readGamepad());
    const [linear, angular] = [0, 1].map((axis) => this.limit * clamp(inputs.reduce((sum, input) => sum + input[axis], 0)));
    this.send({ type: "drive", linear, angular, sent: performance.now() });
  }
}
