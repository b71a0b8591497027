// The running plots: position, voltage and gap over time.

/* global uPlot */
import { faded, palette } from "./palette.js";

const LEAST_HEIGHT = 96; // px
const MILLI = 1e3;
const MICRO = 1e6;
const DEGREES = 180 / Math.PI;
const DASHED = [7, 4];
const DOTTED = [2, 3];

// What each plot shows: [label, color, function of (signals, row, which of a row's two points)].
// A curve is told from the others of its plot by its dashes as well: not by its color alone.
const PLOTS = {
  position: {
    title: "position of platform 3 [mm]",
    series: [
      ["measured", "blue", (c, n, second) => MILLI * (second ? c.position_second : c.position_first)[n], { width: 2 }],
      ["reference", "text", (c, n) => MILLI * c.reference[n], { width: 1.5, dash: DASHED, stepped: true }],
    ],
    range: (plot) => spread(plot, 0.2),
  },
  error: {
    title: "its error, enlarged [µm]",
    series: [
      ["measured", "blue", (c, n, second) => MICRO * ((second ? c.position_second : c.position_first)[n] - c.reference[n]), { width: 2 }],
      ["dead zone", "green", (c, n) => MICRO * c.dead_zone[n], { width: 1.5, dash: DASHED, stepped: true }],
      ["", "green", (c, n) => -MICRO * c.dead_zone[n], { width: 1.5, dash: DASHED, stepped: true }],
    ],
    band: [2, 3, "green"],
    range: (plot) => enlarged(plot.data[2], 100),
  },
  voltage: {
    title: "motor voltage [V]",
    series: [["voltage", "purple", (c, n, second) => (second ? c.voltage_second : c.voltage_first)[n], { width: 1.5 }]],
    range: (plot) => spread(plot, 0.5),
  },
  gap: {
    title: "gap [°]",
    series: [
      ["true", "orange", (c, n) => DEGREES * c.gap[n], { width: 2.5 }],
      ["estimate", "yellow", (c, n) => DEGREES * c.estimate[n], { width: 2, dash: DOTTED, stepped: true }],
      ["", "yellow", (c, n) => DEGREES * (c.estimate[n] + 2 * c.uncertainty[n]), { width: 0.5 }],
      ["", "yellow", (c, n) => DEGREES * (c.estimate[n] - 2 * c.uncertainty[n]), { width: 0.5 }],
      ["that the dead zone bears", "green", (c, n, _second, pitch) => DEGREES * (c.dead_zone[n] / pitch), { width: 1.5, dash: DASHED }],
    ],
    band: [3, 4, "yellow"],
    range: (plot) => spread(plot, 2),
  },
};

export class Plots {
  // `places` are elements by the names of PLOTS.
  constructor(places) {
    this.places = places;
    this.names = Object.keys(PLOTS);
    this.window = 20; // s
    this.pitch = NaN; // m/rad
    this.marks = [];
    this.turn = 0;
    this.build();
    const observer = new ResizeObserver(() => this.resize());
    for (const place of Object.values(places)) observer.observe(place);
  }

  build() {
    for (const plot of Object.values(this.plots ?? {})) plot.destroy();
    this.plots = Object.fromEntries(this.names.map((name) => [name, this.create(name)]));
  }

  resize() {
    for (const name of this.names) {
      this.plots[name].setSize(this.sizeOf(name));
    }
  }

  sizeOf(name) {
    const { clientWidth, clientHeight } = this.places[name];
    const heading = this.places[name].firstElementChild?.offsetHeight ?? 0;
    return { width: Math.max(clientWidth - 12, 120), height: Math.max(clientHeight - heading - 8, LEAST_HEIGHT) };
  }

