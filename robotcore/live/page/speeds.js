// The buttons that choose a speed. A native list would take the keys of the page while it is open.

export class SpeedButtons {
  // speeds: multiples of real time; null for no limit. choose: called with the speed of a pressed button.
  constructor(element, speeds, choose) {
    this.buttons = new Map(speeds.map((speed) => {
      const textContent = speed === null ? "no limit" : `${speed}×`;
      const button = element.appendChild(Object.assign(document.createElement("button"), { type: "button", textContent }));
      button.addEventListener("click", () => choose(speed));
      return [speed, button];
    }));
  }

  show(chosen) {
    for (const [speed, button] of this.buttons) button.setAttribute("aria-pressed", speed === chosen);
  }
}
