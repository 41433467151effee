"use strict";
/** What every page shares: its data, its plots, paper. */
const ssjsPage = (function () {
  const report = JSON.parse(document.getElementById("report-data").textContent);
  const byId = (id) => document.getElementById(id);
  // Named one by one: plotly's own choice holds a button that sends the data to a server.
  const buttons = [["toImage"], ["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"]];
  const plain = { responsive: true, displaylogo: false, modeBarButtons: buttons, showSendToCloud: false, plotlyServerURL: "" };
  const drawn = {};

  function draw(id) {
    const element = byId(id);
    const figure = report.figures[id];
    if (!element || !figure) return Promise.resolve();
    const config = Object.assign({}, plain, {
      scrollZoom: id === "map",
      toImageButtonOptions: { format: "svg", filename: id },
    });
    return Plotly.newPlot(element, figure.data, figure.layout, config).then(() => {
      drawn[id] = element;
      keepScalable(element);
      element.on("plotly_afterplot", () => keepScalable(element));
    });
  }

  // ---- map layers -------------------------------------------------------------------------------------------------
  function connectLayers() {
    document.querySelectorAll("input[data-layer]").forEach((box) => {
      // a reloaded page may remember another choice than the one drawn
      box.checked = box.defaultChecked;
      box.addEventListener("change", () => Plotly.restyle(byId("map"), { visible: box.checked }, report.layers[box.dataset.layer]));
    });
  }

  // The wheel scrolls the page; with Ctrl it zooms the map.
  function tameWheel(map) {
    map.addEventListener("wheel", (event) => { if (!event.ctrlKey && !event.metaKey) event.stopImmediatePropagation(); }, { capture: true, passive: true });
  }

  // ---- print: every number open; the plots shrink with the paper by their view boxes (report.css) ---------------------
  function connectPrint() {
    let closed = [];
    window.addEventListener("beforeprint", () => {
      closed = [...document.querySelectorAll("details:not([open])")];
      closed.forEach((element) => { element.open = true; });
    });
    window.addEventListener("afterprint", () => closed.forEach((element) => { element.open = false; }));
  }

  function keepScalable(element) {
    const width = element._fullLayout.width, height = element._fullLayout.height;
    element.style.setProperty("--ratio", `${width} / ${height}`);
    element.querySelectorAll(".main-svg").forEach((svg) => svg.setAttribute("viewBox", `0 0 ${width} ${height}`));
  }

  /** The plots one after the other, so that the page stays responsive; then the page says that it is ready. */
  function drawAll(ids) {
    return ids
      .reduce((before, id) => before.then(() => new Promise((done) => requestAnimationFrame(() => draw(id).then(done)))), Promise.resolve())
      .then(() => document.documentElement.setAttribute("data-report", "ready"));
  }

  return { report, byId, drawn, draw, drawAll, connectLayers, tameWheel, connectTables: connectSortedTables, connectPrint };
})();
