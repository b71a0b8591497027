// The end of one step: what is left of the error over time, and against the voltage.
"use strict";

class CyclePlot {
  constructor(element, description) {
    this.element = element;
    this.description = description;
    this.index = 0;
  }

  series(run, panel) {
    return this.description.series.find(
      (item) => item.run === run && item.panel === panel && !item.steps,
    );
  }

  // Error over the end of the step, and the voltage that held at each of its points.
  part(run) {
    const step = this.description.runs[run].steps[this.index];
    const error = this.series(run, "error");
    const voltage = this.series(run, "voltage");
    if (!step || !error || !voltage) return null;
    const first = firstFrom(error.time, step.end - step.window);
    const last = firstFrom(error.time, step.end);
    const time = error.time.slice(first, last);
    const held = time.map((t) => voltage.value[Math.max(firstFrom(voltage.time, t + 1e-6) - 1, 0)]);
    return {
      time: time.map((t) => t - step.begin),
      error: error.value.slice(first, last),
      held,
      color: error.color,
    };
  }

  traces() {
    return this.description.runs.flatMap((run, k) => {
      const part = this.part(k);
      if (!part) return [];
      const line = { color: css(part.color), width: 1.4 };
      const common = { type: "scatter", mode: "lines", name: run.name, legendgroup: run.name, line };
      return [
        { ...common, x: part.time, y: part.error, hovertemplate: "%{y:.5g} µm at %{x:.4f} s" },
        {
          ...common, x: part.error, y: part.held, xaxis: "x2", yaxis: "y2", showlegend: false,
          hovertemplate: "%{x:.5g} µm, %{y:.5g} V",
        },
      ];
    });
  }

  layout() {
    const narrow = this.element.clientWidth < 640;
    const axis = (title, anchor, domain) => (
      { ...axisLooks(), title: { text: title, standoff: 6 }, anchor, domain }
    );
    const several = this.description.runs.length > 1;
    return {
      ...commonLooks(),
      height: narrow ? 560 : 320,
      margin: { l: 58, r: 12, t: several ? 30 : 10, b: 42 },
      showlegend: several,
      legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" },
      hovermode: "closest",
      xaxis: axis("time since the step [s]", "y", narrow ? [0, 1] : [0, 0.54]),
      yaxis: axis("q3 − r [µm]", "x", narrow ? [0.58, 1] : [0, 1]),
      xaxis2: axis("q3 − r [µm]", "y2", narrow ? [0, 1] : [0.63, 1]),
      yaxis2: axis("voltage u [V]", "x2", narrow ? [0, 0.42] : [0, 1]),
    };
  }

  async draw() {
    const step = this.description.runs[0].steps[this.index];
    if (!step) return;
    const time = `${+step.begin.toPrecision(6)} s to ${+step.end.toPrecision(6)} s`;
    document.getElementById("cycle-title").textContent = `End of step ${this.index + 1}`
      + ` (${time}, r = ${+step.reference.toPrecision(4)} mm)`;
    this.element.dataset.step = this.index + 1;
    await Plotly.react(this.element, this.traces(), this.layout(), plotOptions("step"));
  }
}
