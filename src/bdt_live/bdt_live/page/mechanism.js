// The mechanism: motor, screw with its gap, three platforms on beams, reference and dead zone.

import { arrow, drawingOf, text } from "./drawing.js";
import { drawDial, drawSlot } from "./gap_drawing.js";
import { drawLens } from "./lens.js";
import { faded, palette } from "./palette.js";

const TURN = 2 * Math.PI;
const LEAST_TRAVEL = 0.006; // m from the middle to an end of what is drawn
const MOTOR = 48; // px from the left to the motor's shaft

export class Mechanism {
  constructor(canvas) {
    this.canvas = canvas;
    this.travel = LEAST_TRAVEL;
  }

  draw(now) {
    const drawing = drawingOf(this.canvas);
    if (!drawing) return;
    const { context, width, height } = drawing;
    context.font = "13px system-ui, sans-serif";
    context.lineJoin = "round";
    if (!now) {
      text(context, "nothing has been heard of the loop yet", width / 2, height / 2, palette.quiet, "center");
      return;
    }
    const reached = [now.reference, now.position].filter(Number.isFinite).map(Math.abs);
    this.travel = Math.max(LEAST_TRAVEL, 0.9995 * this.travel, ...reached.map((each) => 1.15 * each));
    const rail = height - 40;
    const isNarrow = width < 480;
    const left = (isNarrow ? 0.44 : 0.4) * width;
    const place = {
      x: (meters) => (left + width) / 2 + (meters / this.travel) * ((width - left) / 2 - 70),
      left, rail, width,
    };
    const levels = [rail - 30, rail - 0.3 * height, rail - 0.55 * height];
    drawReference(context, now, place, levels[2]);
    drawScrew(context, now, place, MOTOR);
    drawTower(context, now, place, levels);
    drawMotor(context, now, MOTOR, rail);
    const slot = Math.max(Math.min(0.08 * height, 30), 16);
    const radius = Math.min(0.15 * width, (rail - slot - 120) / 2, 110);
    drawDial(context, now, { x: radius + 24, y: radius + 26, radius, isNarrow });
    drawSlot(context, now, { x: isNarrow ? 6 : 20, y: 2 * radius + 56, width: left - (isNarrow ? 20 : 44), height: slot, isNarrow });
    drawLens(context, now, { x: left + 10, y: 18, width: width - left - (isNarrow ? 14 : 30), height: 30, isNarrow });
  }
}

function drawReference(context, now, place, level) {
  if (!Number.isFinite(now.reference)) return;
  const x = place.x(now.reference);
  context.strokeStyle = faded(palette.text, 0.7);
  context.lineWidth = 1.5;
  context.setLineDash([6, 5]);
  context.beginPath();
  context.moveTo(x, 62);
  context.lineTo(x, level + 24);
  context.stroke();
  context.setLineDash([]);
}

function drawScrew(context, now, place, motor) {
  const { rail, width } = place;
  const begin = motor + 30;
  context.fillStyle = palette.metal;
  context.fillRect(begin, rail - 6, width - begin - 14, 12);
  // The thread goes on by a turn's pitch with each turn of the screw.
  const turn = 16;
  const phase = Number.isFinite(now.theta_d) ? ((now.theta_d / TURN) * turn) % turn : 0;
  context.strokeStyle = palette["metal-light"];
  context.lineWidth = 3;
  context.save();
  context.beginPath();
  context.rect(begin, rail - 6, width - begin - 14, 12);
  context.clip();
  context.beginPath();
  for (let x = begin - 2 * turn + phase; x < width; x += turn) {
    context.moveTo(x, rail + 7);
    context.lineTo(x + 8, rail - 7);
  }
  context.stroke();
  context.restore();
}

function drawMotor(context, now, x, rail) {
  const radius = 28;
  context.fillStyle = palette.metal;
  context.strokeStyle = palette["metal-light"];
  context.lineWidth = 2;
  context.beginPath();
  context.roundRect(x - radius - 8, rail - radius - 4, 2 * radius + 16, 2 * radius + 8, 8);
  context.fill();
  context.stroke();
  context.fillStyle = palette.background;
  context.beginPath();
  context.arc(x, rail - 2, radius - 4, 0, TURN);
  context.fill();
  const angle = Number.isFinite(now.theta_m) ? now.theta_m : 0;
  context.strokeStyle = palette.orange;
  context.lineWidth = 5;
  context.beginPath();
  context.moveTo(x, rail - 2);
  context.lineTo(x + (radius - 8) * Math.cos(angle), rail - 2 + (radius - 8) * Math.sin(angle));
  context.stroke();
  const voltage = now.voltage_second;
  if (Number.isFinite(voltage)) {
    const begin = x + radius + 18;
    text(context, `${voltage.toFixed(2)} V`, begin, rail - 30, palette.purple);
    arrow(context, begin + 30, rail - 20, Math.max(Math.min(voltage * 4, 40), -40), palette.purple);
  }
}

function drawTower(context, now, place, levels) {
  const known = Number.isFinite(now.q1);
  const positions = known ? [now.q1, now.q2, now.position] : [now.position, now.position, now.position];
  const xs = positions.map(place.x);
  const half = Math.min(0.085 * place.width, 62);
  context.strokeStyle = palette.beam;
  context.lineWidth = 3;
  for (const [lower, upper] of [[0, 1], [1, 2]]) {
    for (const side of [-half + 8, half - 8]) {
      const middle = (levels[lower] + levels[upper]) / 2;
      context.beginPath();
      context.moveTo(xs[lower] + side, levels[lower]);
      context.bezierCurveTo(
        xs[lower] + side, middle, xs[upper] + side, middle, xs[upper] + side, levels[upper],
      );
      context.stroke();
    }
  }
  const inZone = Math.abs(now.reference - now.position) <= now.dead_zone;
  levels.forEach((level, index) => {
    const top = index === 2;
    context.fillStyle = top ? (inZone ? palette.green : palette.blue) : palette.metal;
    context.strokeStyle = palette["metal-light"];
    context.lineWidth = 1.5;
    context.beginPath();
    context.roundRect(xs[index] - half, level - 9, 2 * half, 18, 4);
    context.fill();
    context.stroke();
    text(context, `${index + 1}`, xs[index], level + 4, top ? palette.background : palette.text, "center");
  });
  if (known) {
    // The beams pull a platform towards its neighbors: arrows of their bending, enlarged.
    const force = (index, other) => Math.max(Math.min((positions[other] - positions[index]) * 1e5, 60), -60);
    for (const [index, value] of [[1, force(1, 0) + force(1, 2)], [2, force(2, 1)]]) {
      arrow(context, xs[index] + Math.sign(value) * (half + 4), levels[index], value, palette.red);
    }
  }
  context.fillStyle = palette["metal-light"];
  context.fillRect(xs[0] - 16, levels[0] + 9, 32, place.rail - levels[0] - 3);
  const millimeters = (1e3 * now.position).toFixed(3);
  // Its ground parts the number from the line of the reference behind it.
  context.strokeStyle = palette.panel;
  context.lineWidth = 6;
  context.textAlign = "center";
  context.strokeText(`${millimeters} mm`, xs[2], levels[2] - 18);
  text(context, `${millimeters} mm`, xs[2], levels[2] - 18, palette.text, "center");
}
