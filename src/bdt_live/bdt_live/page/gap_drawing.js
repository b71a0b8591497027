// The gap: as a dial to scale, and enlarged as a slot with the pin that drives the screw.

import { arrow, text } from "./drawing.js";
import { faded, palette } from "./palette.js";

const TURN = 2 * Math.PI;
const DEGREE = Math.PI / 180;
const TOUCHING = 1e-5; // rad within which motor and screw touch

// Which flank the motor's pin touches: 1, -1, or 0 within the gap.
export function contactOf(now) {
  const off = now.theta_m - now.theta_d;
  return Math.abs(off) >= now.gap / 2 - TOUCHING ? Math.sign(off) : 0;
}

export function drawDial(context, now, { x, y, radius, isNarrow }) {
  if (!Number.isFinite(now.gap)) {
    text(context, "what is inside is not known of a real machine", x - radius, y, palette.quiet);
    return;
  }
  const half = now.gap / 2;
  const contact = contactOf(now);
  // The screw's hub is a ring with an opening of the gap's own angle.
  context.lineCap = "butt";
  context.lineWidth = 0.28 * radius;
  context.strokeStyle = palette.metal;
  context.beginPath();
  context.arc(x, y, 0.86 * radius, now.theta_d + half + 4 * DEGREE, now.theta_d - half - 4 * DEGREE + TURN);
  context.stroke();
  context.strokeStyle = palette.blue;
  context.lineWidth = 3;
  context.beginPath();
  for (const side of [-1, 1]) {
    const angle = now.theta_d + side * (half + 4 * DEGREE);
    context.moveTo(x + 0.72 * radius * Math.cos(angle), y + 0.72 * radius * Math.sin(angle));
    context.lineTo(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
  }
  context.stroke();
  // The motor's pin is as wide as the opening is wider than the gap.
  context.strokeStyle = contact ? palette.red : palette.orange;
  context.lineWidth = 0.26 * radius;
  context.beginPath();
  context.arc(x, y, 0.86 * radius, now.theta_m - 4 * DEGREE, now.theta_m + 4 * DEGREE);
  context.stroke();
  context.lineWidth = 6;
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + 0.75 * radius * Math.cos(now.theta_m), y + 0.75 * radius * Math.sin(now.theta_m));
  context.stroke();
  context.fillStyle = palette.orange;
  context.beginPath();
  context.arc(x, y, 7, 0, TURN);
  context.fill();
  const words = isNarrow ? "to scale" : "motor in the screw's hub, to scale";
  text(context, words, x - radius, y - radius - 14, palette.quiet);
}

export function drawSlot(context, now, { x, y, width, height, isNarrow }) {
  if (!Number.isFinite(now.gap)) return;
  const full = Math.max(30 * DEGREE, now.gap);
  const scale = (width - 40) / full;
  const middle = x + width / 2;
  const half = (now.gap / 2) * scale;
  const pin = 10;
  const contact = contactOf(now);
  text(context, `gap ${(now.gap / DEGREE).toFixed(2)}°`, x, y - 8, palette.text);
  if (!isNarrow) {
    text(context, `${(scale * DEGREE).toFixed(0)} px a degree`, x + width, y - 8, palette.quiet, "right");
  }
  context.fillStyle = palette.metal;
  context.fillRect(x, y, middle - half - pin - x, height);
  context.fillRect(middle + half + pin, y, x + width - middle - half - pin, height);
  context.fillStyle = faded(palette.blue, 0.14);
  context.fillRect(middle - half - pin, y, 2 * (half + pin), height);
  drawEstimate(context, now, { middle, scale, pin, y, height });
  const at = middle + Math.max(Math.min((now.theta_m - now.theta_d) * scale, half), -half);
  context.fillStyle = contact ? palette.red : palette.orange;
  context.beginPath();
  context.roundRect(at - pin, y + 3, 2 * pin, height - 6, 4);
  context.fill();
  if (contact) arrow(context, at + contact * (pin + 2), y + height / 2, contact * 18, palette.red);
  const [brief, more] = contact ? ["in contact", ": the screw follows"] : ["inside the gap", ": the screw stands"];
  const words = isNarrow ? brief : brief + more;
  text(context, words, x, y + height + 17, contact ? palette.red : palette.orange);
}

// Where the twin believes the flanks to be, with its interval.
function drawEstimate(context, now, { middle, scale, pin, y, height }) {
  if (!Number.isFinite(now.estimate)) return;
  const off = (now.estimate / 2) * scale + pin;
  const doubt = Number.isFinite(now.uncertainty) ? now.uncertainty * scale : 0;
  for (const side of [-1, 1]) {
    context.fillStyle = faded(palette.yellow, 0.35);
    context.fillRect(middle + side * off - doubt, y - 3, 2 * doubt, height + 6);
    context.fillStyle = palette.yellow;
    context.fillRect(middle + side * off - 1, y - 5, 2, height + 10);
  }
}
