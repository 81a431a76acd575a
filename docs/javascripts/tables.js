/* Sorts a whole table by the column whose head is pressed, upwards and then downwards; gaps stay below. */
document.addEventListener("click", (event) => {
  const head = event.target.closest("table.whole thead th");
  if (!head) return;
  const body = head.closest("table").tBodies[0];
  const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const other of head.parentElement.cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
  const text = (row) => row.cells[head.cellIndex].textContent.trim();
  const number = (row) => (text(row) === "" ? NaN : Number(text(row)));
  const order = (one, other) => {
    const [a, b] = [number(one), number(other)];
    if (isNaN(a) && isNaN(b)) return sign * text(one).localeCompare(text(other));
    return isNaN(a) - isNaN(b) || sign * (a - b);
  };
  body.append(...[...body.rows].sort(order));
});
