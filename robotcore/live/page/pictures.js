// The pictures of cameras and displays, and the tabs that choose one.

export class Tabs {
  constructor(element) {
    this.element = element;
    this.onchoose = () => {};
    this.reset([]);
  }

  reset(names) {
    this.names = [];
    this.chosen = null;
    this.element.replaceChildren();
    names.forEach((name) => this.add(name));
  }

  add(name) {
    if (this.names.includes(name)) return;
    this.names.push(name);
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: name });
    button.setAttribute("role", "tab");
    button.addEventListener("click", () => this.choose(name));
    this.element.append(button);
    this.choose(this.chosen ?? name);
  }

  choose(name) {
    this.chosen = name;
    [...this.element.children].forEach((button, index) => button.setAttribute("aria-selected", this.names[index] === name));
    this.element.hidden = this.names.length < 2;
    this.onchoose();
  }
}

export class Pictures {
  constructor(canvas, tabs, card) {
    Object.assign(this, { canvas, tabs, card });
    this.reset();
  }

  reset() {
    this.tabs.reset([]);
    this.card.hidden = true;
    this.hasDisplay = false;
    this.count = 0;
  }

  // A display has the picture that the app has annotated, so the first display is chosen before a camera.
  // card: the card of the device, which shows the picture too.
  async show(name, blob, card) {
    this.tabs.add(name);
    this.card.hidden = false;
    if (card?.device.kind === "display" && !this.hasDisplay) {
      this.hasDisplay = true;
      this.tabs.choose(name);
    }
    const picture = await createImageBitmap(blob);
    card?.drawPicture(picture);
    if (this.tabs.chosen === name) this.draw(picture);
    picture.close();
  }

  draw(picture) {
    if (this.canvas.width !== picture.width) this.canvas.width = picture.width;
    if (this.canvas.height !== picture.height) this.canvas.height = picture.height;
    this.canvas.getContext("2d").drawImage(picture, 0, 0);
    this.canvas.dataset.count = ++this.count;
  }
}
