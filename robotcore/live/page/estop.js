// The e-stop: its button, its key, and the attempts until the server confirms a press.

const RETRY_MS = 500;
const ANSWER_MS = 1500; // the longest wait for an answer
const CLICK_MS = 1000; // a click so soon after its pointerdown is the same press

export class Estop {
  // send: sends a message to the server through the socket.
  constructor(button, send) {
    Object.assign(this, { button, send });
    this.pressedAt = -Infinity;
    this.isTrying = false;
    this.reset();
    button.addEventListener("pointerdown", (event) => {
      this.pressedAt = event.timeStamp;
      this.press();
    });
    button.addEventListener("click", (event) => { // without a pointer: Enter, or assistive technology
      if (event.timeStamp - this.pressedAt > CLICK_MS) this.press();
    });
  }

  handleKey(event) {
    if (event.code !== "Space") return;
    event.preventDefault(); // the key must not also press the button that has the focus
    if (event.type === "keydown" && !event.repeat) this.press();
  }

  // Shows the e-stop of a run that the page can reach. A press that no server has confirmed stays wanted.
  reset() {
    this.hasEnded = false;
    if (!this.isWanted) this.show("space bar");
  }

  // The end of the run fulfils a press. A later press may stop the next run, which the page may not see.
  end() {
    this.hasEnded = true;
    this.isWanted = false;
    this.show("the run has ended");
  }

  // Needs no token and no socket: the button works also on a page that shows nothing of the run.
  async press() {
    this.isWanted = true;
    this.send({ type: "estop" });
    this.show("not confirmed");
    if (this.isTrying) return;
    this.isTrying = true;
    while (this.isWanted) {
      const isConfirmed = await post();
      if (!this.isWanted) break;
      if (isConfirmed || this.hasEnded) {
        this.isWanted = false;
        this.show(isConfirmed ? "stopping …" : "no run answers");
      } else {
        await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
      }
    }
    this.isTrying = false;
  }

  show(text) {
    this.button.lastChild.textContent = text;
    this.button.classList.toggle("is-pressed", ["not confirmed", "stopping …"].includes(text));
    this.button.classList.toggle("is-noted", text !== "space bar");
  }
}

// Returns whether the server has confirmed the press.
async function post() {
  try {
    const signal = AbortSignal.timeout(ANSWER_MS);
    return (await fetch("estop", { method: "POST", headers: { "x-robotcore": "estop" }, keepalive: true, signal })).ok;
  } catch {
    return false; // the network is lost, or the server has ended with its run
  }
}
