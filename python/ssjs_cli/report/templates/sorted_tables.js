"use strict";
/** A click on the head of a column sorts the table by it. */
function connectSortedTables() {
  document.querySelectorAll("table.sortable").forEach((table) => {
    const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => head.addEventListener("click", () => {
      const upward = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", upward ? "ascending" : "descending");
      const value = (row) => row.cells[column].dataset.v;
      const numeric = [...body.rows].every((row) => value(row) !== "" && !Number.isNaN(Number(value(row))));
      const compare = numeric ? (a, b) => Number(value(a)) - Number(value(b)) : (a, b) => (value(a) < value(b) ? -1 : value(a) > value(b) ? 1 : 0);
      body.append(...[...body.rows].sort((a, b) => (upward ? compare(a, b) : compare(b, a))));
    }));
  });
}
