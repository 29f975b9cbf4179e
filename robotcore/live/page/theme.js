// Colours and sizes of the canvases.

const style = getComputedStyle(document.documentElement);

export const colour = (name) => style.getPropertyValue(`--${name}`).trim();

export const STATE_COLOURS = ["#2463eb", "#eb5e14", "#a81eaf", "#0591b2", "#dc265a", "#1e1b6e", "#82460a", "#555864"];

// Returns the context of a canvas whose pixels are those of the screen, and its size in CSS pixels.
export function prepare(canvas) {
  const scale = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