  create(name) {
    const { series, band, range } = PLOTS[name];
    this.places[name].replaceChildren(heading(PLOTS[name]));
    const axis = { stroke: palette.quiet, grid: { stroke: faded(palette.edge, 0.7), width: 1 }, ticks: { show: false }, font: "12px system-ui" };
    const options = {
      ...this.sizeOf(name),
      cursor: { sync: { key: "time" }, drag: { x: false, y: false } },
      legend: { show: false },
      scales: { x: { time: false, auto: false }, y: { range } },
      axes: [{ ...axis, size: 28, values: (_plot, values) => values.map((t) => `${+t.toFixed(1)} s`) }, { ...axis, size: 52 }],
      series: [{}, ...series.map(([label, color, , more]) => ({
        label, stroke: palette[color], width: 1, points: { show: false }, ...more,
        paths: more.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined,
      }))],
      bands: band ? [{ series: band.slice(0, 2), fill: faded(palette[band[2]], 0.22) }] : [],
      hooks: { draw: [(plot) => this.drawMarks(plot)] },
    };
    return new uPlot(options, [[], ...series.map(() => [])], this.places[name]);
  }

  // Draw one of the plots, the next one each time: all of them at once would cost a frame.
  drawNext(signals) {
    if (signals.shown === null) return;
    const name = this.names[this.turn];
    this.turn = (this.turn + 1) % this.names.length;
    const { columns } = signals;
    const stop = signals.indexAt(signals.shown) + 1;
    const begin = Math.max(signals.indexAt(signals.shown - this.window), signals.begin);
    const count = 2 * Math.max(stop - begin, 0);
    const data = [new Float64Array(count), ...PLOTS[name].series.map(() => new Array(count))];
    for (let n = begin, place = 0; n < stop; n += 1) {
      for (const second of [false, true]) {
        data[0][place] = columns.time[n] + (second ? 0.005 : 0);
        PLOTS[name].series.forEach(([, , value], index) => {
          const each = value(columns, n, second, this.pitch);
          data[index + 1][place] = Number.isFinite(each) ? each : null;
        });
        place += 1;
      }
    }
    const plot = this.plots[name];
    plot.batch(() => {
      plot.setData(data, false);
      const end = Math.max(signals.shown, columns.time[signals.begin] + this.window);
      plot.setScale("x", { min: end - this.window, max: end });
    });
  }

  // A flag on a pole, in no curve's color.
  drawMarks(plot) {
    const { ctx: context, bbox } = plot;
    context.save();
    context.setLineDash([]);
    context.strokeStyle = palette.text;
    context.fillStyle = palette.text;
    context.lineWidth = devicePixelRatio;
    const flag = 9 * devicePixelRatio;
    for (const time of this.marks) {
      const x = plot.valToPos(time, "x", true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      context.beginPath();
      context.moveTo(x, bbox.top + bbox.height);
      context.lineTo(x, bbox.top);
      context.lineTo(x + flag, bbox.top + flag / 2);
      context.lineTo(x, bbox.top + flag);
      context.stroke();
      context.fill();
    }
    context.restore();
  }
}

// The title, and what each line means.
function heading({ title, series }) {
  const place = document.createElement("div");
  place.className = "heading";
  const words = document.createElement("span");
  words.textContent = title;
  place.append(words, ...series.filter(([label]) => label).map(([label, color, , { dash = [] }]) => {
    const entry = document.createElement("span");
    entry.className = `entry ${color}`;
    entry.dataset.line = { [DASHED]: "dashed", [DOTTED]: "dotted" }[dash] ?? "solid";
    entry.textContent = label;
    return entry;
  }));
  return place;
}

// The range of all curves of a plot, with some room.
function spread(plot, least) {
  let [low, high] = [Infinity, -Infinity];
  for (const curve of plot.data.slice(1)) {
    for (const value of curve) {
      if (value === null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return [0, 1];
  const reach = Math.max((high - low) / 2, least / 2) * 1.12;
  const middle = (low + high) / 2;
  return [middle - reach, middle + reach];
}

// A range around zero in which the dead zone is seen, whatever leaves it.
function enlarged(zone, least) {
  const reach = 1.6 * zone.reduce((most, value) => Math.max(most, value ?? 0), least / 1.6);
  return [-reach, reach];
}
