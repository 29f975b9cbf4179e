// Lets the search run if the site is opened as files. Browsers refuse web workers of file:// pages, so a hidden frame
// takes the place of the worker. It loads the worker's script, and passes messages in both directions.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      this.isReady = new Promise((resolve) => this.frame.addEventListener("load", resolve, { once: true }));
      this.frame.srcdoc = `<script>${connectToParent}; connectToParent()</script><script src="${url}"></script>`;
      window.addEventListener("message", (event) => {
        if (event.source !== this.frame.contentWindow) return;
        const message = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(message);
        if (this.onmessage) this.onmessage(message);
      });
      document.body.appendChild(this.frame);
    }

    postMessage(data) {
      const message = { data: structuredClone(data) };
      this.isReady.then(() => this.frame.contentWindow.dispatchEvent(new MessageEvent("message", message)));
    }

    terminate() {
      this.frame.remove();
    }
  };
}

// Runs in the frame: gives the script the functions of a worker.
function connectToParent() {
  window.postMessage = (data) => window.parent.postMessage(data, "*");
  window.importScripts = async (...urls) => {
    for (const url of urls) {
      await new Promise((resolve) => {
        const script = document.createElement("script");
        script.src = url;
        script.onload = resolve;
        document.body.appendChild(script);
      });
    }
  };
}
