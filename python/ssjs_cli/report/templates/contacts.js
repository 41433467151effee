"use strict";
/** The sheet of pictures: sorted by a number of the images, enlarged by a click. */
(function () {
  const sheet = document.getElementById("contact-sheet"), order = document.getElementById("sheet-order"), large = document.getElementById("large");
  connectSortedTables();
  if (sheet && order) {
    const cards = [...sheet.children];
    const sort = () => {
      const key = order.value;
      const value = (card) => Number(card.dataset[key] ?? -Infinity);
      sheet.append(...(key ? [...cards].sort((a, b) => value(b) - value(a)) : cards));
    };
    order.value = "";
    order.addEventListener("change", sort);
  }
  if (sheet && large) {
    const picture = large.querySelector("img");
    sheet.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      if (!button) return;
      picture.src = button.querySelector("img").src;
      picture.alt = button.querySelector("img").alt;
      large.showModal();
    });
    large.addEventListener("click", () => large.close());
  }
  document.documentElement.setAttribute("data-report", "ready");
})();
