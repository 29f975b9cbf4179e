// The robot, its path and its rays from above, in the world or on an empty floor.

import { colour, prepare, STATE_COLOURS } from "./theme.js";

const MAX_POINTS = 6000;
const MAX_POSES = 50;

export class Overhead {
  constructor(canvas) {
    this.canvas = canvas;
    this.reset({});
  }

  reset(run) {
    this.bounds = run.bounds ?? null;
    this.footprint = run.footprint ?? [];
    this.world = null;
    this.path = [];
    this.states = [];
    this.tick = null;
    this.poses = []; // the newest ones, for samples that are older than the tick
  }

  setPath(path) {
    this.path = path;
    this.poses = [];
    this.states = [...new Set(path.map((point) => point[2]))];
  }

  add(tick) {
    this.tick = tick;
    const pose = tick.truth ?? tick.pose;
    if (pose && !pose.includes(null)) this.poses.push({ time: tick.time, pose });
    while (this.poses.length > MAX_POSES) this.poses.shift();
    for (const point of tick.path) {
      if (!this.states.includes(point[2])) this.states.push(point[2]);
      this.path.push(point);
    }
    if (this.path.length > MAX_POINTS) this.path = this.path.filter((_, index) => index % 2 === 0);
  }

  stateColour(state) {
    return STATE_COLOURS[Math.max(0, this.states.indexOf(state)) % STATE_COLOURS.length];
  }

  // Returns the edges to show, in metres: those of the world, or of a floor around the path.
  findBounds() {
    if (this.bounds) return this.bounds;
    const xs = this.path.map((point) => point[0]).concat(-0.6, 0.6);
    const ys = this.path.map((point) => point[1]).concat(-0.6, 0.6);
    const middle = [(Math.max(...xs) + Math.min(...xs)) / 2, (Math.max(...ys) + Math.min(...ys)) / 2];
    const reach = Math.max(Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)) / 2 + 0.4;
    return [middle[0] - reach, middle[1] - reach, middle[0] + reach, middle[1] + reach];
  }

  draw() {
    const { context, width, height } = prepare(this.canvas);
    const [left, bottom, right, top] = this.findBounds();
    const scale = Math.min(width / (right - left), height / (top - bottom));
    this.toPixel = ([x, y]) => [(x - left) * scale, (top - y) * scale];
    if (this.world) {
      context.imageSmoothingQuality = "high";
      context.drawImage(this.world, 0, 0, (right - left) * scale, (top - bottom) * scale);
    } else {
      this.drawFloor(context, [left, bottom, right, top]);
    }
    this.drawPath(context, Math.max(2.5, 0.024 * scale));
    const pose = this.tick?.truth ?? this.tick?.pose;
    if (pose && !pose.includes(null)) {
      this.drawRays(context, pose);
      this.drawRobot(context, pose);
    }
  }

  drawFloor(context, [left, bottom, right, top]) {
    context.strokeStyle = colour("rule");
    context.lineWidth = 1;
    const step = right - left > 12 ? 2 : right - left > 5 ? 1 : 0.5;
    context.beginPath();
    for (let x = Math.ceil(left / step) * step; x <= right; x += step) this.addLine(context, [x, bottom], [x, top]);
    for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) this.addLine(context, [left, y], [right, y]);
    context.stroke();
    context.fillStyle = colour("faded");
    context.font = "12px system-ui, sans-serif";
    context.fillText(`grid ${step} m`, 8, 18);
  }

  addLine(context, from, to) {
    context.moveTo(...this.toPixel(from));
    context.lineTo(...this.toPixel(to));
  }

  drawPath(context, width) {
    const pose = this.tick?.truth ?? this.tick?.pose;
    const end = pose && !pose.includes(null) && this.path.length ? [[pose[0], pose[1], this.path.at(-1)[2]]] : [];
    const path = this.path.concat(end);
    context.lineJoin = context.lineCap = "round";
    for (const [paint, extra] of [[() => "rgb(255 255 255 / 75%)", 3], [(state) => this.stateColour(state), 0]]) {
      context.lineWidth = width + extra;
      for (let index = 1; index < path.length; ) {
        const state = path[index][2];
        context.strokeStyle = paint(state);
        context.beginPath();
        context.moveTo(...this.toPixel(path[index - 1]));
        for (; index < path.length && path[index][2] === state; index++) {
          context.lineTo(...this.toPixel(path[index]));
        }
        context.stroke();
      }
    }
  }

  // Returns the pose at the time of a sample, so that the echoes of a turning robot are where the bodies are.
  // pose: that of the newest tick.
  findPose(age, pose) {
    const time = this.tick.time - age + 1e-3;
    return (this.poses.findLast((each) => each.time <= time) ?? this.poses[0])?.pose ?? pose;
  }

  drawRays(context, newest) {
    for (const device of Object.values(this.tick.devices)) {
      if (!device.rays) continue;
      const { start, end, distances } = device.rays;
      const pose = this.findPose(device.age, newest);
      const [x, y] = toWorld(pose, device.mount);
      const heading = pose[2] + device.mount[2];
      const ends = distances.map((distance, index) => {
        const angle = heading + (distances.length > 1 ? start + ((end - start) * index) / (distances.length - 1) : 0);
        return distance === null ? null : [x + distance * Math.cos(angle), y + distance * Math.sin(angle)];
      });
      context.fillStyle = "rgb(36 99 235 / 16%)";
      context.beginPath();
      context.moveTo(...this.toPixel([x, y]));
      ends.forEach((point) => context.lineTo(...this.toPixel(point ?? [x, y])));
      context.closePath();
      context.fill();
      context.fillStyle = "rgb(36 99 235 / 85%)";
      for (const point of ends) {
        if (!point) continue;
        const [px, py] = this.toPixel(point);
        context.fillRect(px - 1.5, py - 1.5, 3, 3);
      }
    }
  }

  drawRobot(context, pose) {
    const corners = this.footprint.map((corner) => this.toPixel(toWorld(pose, corner)));
    context.beginPath();
    corners.forEach(([x, y], index) => (index ? context.lineTo(x, y) : context.moveTo(x, y)));
    context.closePath();
    context.fillStyle = "#2b3240";
    context.strokeStyle = "#ffffff";
    context.lineWidth = 2;
    context.lineJoin = "round";
    context.fill();
    context.stroke();
    const front = Math.max(...this.footprint.map(([x]) => x));
    const half = Math.max(...this.footprint.map(([, y]) => y)) * 0.5;
    context.beginPath();
    [[front * 0.35, half], [front * 0.8, 0], [front * 0.35, -half]].forEach((point, index) => {
      const [x, y] = this.toPixel(toWorld(pose, point));
      index ? context.lineTo(x, y) : context.moveTo(x, y);
    });
    context.stroke();
  }
}

function toWorld([x, y, heading], [ahead, aside]) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return [x + ahead * cos - aside * sin, y + ahead * sin + aside * cos];
}
