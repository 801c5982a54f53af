// Tables: a header sorts, a field above a long table filters. The panel of an open run stays below its row.
(() => {
  const { element } = torquebench;
  const LONG = 12;
  const key = (row, column) => {
    const cell = row.cells[column];
    const text = cell.dataset.v ?? cell.textContent.trim();
    // A number that reads as it is has no value beside its text.
    const plain = cell.dataset.v !== undefined || (cell.classList.contains("n") && text !== "" && isFinite(text));
    return plain ? Number(text) : text;
  };
  const order = (a, b) => {
    if (typeof a === "number" && typeof b === "number") return a - b;
    return String(a).localeCompare(String(b), "en", { numeric: true });
  };
  const isPanel = (row) => row.classList.contains("run-panel");
  const panelOf = (row) => (row.nextElementSibling && isPanel(row.nextElementSibling) ? [row.nextElementSibling] : []);

  const sort = (table, header, column) => {
    const ascending = header.getAttribute("aria-sort") !== "ascending";
    for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
    header.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    const body = table.tBodies[0];
    const rows = [...body.rows].filter((row) => !isPanel(row)).map((row) => [key(row, column), row, panelOf(row)]);
    const numeric = rows.some(([value]) => typeof value === "number");
    // In a column of numbers, words go last whatever the direction.
    const last = (value) => (numeric && typeof value !== "number" ? 1 : 0);
    rows.sort(([a], [b]) => last(a) - last(b) || (ascending ? order(a, b) : order(b, a)));
    body.append(...rows.flatMap(([, row, panel]) => [row, ...panel]));
  };

  const filter = (rows, text, count) => {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of rows) {
      const found = row.textContent.toLowerCase();
      row.hidden = !words.every((word) => found.includes(word));
      for (const panel of panelOf(row)) panel.hidden = row.hidden;
      shown += !row.hidden;
    }
    count.textContent = words.length ? `${shown} of ${rows.length} rows` : "";
  };
  const addFilter = (table) => {
    const rows = [...table.tBodies[0].rows];
    const count = element("output");
    const search = () => filter(rows, field.value, count);
    const field = element("input", { type: "search", placeholder: "words that a row must hold", input: search });
    const box = element("p", { class: "filter" }, element("label", {}, "Filter ", field), count);
    table.closest(".block").prepend(box);
  };

  for (const table of document.querySelectorAll("table")) {
    if (table.tBodies[0].rows.length < 2) continue;
    const headers = table.tHead.rows[table.tHead.rows.length - 1].cells;
    [...headers].forEach((header, column) => {
      const click = () => sort(table, header, column);
      const control = element("button", { type: "button", title: "Sort by this column", click });
      control.append(...header.childNodes);
      header.append(control);
    });
    if (table.tBodies[0].rows.length >= LONG) addFilter(table);
  }
})();
