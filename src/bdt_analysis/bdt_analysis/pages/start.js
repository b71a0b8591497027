// Draws the plots and connects them with the table of steps, the buttons and the address.
"use strict";

// Moments have addresses: #t=10,20 is an interval of time, #step=3 a step, #step=3,end its end.
function connect(timePlot, cyclePlot) {
  const { runs, panels } = timePlot.description;
  const steps = runs[0].steps;
  const everyHeight = { fit: panels.map((panel) => panel.key) };
  const rows = [...document.querySelectorAll("tr[data-step]")];

  function address(text) {
    if (location.hash !== text) history.replaceState(null, "", text || location.pathname);
  }

  async function select(number, { end = false, move = true } = {}) {
    const step = steps[number - 1];
    if (!step) return;
    cyclePlot.index = number - 1;
    rows.forEach((row) => row.classList.toggle("selected", row.dataset.step === String(number)));
    await cyclePlot.draw();
    if (!move) return;
    const begin = end ? step.end - step.window : step.begin;
    await timePlot.show(begin, step.end, end ? everyHeight : { reset: true });
    address(`#step=${number}${end ? ",end" : ""}`);
  }

  async function follow() {
    const [name, value = ""] = location.hash.slice(1).split("=");
    const parts = value.split(",");
    const [first, second] = parts.map(Number);
    if (name === "t" && first < second) await timePlot.show(first, second, {});
    else if (name === "step") await select(first, { end: parts[1] === "end" });
    else return false;
    return true;
  }

  for (const row of rows) {
    row.tabIndex = 0;
    const go = () => select(Number(row.dataset.step));
    row.addEventListener("click", () => { if (!String(getSelection())) go(); });
    row.addEventListener("keydown", (event) => { if (event.key === "Enter") go(); });
  }
  const button = (id, action) => document.getElementById(id).addEventListener("click", action);
  const clamp = (number) => Math.min(Math.max(number, 1), steps.length);
  button("whole", async () => { await timePlot.showAll(); address(""); });
  button("fit", () => timePlot.show(...timePlot.range, everyHeight));
  button("previous", () => select(clamp(cyclePlot.index)));
  button("next", () => select(clamp(cyclePlot.index + 2)));
  button("step-end", () => select(cyclePlot.index + 1, { end: true }));
  timePlot.element.addEventListener("shown", () => {
    const [begin, end] = timePlot.range.map((time) => +time.toFixed(4));
    address(`#t=${begin},${end}`);
  });
  addEventListener("hashchange", follow);
  document.addEventListener("theme", () => { timePlot.recolor(); cyclePlot.draw(); });
  return { select, follow };
}

// Number of the step of which most is left, in whichever run.
function worstStep(runs) {
  const left = runs[0].steps.map(
    (step, k) => Math.max(...runs.map((run) => run.steps[k]?.residual ?? -1)),
  );
  return 1 + left.indexOf(Math.max(...left));
}

drawPage(async (description) => {
  await loadSignals(description);
  document.documentElement.classList.add("interactive-ready");
  const timePlot = new TimePlot(document.getElementById("time-plot"), description);
  const cyclePlot = new CyclePlot(document.getElementById("cycle-plot"), description);
  await timePlot.draw();
  const { select, follow } = connect(timePlot, cyclePlot);
  await select(worstStep(description.runs), { move: false });
  await follow();
});
