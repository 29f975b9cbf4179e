// The socket to the page's server. It connects again if it is lost.

const RETRY_MS = 1000;
export const LINK_HINT = "Open the whole link that the command printed, with its #token=…";
const FINAL_CODES = { 4401: "token", 4429: "full" };

export function readToken() {
  const match = /^#token=(.+)$/.exec(location.hash);
  if (match) {
    sessionStorage.setItem("token", decodeURIComponent(match[1]));
    history.replaceState(null, "", location.pathname); // the token is no part of a screenshot
  }
  return sessionStorage.getItem("token") ?? "";
}

export class Connection {
  // receive: called with each message. show: called with a picture's name and data; returns a promise.
  // change: called with "open", "lost", "token" or "full".
  constructor({ receive, show, change }) {
    Object.assign(this, { receive, show, change });
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}${location.pathname}live`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.send({ type: "hello", token: readToken() });
    };
    this.socket.onmessage = (event) => this.handle(event.data);
    this.socket.onclose = (event) => {
      const reason = FINAL_CODES[event.code];
      this.change(reason ?? "lost");
      if (!reason) setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  send(message) {
    // A velocity that waits here behind others would come too late.
    if (message.type === "drive" && this.socket.bufferedAmount > 0) return;
    if (this.isOpen) this.socket.send(JSON.stringify(message));
  }

  async handle(data) {
    if (typeof data !== "string") return this.handlePicture(data);
    const message = JSON.parse(data);
    if (message.type === "tick") this.send({ type: "ack", tick: message.tick });
    if (message.type === "run" || message.type === "history") this.change("open");
    this.receive(message);
  }

  async handlePicture(data) {
    const length = new Uint8Array(data)[0];
    const name = new TextDecoder().decode(new Uint8Array(data, 1, length));
    try {
      await this.show(name, new Blob([new Uint8Array(data, 1 + length)]));
    } finally {
      this.send({ type: "ack", picture: name });
    }
  }
}
