"use strict";
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.firstChild.addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const value = (row) => {
      const raw = row.cells[column].dataset.sort;
      if (raw === "inf") return Infinity;
      return raw !== "" && !isNaN(raw) ? Number(raw) : raw;
    };
    const order = (a, b) => {
      const x = value(a), y = value(b);
      if (typeof x === "number" && typeof y === "number") return x === y ? 0 : x < y ? -1 : 1;
      return String(x).localeCompare(String(y), undefined, { numeric: true });
    };
    const rows = [...table.tBodies[0].rows].sort((a, b) => (up ? order(a, b) : order(b, a)));
    table.tBodies[0].append(...rows);
  }));
}
addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((fold) => { fold.open = true; }));
