// Puts the page together: messages go to its parts, and each frame draws what is new.

import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { Mechanism } from "./mechanism.js";
import { Nodes } from "./nodes.js";
import { readPalette } from "./palette.js";
import { Plots } from "./plots.js";
import { Portraits } from "./portraits.js";
import { Signals } from "./signals.js";
import { TimeControl } from "./time_control.js";

const CALM = 0.25; // s between two pictures for those who want less motion

const find = (id) => document.getElementById(id);
const calm = matchMedia("(prefers-reduced-motion: reduce)");

readTheme();
readPalette();
const signals = new Signals();
const mechanism = new Mechanism(find("mechanism"));
const portraits = new Portraits(find("hysteresis"), find("phase"));
const plots = new Plots({
  position: find("plot-position"), error: find("plot-error"), voltage: find("plot-voltage"),
  gap: find("plot-gap"),
});
const nodes = new Nodes(find("state"), find("reason"), find("nodes"), find("log"));
const connection = new Connection(take, ({ isThere, isStranger }) => {
  if (!isThere) nodes.tell("waiting", "connection lost, trying again");
  announce(isStranger ? "bdt live was started anew: open the address that it has printed" : "");
});
const controls = new Controls(find("controls"), connection);
const timeControl = new TimeControl(connection, nodes);
controls.notes.push((_node, name, value) => {
  if (name === "lead_screw.pitch") plots.pitch = value;
});

const takers = {
  frame: ({ rows }) => signals.add(rows),
  history: ({ frames }) => {
    signals.clear();
    for (const { rows } of frames) signals.add(rows);
  },
  parameters: (message) => {
    controls.take(message);
    timeControl.allow(controls.offers("plant"));
  },
  values: (message) => controls.takeValues(message),
  state: (message) => {
    nodes.take(message);
    timeControl.take(message);
    find("rate").textContent = message.rate === null ? "–" : `${message.rate.toFixed(0)} Hz`;
    find("latency").textContent = message.latency === null ? "–" : `${(1e3 * message.latency).toFixed(2)} ms`;
  },
  log: ({ line }) => nodes.addLine(`${line.node}: ${line.text}`, line.level),
  marks: ({ times }) => {
    for (const time of times) {
      if (!plots.marks.includes(time)) nodes.addLine(`marked at ${time.toFixed(2)} s`);
    }
    plots.marks = times;
  },
  saved: ({ bag, reason }) => nodes.addLine(reason ? `${bag}: ${reason}` : `saved ${bag}`, reason ? 40 : 20),
  report: ({ bag, reason }) => {
    if (reason) nodes.addLine(`no report of ${bag}: ${reason}`, 40);
    else nodes.addLine(`report of ${bag}`, 20, `report/${bag}/report.html`);
  },
  refused: ({ reason }) => nodes.addLine(`refused: ${reason}`, 40),
  fault: ({ text }) => announce(text),
};

function announce(text) {
  find("banner").textContent = text;
  find("banner").hidden = !text;
}

function take(message) {
  takers[message.type]?.(message);
  if (message.type === "frame" && signals.size) signals.noteArrival(performance.now() / 1e3);
}

function readTheme(chosen = null) {
  const light = matchMedia("(prefers-color-scheme: light)").matches;
  const theme = chosen ?? sessionStorage.getItem("theme") ?? (light ? "light" : "dark");
  document.documentElement.dataset.theme = theme;
  sessionStorage.setItem("theme", theme);
  find("theme").textContent = theme === "dark" ? "Light" : "Dark";
}

find("theme").addEventListener("click", () => {
  readTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
  readPalette();
  plots.build();
});
find("window").addEventListener("change", (event) => { plots.window = Number(event.target.value); });

let before = performance.now();
let frames = 0;

function draw(timestamp) {
  requestAnimationFrame(draw);
  const elapsed = (timestamp - before) / 1e3;
  if (calm.matches && elapsed < CALM) return;
  before = timestamp;
  frames += 1;
  document.documentElement.dataset.frames = frames;
  signals.advance(elapsed);
  mechanism.draw(signals.now());
  plots.drawNext(signals);
  if (frames % 3 === 0) portraits.draw(signals);
  if (frames % 15 === 0) controls.follow(signals.now()?.gap);
  if (signals.shown !== null) find("time").textContent = `${signals.shown.toFixed(2)} s`;
}

requestAnimationFrame(draw);
