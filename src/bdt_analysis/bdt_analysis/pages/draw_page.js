// Begins the plots of a page: plotly, which it has with it, then what it draws; a failure is told.
"use strict";

async function loadPlotly() {
  const library = document.createElement("script");
  library.textContent = new TextDecoder().decode(await unpacked("plotly"));
  document.head.append(library);
}

// `draw` gets what the page describes, and promises that all of it is drawn.
async function drawPage(draw) {
  try {
    const description = JSON.parse(document.getElementById("description").textContent);
    await loadPlotly();
    await draw(description);
    document.documentElement.dataset.plots = "drawn";
  } catch (error) {
    document.documentElement.classList.remove("interactive-ready");
    document.documentElement.dataset.plots = "failed";
    document.getElementById("plots-failed").hidden = false;
    document.getElementById("plots-failed").append(` (${error})`);
    console.error(error);
  }
}
