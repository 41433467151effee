"use strict";
(function () {
  const { report, drawAll, connectTables, connectPrint } = ssjsPage;
  connectTables();
  connectPrint();
  drawAll(Object.keys(report.figures).sort());
})();
