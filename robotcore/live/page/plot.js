// The velocities of the wheels over the last seconds.

import { colour, prepare } from "./theme.js";

const WINDOW_S = 20;
const SERIES = [
  { key: "asked", width: 1.6, dash: [2, 3] },
  { key: "sent", width: 2, dash: [] },
  { key: "measured", width: 2, dash: [] },
];

export class WheelPlot {
  constructor(canvas) {
    this.canvas = canvas;
    this.reset(null);
  }

  reset(drive) {
    this.limit = drive?.wheel ?? 10;
    this.points = [];
  }

  add(tick) {
    const last = this.points.at(-1)?.time;
    if (tick.time < last) this.points = [];
    if (tick.time === last) this.points.pop(); // a paused run sends its last tick again
    const { time, asked, sent, measured } = tick;
    this.points.push({ time, asked, sent, measured });
    while (this.points[0].time < time - WINDOW_S) this.points.shift();
  }

  draw() {
    const { context, width, height } = prepare(this.canvas);
    const half = (height - 26) / 2;
    ["left", "right"].forEach((side, index) => {
      this.drawSide(context, index, side, { x: 44, y: index * (half + 6) + 8, width: width - 48, height: half - 14 });
    });
    context.fillStyle = colour("faded");
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "right";
    context.fillText(`the last ${WINDOW_S} s, in rad/s`, width - 4, height - 2);
  }

  drawSide(context, index, side, box) {
    const scale = this.findScale(index);
    const now = this.points.at(-1)?.time ?? 0;
    const toX = (time) => box.x + box.width * (1 - (now - time) / WINDOW_S);
    const toY = (value) => box.y + (box.height / 2) * (1 - value / scale);
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 1;
    for (const value of [scale, 0, -scale]) {
      context.strokeStyle = colour("rule");
      context.beginPath();
      context.moveTo(box.x, Math.round(toY(value)) + 0.5);
      context.lineTo(box.x + box.width, Math.round(toY(value)) + 0.5);
      context.stroke();
      context.fillStyle = colour("faded");
      context.textAlign = "right";
      context.fillText(value ? value.toFixed(scale < 10 ? 1 : 0) : side, box.x - 7, toY(value) + 4);
    }
    context.save();
    context.beginPath();
    context.rect(box.x, box.y - 3, box.width, box.height + 6);
    context.clip();
    for (const { key, width, dash } of SERIES) {
      context.strokeStyle = colour(key === "sent" ? "accent" : key);
      context.lineWidth = width;
      context.setLineDash(dash);
      context.lineJoin = "round";
      context.beginPath();
      let isDown = false;
      for (const point of this.points) {
        const value = point[key]?.[index] ?? null;
        if (value === null) isDown = false;
        else if (isDown) context.lineTo(toX(point.time), toY(value));
        else context.moveTo(toX(point.time), toY(value));
        isDown = value !== null;
      }
      context.stroke();
    }
    context.restore();
  }

  // The greatest magnitude, so that the lines fill the plot: a 1, 2 or 5 with zeros.
  findScale(index) {
    const measure = (point) => Math.max(...SERIES.map(({ key }) => Math.abs(point[key]?.[index] ?? 0)));
    const greatest = this.points.reduce((most, point) => Math.max(most, measure(point)), 1);
    const most = Math.min(greatest, 2 * this.limit);
    const power = 10 ** Math.floor(Math.log10(most));
    return [1, 2, 5, 10].map((each) => each * power).find((each) => each >= most);
  }
}
