/* Sorts a whole table by the column whose head is pressed, upwards and then downwards: words, then numbers; gaps stay below. */
document.addEventListener("click", (event) => {
  const head = event.target.closest("table.whole thead th");
  if (!head) return;
  const body = head.closest("table").tBodies[0];
  const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
  const text = (row) => row.cells[head.cellIndex].textContent.trim();
  const order = (one, other) => {
    const [a, b] = [text(one), text(other)];
    const gaps = ["", "–"].includes(a) - ["", "–"].includes(b);
    const [x, y] = [a, b].map((cell) => Number(cell.replace(/^inf$/, "Infinity")));
    if (gaps || x === y) return gaps;
    return sign * (isNaN(y) - isNaN(x) || x - y || a.localeCompare(b));
  };
  body.append(...[...body.rows].sort(order));
});
