// The plots above one time axis, which zoom and pan together.
"use strict";

function css(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

// A color of the page with an opacity; the page's colors are #rrggbb.
function faded(name, opacity) {
  const hex = css(name);
  const part = (k) => parseInt(hex.slice(k, k + 2), 16);
  return `rgba(${part(1)}, ${part(3)}, ${part(5)}, ${opacity})`;
}

const axisLooks = () => ({
  gridcolor: css("grid"), zerolinecolor: css("grid"), linecolor: css("faint"),
  tickcolor: css("faint"), zeroline: true, automargin: false,
});

const commonLooks = () => ({
  paper_bgcolor: "rgba(0, 0, 0, 0)",
  plot_bgcolor: "rgba(0, 0, 0, 0)",
  font: { family: css("font"), size: 12, color: css("ink") },
  hoverlabel: {
    bgcolor: faded("paper", 0.85), bordercolor: css("faint"), font: { color: css("ink") },
  },
  modebar: { bgcolor: "rgba(0, 0, 0, 0)", color: css("faint"), activecolor: css("ink") },
});

const plotOptions = (name) => ({
  displaylogo: false,
  showSendToCloud: false,
  responsive: true,
  doubleClick: false,
  modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d", "resetScale2d"],
  toImageButtonOptions: { filename: name, scale: 2 },
});

class TimePlot {
  constructor(element, description) {
    this.element = element;
    this.description = description;
    this.begin = Math.min(...description.runs.map((run) => run.begin));
    this.end = Math.max(...description.runs.map((run) => run.end));
    this.range = [this.begin, this.end];
    // Heights of the panels: room for their legends lies between them.
    const count = description.panels.length;
    const room = 0.055;
    const height = (1 - count * room) / count;
    this.domains = description.panels.map((panel, k) => {
      const top = 1 - room - k * (height + room);
      return [Math.max(top - height, 0), top];
    });
  }

  axis(key) {
    const k = this.description.panels.findIndex((panel) => panel.key === key);
    return k ? `${k + 1}` : "";
  }

  panel(key) {
    return this.description.panels.find((panel) => panel.key === key);
  }

  get columns() {
    return Math.max(this.element.clientWidth - 70, 200);
  }

  views() {
    return this.description.series.map((item) => viewOf(item, ...this.range, this.columns));
  }

  traces() {
    const views = this.views();
    this.note(views);
    const several = this.description.runs.length > 1;
    return this.description.series.map((item, k) => ({
      type: "scatter",
      mode: "lines",
      x: views[k].x,
      y: views[k].y,
      xaxis: "x",
      yaxis: `y${this.axis(item.panel)}`,
      legend: `legend${this.axis(item.panel)}`,
      legendgroup: several ? `run ${item.run}` : `${item.panel} ${item.name}`,
      name: item.name,
      showlegend: !item.quiet,
      fill: item.fill ? "tonexty" : "none",
      fillcolor: faded(item.color, 0.14),
      ...(item.quiet && !several
        ? { hoverinfo: "skip" }
        : { hovertemplate: `%{y:.5g} ${this.panel(item.panel).unit}` }),
      line: {
        color: css(item.color),
        width: item.width,
        dash: item.dash,
        shape: item.steps ? "hv" : "linear",
      },
    }));
  }

  layout() {
    const { panels, time_label: label } = this.description;
    const layout = {
      ...commonLooks(),
      height: 200 * panels.length + 60,
      margin: { l: 58, r: 12, t: 6, b: 42 },
      hovermode: "x unified",
      hoversubplots: "axis",
      dragmode: matchMedia("(pointer: coarse)").matches ? "pan" : "zoom",
      shapes: [...this.shading(), ...this.marks()],
      xaxis: {
        ...axisLooks(),
        title: { text: label },
        range: this.range,
        anchor: `y${panels.length > 1 ? panels.length : ""}`,
        showspikes: true, spikemode: "across", spikethickness: 1, spikedash: "dot",
        spikecolor: css("faint"), spikesnap: "cursor",
        hoverformat: ".4f", unifiedhovertitle: { text: "%{x:.4f} s" },
      },
    };
    panels.forEach((panel, k) => {
      const number = k ? k + 1 : "";
      layout[`yaxis${number}`] = {
        ...axisLooks(), title: { text: `${panel.quantity} [${panel.unit}]`, standoff: 6 }, domain: this.domains[k],
        ...(panel.range ? { range: panel.range } : { autorange: true }),
      };
      layout[`legend${number}`] = {
        orientation: "h", x: 0, y: this.domains[k][1], xanchor: "left", yanchor: "bottom",
        bgcolor: "rgba(0, 0, 0, 0)", font: { size: 11 },
      };
    });
    return layout;
  }

  // Steps that end in a limit cycle; of several runs none is shaded.
  shading() {
    if (this.description.runs.length > 1) return [];
    const steps = this.description.runs[0].steps.filter((step) => step.limit_cycle);
    return this.description.panels.flatMap((panel) => steps.map((step) => ({
      type: "rect", xref: "x", yref: `y${this.axis(panel.key)} domain`,
      x0: step.begin, x1: step.end, y0: 0, y1: 1,
      layer: "below", line: { width: 0 }, fillcolor: css("alarm"), opacity: 0.7,
    })));
  }

  // What somebody has marked; of several runs none.
  marks() {
    if (this.description.runs.length > 1) return [];
    return this.description.panels.flatMap((panel) => this.description.runs[0].marks.map((time) => ({
      type: "line", xref: "x", yref: `y${this.axis(panel.key)} domain`,
      x0: time, x1: time, y0: 0, y1: 1, line: { width: 2, dash: "dot", color: css("ink") },
    })));
  }

  async draw() {
    await Plotly.newPlot(this.element, this.traces(), this.layout(), plotOptions("run"));
    this.element.on("plotly_relayout", (change) => {
      if (Object.keys(change).some((key) => key.startsWith("xaxis."))) {
        this.show(...this.element.layout.xaxis.range, {});
      }
    });
    this.element.on("plotly_doubleclick", () => this.showAll());
  }

  // Colors of the other theme; the view stays.
  async recolor() {
    const layout = this.layout();
    for (const [name, axis] of Object.entries(this.element.layout)) {
      if (/^[xy]axis/.test(name)) {
        Object.assign(layout[name], { range: axis.range, autorange: axis.autorange });
      }
    }
    await Plotly.react(this.element, this.traces(), layout, plotOptions("run"));
  }

  // Shows an interval of time [s] in all panels. `fit` lists panels that fit what is left in them.
  async show(begin, end, { fit = [], reset = false }) {
    this.range = [Number(begin), Number(end)];
    const views = this.views();
    const change = { "xaxis.range": this.range };
    for (const panel of this.description.panels) {
      const axis = `yaxis${this.axis(panel.key)}`;
      if (fit.includes(panel.key)) change[`${axis}.autorange`] = true;
      else if (reset && panel.range) change[`${axis}.range`] = [...panel.range];
      else if (reset) change[`${axis}.autorange`] = true;
    }
    this.note(views);
    const data = { x: views.map((view) => view.x), y: views.map((view) => view.y) };
    await Plotly.update(this.element, data, change);
    this.element.dispatchEvent(new CustomEvent("shown"));
  }

  showAll() {
    return this.show(this.begin, this.end, { reset: true });
  }

  // Says what is drawn, in the words of the series with most samples.
  note(views) {
    const { series } = this.description;
    const k = series.reduce((best, item, n) => (item.samples > series[best].samples ? n : best), 0);
    const item = series[k];
    const [begin, end] = this.range;
    const count = (number) => Math.round(number).toLocaleString("en-US").replaceAll(",", "\u202f");
    const time = (seconds) => (
      seconds < 1 ? `${+(1e3 * seconds).toPrecision(3)} ms` : `${+seconds.toPrecision(3)} s`
    );
    const pixel = (end - begin) / this.columns;
    const rate = item.samples / (item.time[item.time.length - 1] - item.time[0]);
    const held = item.bin_width
      ? `The page holds ${count(item.points)} of ${count(item.samples)} samples of a signal: first, `
        + `smallest, largest and last of every ${time(item.bin_width)} (${count(rate * item.bin_width)} samples).`
      : `The page holds every one of the ${count(item.samples)} samples of a signal.`;
    const drawn = views[k].whole
      ? "This view draws all of them that lie in it."
      : "This view draws first, smallest, largest and last of each pixel column of "
        + `${time(pixel)} (${count(pixel * rate)} samples).`;
    const shown = `${+begin.toPrecision(7)} s to ${+end.toPrecision(7)} s.`;
    document.getElementById("decimation").textContent = `${shown} ${held} ${drawn}`;
    const points = views.reduce((sum, view) => sum + view.x.length, 0);
    Object.assign(this.element.dataset, { begin, end, points });
  }
}
