// The message over the whole page, such as the end of the run or a lost connection.
// It gets the focus, so that a screen reader reads it and Enter closes it.

const get = (id) => document.getElementById(id);

export function showScreen(mood, mark, title, text, notes = []) {
  get("screen").dataset.mood = mood;
  get("screen-mark").textContent = mark;
  get("screen-title").textContent = title;
  get("screen-text").textContent = text;
  get("screen-notes").replaceChildren(...notes.map((note) => Object.assign(document.createElement("li"), { textContent: note })));
  get("screen").hidden = false;
  if (parent === window) (get("screen-close").hidden ? get("screen") : get("screen-close")).focus(); // a player keeps its focus
}

// isPossible: whether there is a state of the run to show in place of the screen.
export function offerClosing(isPossible) {
  get("screen-close").hidden = !isPossible;
}

export function hideScreen() {
  get("screen").hidden = true;
}

get("screen-close").addEventListener("click", hideScreen);
