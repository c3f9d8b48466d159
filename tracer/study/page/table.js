"use strict";
// Tables that are sorted by a click on a heading: numbers by value, names by letter; unknown values come last.

function sortRows(table, column, direction) {
  const body = table.tBodies[0];
  const key = (row) => row.cells[column].dataset.key ?? row.cells[column].textContent;
  const compare = (first, second) => {
    const [a, b] = [key(first), key(second)], [x, y] = [Number(a), Number(b)];
    if (a === "nan" || b === "nan") return (a === "nan") - (b === "nan");
    return direction * (Number.isNaN(x) || Number.isNaN(y) ? a.localeCompare(b) : x - y);
  };
  body.append(...[...body.rows].sort(compare));
}

for (const table of document.querySelectorAll("table.sortable")) {
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => {
    const sorter = Object.assign(document.createElement("button"), { type: "button", textContent: heading.textContent });
    heading.replaceChildren(sorter);
    sorter.addEventListener("click", () => {
      const ascending = heading.getAttribute("aria-sort") !== "ascending";
      headings.forEach((sibling) => sibling.removeAttribute("aria-sort"));
      heading.setAttribute("aria-sort", ascending ? "ascending" : "descending");
      sortRows(table, column, ascending ? 1 : -1);
    });
  });
}
