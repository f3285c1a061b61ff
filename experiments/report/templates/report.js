"use strict";
const value = (row, column) => row.cells[column].textContent.trim().replace("°", "");
const compare = (a, b, sign) => {
  if (a === "" || b === "") return (a === "") - (b === "");  // nothing measured: always last
  const numbers = [Number(a), Number(b)];
  const texts = numbers.some(Number.isNaN);
  return sign * (texts ? a.localeCompare(b, undefined, { numeric: true }) : numbers[0] - numbers[1]);
};
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
    const down = head.getAttribute("aria-sort") === "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const rows = [...table.tBodies[0].rows];
    rows.sort((a, b) => compare(value(a, column), value(b, column), down ? -1 : 1));
    table.tBodies[0].append(...rows);
  }));
}
const show = () => {
  const trial = location.hash && document.getElementById(location.hash.slice(1));
  if (trial instanceof HTMLDetailsElement) { trial.open = true; trial.scrollIntoView(); }
};
addEventListener("hashchange", show);
show();
for (const trial of document.querySelectorAll("details.trial")) {
  trial.addEventListener("toggle", () => {
    const film = trial.querySelector("video");
    if (film && trial.open) film.preload = "metadata";
  });
}
addEventListener("beforeprint", () => {
  for (const trial of document.querySelectorAll("details.suspect, details.failed")) trial.open = true;
  for (const picture of document.images) picture.loading = "eager";
});
