// Screw angle over motor angle (figure 2b of the paper), and the phase plane of platform 3.

import { drawingOf } from "./drawing.js";
import { faded, palette } from "./palette.js";

const TRAIL = 10; // s
const RECENT = 250; // rows that are bright, and that the axes show
const DEGREE = Math.PI / 180;
const SMALLEST = { hysteresis: 4, phase: 0.05 }; // in the units of the axes

export class Portraits {
  constructor(hysteresis, phase) {
    this.canvases = { hysteresis, phase };
    this.reach = { ...SMALLEST };
    this.drawn = {}; // wall times [s] of the last pictures
  }

  draw(signals) {
    const { time, theta_m: motor, theta_d: screw, gap, position, reference } = signals.columns;
    const end = signals.indexAt(signals.shown ?? 0) + 1;
    const begin = Math.max(signals.indexAt((signals.shown ?? 0) - TRAIL), signals.begin);
    const middle = middleOf(screw.subarray(Math.max(end - RECENT, begin), end)) / DEGREE;
    const width = gap[end - 1] / DEGREE;
    this.trace("hysteresis", begin, end, (n) => [motor[n] / DEGREE - middle, screw[n] / DEGREE - middle], width);
    this.trace("phase", begin + 2, end, (n) => {
      const speed = (position[n] - position[n - 2]) / (time[n] - time[n - 2]);
      return [1e3 * (position[n] - reference[n]), 1e3 * speed];
    });
  }

  // Draw a curve, and for the angles the flanks of a gap [°] between which it runs.
  trace(name, begin, end, point, gap = 0) {
    const drawing = drawingOf(this.canvases[name]);
    if (!drawing) return;
    const { context, width, height } = drawing;
    const points = [];
    for (let n = begin; n < end; n += 1) points.push(point(n));
    const recent = points.slice(-RECENT);
    const largest = recent.reduce(
      (most, [x, y]) => Math.max(most, Math.abs(x) || 0, name === "phase" ? Math.abs(y) / 12 || 0 : Math.abs(y) || 0),
      Math.max(SMALLEST[name], gap || 0),
    );
    // Grows at once, shrinks within a second, so that the eye can follow.
    const now = performance.now() / 1e3;
    const kept = Math.exp(-4 * (now - (this.drawn[name] ?? now)));
    this.drawn[name] = now;
    this.reach[name] = Math.max(1.15 * largest, kept * this.reach[name]);
    const reach = this.reach[name];
    const tall = name === "phase" ? 12 * reach : reach;
    const toX = (x) => width / 2 + (x / reach) * (width / 2 - 8);
    const toY = (y) => height / 2 - (y / tall) * (height / 2 - 8);
    context.strokeStyle = palette.edge;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(0, height / 2);
    context.lineTo(width, height / 2);
    context.moveTo(width / 2, 0);
    context.lineTo(width / 2, height);
    context.stroke();
    context.fillStyle = palette.quiet;
    context.font = "11px system-ui, sans-serif";
    context.textAlign = "right";
    context.fillText(`± ${shortened(reach)}`, width - 4, height / 2 - 4);
    context.textAlign = "left";
    context.fillText(`± ${shortened(tall)}`, width / 2 + 4, 11);
    if (gap > 0) {
      context.setLineDash([5, 4]);
      for (const side of [-gap / 2, gap / 2]) {
        stroke(context, [[-reach + side, -reach], [reach + side, reach]], toX, toY, palette.quiet, 1);
      }
      context.setLineDash([]);
    }
    const color = name === "phase" ? palette.blue : palette.orange;
    stroke(context, points, toX, toY, faded(color, 0.3), 1);
    stroke(context, recent, toX, toY, color, 2);
    const last = points.at(-1);
    if (last && last.every(Number.isFinite)) {
      context.fillStyle = palette.text;
      context.beginPath();
      context.arc(toX(last[0]), toY(last[1]), 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

function stroke(context, points, toX, toY, color, width) {
  context.strokeStyle = color;
  context.lineWidth = width;
  context.beginPath();
  for (const [x, y] of points) context.lineTo(toX(x), toY(y));
  context.stroke();
}

// The middle between smallest and largest; of values that are not known, zero.
function middleOf(values) {
  const known = values.filter(Number.isFinite);
  return known.length ? (Math.min(...known) + Math.max(...known)) / 2 : 0;
}

function shortened(value) {
  return value >= 10 ? value.toFixed(0) : value.toPrecision(2);
}
