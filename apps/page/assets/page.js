// What a page of tribotrack does beyond standing there: figures and tables leave it as files, pictures grow, on paper all
// of it is shown. Needs figures.js.
"use strict";
(function () {
  const root = document.documentElement, campaign = root.dataset.name || "tribotrack";

  function save(name, type, text) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: type }));
    link.download = campaign + "-" + name;
    link.click();
    setTimeout(function () { URL.revokeObjectURL(link.href); }, 1000);
  }

  function csv_cell(text) { return /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text; }

  // Cells with data-v hold more digits than they show; a column with data-sd has its standard deviations beside it.
  function table_csv(table) {
    const rows = Array.from(table.rows), with_sd = new Set();
    const each_cell = function (row, act) {
      let column = 0;
      Array.from(row.cells).forEach(function (cell) { act(cell, column); column += cell.colSpan; });
    };
    rows.forEach(function (row) {
      each_cell(row, function (cell, column) { if (cell.dataset.sd !== undefined) with_sd.add(column); });
    });
    return rows.map(function (row) {
      const line = [];
      each_cell(row, function (cell, first) {
        const text = cell.dataset.v !== undefined ? cell.dataset.v : cell.textContent.trim().replace(/\s+/g, " ");
        for (let column = first; column < first + cell.colSpan; ++column) {
          line.push(column === first ? csv_cell(text) : "");
          if (with_sd.has(column)) line.push(cell.dataset.sd || (row.parentElement.tagName === "THEAD" ? csv_cell(text + ", sd") : ""));
        }
      });
      return line.join(",");
    }).join("\n") + "\n";
  }

  // The path drawn over a picture, in pixels of the recording.
  function path_csv(svg) {
    const path = svg.querySelector(".path"), d = path ? path.getAttribute("d") : "";
    return "x_px,y_px\n" + (d.match(/[ML][-\d.]+ [-\d.]+/g) || []).map(function (step) {
      const [x, y] = step.slice(1).split(" ").map(Number);
      return (x - 0.5).toFixed(1) + "," + (y - 0.5).toFixed(1);
    }).join("\n") + "\n";
  }

  function svg_text(svg) {
    const copy = svg.cloneNode(true), style = document.createElementNS("http://www.w3.org/2000/svg", "style");
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    style.textContent = ".halo,.path{fill:none;vector-effect:non-scaling-stroke}.halo{stroke:#fff;stroke-width:3.4px;stroke-opacity:.75}" +
      ".path{stroke:#d55e00;stroke-width:1.5px}.start{fill:#fff;stroke:#d55e00}.end{fill:#d55e00;stroke:#fff}";
    copy.prepend(style);
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + new XMLSerializer().serializeToString(copy);
  }

  // A .zip of texts, stored as they are (PKWARE's APPNOTE 6.3: local headers, directory, end).
  function zip_of(files) {
    const table = Array.from({ length: 256 }, function (v, n) {
      for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
      return n >>> 0;
    });
    const numbers = function (fields) {  // [value, bytes]..., the lowest byte first
      return Uint8Array.from(fields.flatMap(function (field) {
        return Array.from({ length: field[1] }, function (v, k) { return (field[0] >>> (8 * k)) & 255; });
      }));
    };
    const parts = [], directory = [];
    let at = 0;
    files.forEach(function (file) {
      const name = new TextEncoder().encode(file[0]), bytes = new TextEncoder().encode(file[1]);
      const crc = (bytes.reduce(function (c, b) { return table[(c ^ b) & 255] ^ (c >>> 8); }, -1) ^ -1) >>> 0;
      const head = [[20, 2], [0x800, 2], [0, 2], [0, 2], [0x21, 2], [crc, 4], [bytes.length, 4], [bytes.length, 4], [name.length, 2], [0, 2]];
      parts.push(numbers([[0x04034b50, 4], ...head]), name, bytes);
      directory.push(numbers([[0x02014b50, 4], [20, 2], ...head, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]]), name);
      at += 30 + name.length + bytes.length;
    });
    const length = directory.reduce(function (sum, part) { return sum + part.length; }, 0);
    const end = numbers([[0x06054b50, 4], [0, 2], [0, 2], [files.length, 2], [files.length, 2], [length, 4], [at, 4], [0, 2]]);
    return new Blob([...parts, ...directory, end], { type: "application/zip" });
  }

  // Every figure as SVG and CSV, every table as CSV.
  function everything() {
    const tables = Array.from(document.querySelectorAll("table[id]"), function (table) { return [table.id + ".csv", table_csv(table)]; });
    const ids = TribotrackFigures.ids();
    const numbers = ids.map(function (id) { return [id + ".csv", TribotrackFigures.csv_of(id)]; });
    return Promise.all(ids.map(function (id) { return TribotrackFigures.svg_of(id); })).then(function (texts) {
      return zip_of([...tables, ...numbers, ...texts.map(function (text, k) { return [ids[k] + ".svg", text]; })]);
    });
  }
  const all = document.createElement("button");
  all.type = "button";
  all.id = "download-all";
  all.textContent = "Download all figures and tables";
  all.addEventListener("click", function () { everything().then(function (zip) { save("all.zip", "application/zip", zip); }); });
  document.querySelector("h1").before(all);

  function tools(what, actions) {
    const bar = document.createElement("div");
    bar.className = "tools";
    actions.forEach(function (action) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = action[0];
      button.setAttribute("aria-label", action[0] + " of " + what);
      button.addEventListener("click", action[1]);
      bar.append(button);
    });
    return bar;
  }

  function title_of(element) {
    const title = element.querySelector("figcaption b, caption");
    return title ? title.textContent.replace(/[.\s]+$/, "") : element.id || "table";
  }

  document.querySelectorAll("figure.plot").forEach(function (figure) {
    const id = figure.querySelector(".box").id.slice(5);
    figure.append(tools(title_of(figure), [
      ["CSV", function () { save(id + ".csv", "text/csv", TribotrackFigures.csv_of(id)); }],
      ["SVG", function () {
        TribotrackFigures.svg_of(id).then(function (svg) { save(id + ".svg", "image/svg+xml", svg); });
      }]]));
  });

  document.querySelectorAll("figure.frame").forEach(function (figure) {
    const svg = figure.querySelector("svg"), name = figure.id;
    figure.append(tools("the picture of " + title_of(figure), [
      ["CSV", function () { save(name + ".csv", "text/csv", path_csv(svg)); }],
      ["SVG", function () { save(name + ".svg", "image/svg+xml", svg_text(svg)); }]]));
    const enlarge = function () { figure.classList.toggle("big"); };
    svg.addEventListener("click", enlarge);
    const bar = figure.querySelector(".tools"), button = document.createElement("button");
    button.type = "button";
    button.textContent = "Larger";
    button.setAttribute("aria-label", "Larger or smaller: " + title_of(figure));
    button.addEventListener("click", enlarge);
    bar.append(button);
  });

  document.querySelectorAll("table[id]").forEach(function (table) {
    const name = table.id, holder = table.closest(".wide") || table;
    holder.after(tools("table " + name, [
      ["CSV", function () { save(name + ".csv", "text/csv", table_csv(table)); }]]));
  });

  // A table's rows in the order of a column: by its numbers where it has them.
  document.querySelectorAll("table.sortable").forEach(function (table) {
    Array.from(table.tHead.rows[0].cells).forEach(function (head, column) {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", function () {
        const up = head.getAttribute("aria-sort") !== "ascending";
        const key = function (row) {
          const cell = row.cells[column], text = cell ? (cell.dataset.v || cell.textContent) : "";
          const number = parseFloat(text.replace("−", "-"));
          return isNaN(number) ? text : number;
        };
        const rows = Array.from(table.tBodies[0].rows);
        rows.sort(function (a, b) {
          const x = key(a), y = key(b);
          const order = typeof x === "number" && typeof y === "number" ? x - y : String(x).localeCompare(String(y));
          return up ? order : -order;
        });
        table.tBodies[0].append(...rows);
        Array.from(table.tHead.rows[0].cells).forEach(function (other) { other.removeAttribute("aria-sort"); });
        head.setAttribute("aria-sort", up ? "ascending" : "descending");
      });
    });
  });

  // Boxes that scroll take the keyboard only where there is something to scroll.
  function settle_scrolling() {
    document.querySelectorAll(".wide").forEach(function (wide) {
      if (wide.scrollWidth > wide.clientWidth) {
        wide.tabIndex = 0;
        wide.setAttribute("role", "region");
        wide.setAttribute("aria-label", "table, scrolls sideways");
      } else {
        wide.removeAttribute("tabindex");
        wide.removeAttribute("role");
        wide.removeAttribute("aria-label");
      }
    });
  }
  settle_scrolling();
  addEventListener("resize", settle_scrolling);

  function open_all() { document.querySelectorAll("details").forEach(function (d) { d.open = true; }); }
  if (location.hash === "#all") open_all();
  // A link into something folded opens it.
  function open_target() {
    const target = location.hash.length > 1 && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    for (let part = target || null; part; part = part.parentElement) if (part.tagName === "DETAILS") part.open = true;
    if (target) target.scrollIntoView();
  }
  addEventListener("hashchange", open_target);

  const opened_for_print = [];
  addEventListener("beforeprint", function () {
    document.querySelectorAll("details.print:not([open])").forEach(function (d) { d.open = true; opened_for_print.push(d); });
    TribotrackFigures.for_print(true);
  });
  addEventListener("afterprint", function () {
    opened_for_print.splice(0).forEach(function (d) { d.open = false; });
    TribotrackFigures.for_print(false);
  });

  TribotrackFigures.start();
  open_target();
})();
