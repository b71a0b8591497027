// Platform 3 around its reference, enlarged: the dead zone as a band.

import { text } from "./drawing.js";
import { faded, palette } from "./palette.js";

const NARROWEST = 50e-6; // m from the reference to an end of the lens

export function drawLens(context, now, { x, y, width, height, isNarrow }) {
  const zone = Number.isFinite(now.dead_zone) ? now.dead_zone : 0;
  const reach = Math.max(NARROWEST, 1.6 * zone);
  const middle = x + width / 2;
  const scale = width / 2 / reach;
  const error = now.position - now.reference;
  context.fillStyle = faded(palette.metal, 0.25);
  context.fillRect(x, y, width, height);
  if (zone > 0) {
    context.fillStyle = faded(palette.green, 0.4);
    context.fillRect(middle - zone * scale, y, 2 * zone * scale, height);
  }
  context.fillStyle = palette.text;
  context.fillRect(middle - 0.75, y - 4, 1.5, height + 8);
  const words = zone > 0 ? `dead zone ± ${(1e6 * zone).toFixed(1)} µm` : "no dead zone";
  text(context, words, x, y - 6, zone > 0 ? palette.green : palette.quiet);
  if (!isNarrow) text(context, `± ${(1e6 * reach).toFixed(0)} µm`, x + width, y - 6, palette.quiet, "right");
  if (!Number.isFinite(error)) return;
  const off = Math.max(Math.min(error * scale, width / 2), -width / 2);
  const beyond = Math.abs(error) > reach;
  context.fillStyle = palette.blue;
  context.beginPath();
  if (beyond) {
    const side = Math.sign(error);
    context.moveTo(middle + off, y + height / 2);
    context.lineTo(middle + off - side * 11, y + 5);
    context.lineTo(middle + off - side * 11, y + height - 5);
  } else {
    context.roundRect(middle + off - 4, y + 2, 8, height - 4, 3);
  }
  context.fill();
}
