"use strict";
(function () {
  const { report, byId, drawn, draw, drawAll, connectLayers, tameWheel, connectTables, connectPrint } = ssjsPage;
  connectTables();
  connectPrint();
  draw("map")
    .then(() => {
      if (!drawn.map) return;
      connectLayers();
      tameWheel(byId("map"));
    })
    .then(() => drawAll(Object.keys(report.figures).filter((id) => id !== "map").sort()));
})();
