// The plots of a sweep: a quantity over two parameters, along one, and the indices.
"use strict";

const title = (name, axis) => (axis?.unit ? `${name} [${axis.unit}]` : name);

const isChance = (quantity) => quantity === "limit_cycle";

const label = (quantity) => (isChance(quantity) ? "probability of a limit cycle" : quantity);

class SweepPlots {
  constructor(description) {
    this.description = description;
    this.names = description.axes.map((axis) => axis.name);
    this.axes = Object.fromEntries(description.axes.map((axis) => [axis.name, axis]));
    this.quantities = [...new Set(description.maps.map((map) => map.quantity))];
  }

  // Maps are there for one order of two parameters; the other one is its transpose.
  map(quantity, right, upward) {
    const is = (map, ...axes) => map.quantity === quantity && String(map.axes) === String(axes);
    const { maps } = this.description;
    if (right === upward || !upward) return maps.find((map) => is(map, right));
    const found = maps.find((map) => is(map, right, upward));
    if (found) return found;
    const turned = maps.find((map) => is(map, upward, right));
    const transpose = (rows) => rows && rows[0].map((_, k) => rows.map((row) => row[k]));
    return {
      ...turned, values: transpose(turned.values), low: transpose(turned.low),
      high: transpose(turned.high), counts: transpose(turned.counts),
    };
  }

  layout(right, upward, quantity) {
    const side = (name, text) => ({ ...axisLooks(), automargin: true, title: { text } });
    const { axes } = this;
    return {
      ...commonLooks(), height: 460, margin: { t: 20, r: 20 }, showlegend: false,
      xaxis: side(right, title(right, axes[right])),
      yaxis: side(upward, upward ? title(upward, axes[upward]) : label(quantity)),
    };
  }

  async drawMap(quantity, right, upward) {
    const { axes } = this;
    const element = document.getElementById("map-plot");
    if (!upward || right === upward) {
      element.closest("figure").hidden = true;
      return;
    }
    element.closest("figure").hidden = false;
    const map = this.map(quantity, right, upward);
    const text = map.counts && map.counts.map((row, j) => row.map(
      (count, k) => `${map.low[j][k].toPrecision(2)} to ${map.high[j][k].toPrecision(2)}, ${count} runs`,
    ));
    const traces = [{
      type: "heatmap", x: axes[right].values, y: axes[upward].values, z: map.values, text,
      colorscale: [[0, css("window")], [0.5, css("dead-zone")], [1, css("alarm-ink")]],
      ...(isChance(quantity) ? { zmin: 0, zmax: 1 } : {}),
      colorbar: { title: { text: label(quantity), side: "right" } },
      hovertemplate: `%{x:.4g}, %{y:.4g}: %{z:.3g}${text ? "<br>%{text}" : ""}<extra></extra>`,
    }];
    const point = [axes[right].paper, axes[upward].paper];
    if (point.every((value) => value !== null)) {
      traces.push({
        x: [point[0]], y: [point[1]], mode: "markers", name: "paper",
        marker: { symbol: "x", size: 12, color: css("position"), line: { width: 2, color: css("paper") } },
        hovertemplate: "the paper's loop<extra></extra>",
      });
    }
    await Plotly.react(element, traces, this.layout(right, upward, quantity), plotOptions("map"));
  }

  async drawLine(quantity, right) {
    const axis = this.axes[right];
    const map = this.map(quantity, right);
    const traces = [];
    if (map.low) {
      const band = { x: axis.values, mode: "lines", line: { width: 0 }, hoverinfo: "skip" };
      traces.push({ ...band, y: map.low });
      traces.push({ ...band, y: map.high, fill: "tonexty", fillcolor: faded("position", 0.2) });
    }
    traces.push({
      x: axis.values, y: map.values, mode: "lines+markers", line: { color: css("position") },
      hovertemplate: "%{x:.4g}: %{y:.3g}<extra></extra>",
    });
    const layout = this.layout(right, null, quantity);
    layout.height = 320;
    layout.shapes = axis.paper === null ? [] : [{
      type: "line", x0: axis.paper, x1: axis.paper, y0: 0, y1: 1, yref: "paper",
      line: { dash: "dot", color: css("faint") },
    }];
    await Plotly.react("line-plot", traces, layout, plotOptions("along"));
  }

  async drawIndices(quantity) {
    const element = document.getElementById("index-plot");
    if (!element) return;
    const found = this.description.indices.find((one) => one.quantity === quantity);
    element.closest("figure").hidden = !found;
    if (!found) return;
    const bars = (name, values, array, color) => ({
      type: "bar", name, x: found.parameters, y: values, marker: { color: css(color) },
      error_y: { type: "data", array, color: css("ink") },
    });
    const layout = this.layout("", null, quantity);
    layout.height = 320;
    layout.showlegend = true;
    layout.yaxis.title.text = `share of the variance of ${quantity}`;
    await Plotly.react(element, [
      bars("first", found.first, found.first_interval, "position"),
      bars("total", found.total, found.total_interval, "dead-zone"),
    ], layout, plotOptions("indices"));
  }
}

function choices(id, names, chosen) {
  const select = document.getElementById(id);
  select.replaceChildren(...names.map((name) => new Option(name, name, false, name === chosen)));
  return select;
}

drawPage(async (description) => {
  document.documentElement.classList.add("interactive-ready");
  const plots = new SweepPlots(description);
  if (!plots.names.length) throw new Error("no parameter has more than one value");
  const quantity = choices("quantity", plots.quantities, plots.quantities[0]);
  const right = choices("right", plots.names, plots.names[0]);
  const upward = choices("upward", plots.names, plots.names[1] ?? plots.names[0]);
  const draw = async () => {
    await plots.drawMap(quantity.value, right.value, upward.value);
    await plots.drawLine(quantity.value, right.value);
    await plots.drawIndices(quantity.value);
  };
  for (const select of [quantity, right, upward]) select.addEventListener("change", draw);
  document.addEventListener("theme", draw);
  await draw();
});
