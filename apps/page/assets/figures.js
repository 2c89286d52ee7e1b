// Draws the figures (apps/figures/figure.h) in #figures, which come as traces and layout of plotly.js. Nothing is added here
// but what depends on the screen: places of panels, how many ticks fit, colours of a dark theme.
"use strict";
const TribotrackFigures = (function () {
  const LIGHT = { ink: "#1a1a1a", soft: "#666666", grid: "#e6e6e6", paper: "#ffffff" };
  const DARK = {  // what stands for these, and for other colours of the figures; the same hues, lighter
    "#1a1a1a": "#e8e8e8", "#666666": "#a5a5a5", "#e6e6e6": "#3a3d42", "#ffffff": "#1b1d21", "#ededed": "#2a2d33",
    "#0072b2": "#4aa3df", "#7f7f7f": "#a8a8a8", "#8a5f00": "#c9a04a"
  };
  const NARROW = 600;  // px, of a figure
  const CONFIG = { responsive: false, displayModeBar: false, doubleClick: "reset", showTips: false, plotlyServerURL: "" };
  const dark_screen = matchMedia("(prefers-color-scheme: dark)");

  const figures = new Map(JSON.parse(document.getElementById("figures").textContent)
    .map(function (figure) { return [figure.id, figure]; }));

  function box_of(id) { return document.getElementById("plot-" + id); }

  // What plotly takes, in the colours of the screen.
  function in_theme(made) {
    if (!dark_screen.matches || printing) return made;
    return JSON.parse(JSON.stringify(made).replace(/#[0-9a-f]{6}/g, function (colour) { return DARK[colour] || colour; }));
  }

  function mark_of(trace) {
    if (trace.fill) return "band";
    return { lines: "line", markers: "points", text: "text" }[trace.mode];
  }

  // Traces of panel i.
  function traces_of(figure, i) { return figure.data.filter(function (trace) { return trace.xaxis === "x" + number_of(i); }); }
  function number_of(i) { return i === 0 ? "" : String(i + 1); }
  function x_of(figure, i) { return figure.layout["xaxis" + number_of(i)]; }
  function y_of(figure, i) { return figure.layout["yaxis" + number_of(i)]; }

  // A band as closed outlines, one for each stretch without a gap; its upper edge comes as customdata.
  function outline(band) {
    const x = [], y = [];
    let begin = 0;
    const close = function (end) {
      if (end - begin > 1) {
        for (let i = begin; i < end; ++i) { x.push(band.x[i]); y.push(band.y[i]); }
        for (let i = end - 1; i >= begin; --i) { x.push(band.x[i]); y.push(band.customdata[i]); }
        x.push(null); y.push(null);
      }
      begin = end + 1;
    };
    for (let i = 0; i < band.x.length; ++i)
      if (band.x[i] === null || band.y[i] === null || band.customdata[i] === null) close(i);
    close(band.x.length);
    return { x: x, y: y, customdata: undefined };
  }

  function as_drawn(trace) {
    if (trace.fill) return Object.assign({}, trace, outline(trace));
    return trace.error_y ? Object.assign({ customdata: trace.error_y.array }, trace) : trace;
  }

  function axis_of(axis) {
    const look = Object.assign({
      showline: true, linecolor: LIGHT.soft, mirror: true, ticks: "outside", ticklen: 4, tickcolor: LIGHT.soft,
      gridcolor: LIGHT.grid, zeroline: false, zerolinecolor: LIGHT.soft, zerolinewidth: 1, exponentformat: "power", minexponent: 4
    }, axis);
    look.title = { text: axis.showticklabels === false ? "" : axis.title.text, standoff: 6 };
    if (axis.type === "log") look.dtick = 1;
    if (axis.tickvals) look.tickangle = 0;
    return look;
  }

  // How many characters the numbers along an axis take.
  function label_length(axis) {
    if (axis.ticktext) return axis.ticktext.reduce(function (n, label) { return Math.max(n, label.length); }, 1);
    if (axis.type === "log") return 7;  // large digits and a raised exponent
    const [low, high] = axis.range, step = (high - low) / 8, most = Math.max(Math.abs(low), Math.abs(high));
    const whole = Math.max(1, Math.ceil(Math.log10(most + 1e-300))), behind = Math.max(0, Math.ceil(-Math.log10(step)));
    return most >= 1e5 || behind > 9 ? 7 : whole + (behind ? behind + 1 : 0) + (low < 0 ? 1 : 0);
  }

  // A title in lines that fit beside an axis of this length, px: whole, in two, or its symbol and unit alone.
  function fitted_title(text, length) {
    const most = Math.max(3, Math.floor(length / (printing ? 5.6 : 6.2)));
    if (text.length <= most) return text;
    const blanks = Array.from(text.matchAll(/ /g), function (blank) { return blank.index; });
    const middle = blanks.sort(function (a, b) { return Math.abs(a - text.length / 2) - Math.abs(b - text.length / 2); })[0];
    if (middle && Math.max(middle, text.length - middle - 1) <= most) return text.slice(0, middle) + "<br>" + text.slice(middle + 1);
    return text.split(" ").slice(-2).join(" ");
  }

  // Where each panel lies in a box of this size, px.
  function cells_of(figure, width, height) {
    const columns = figure.columns;
    const rows = Math.ceil(figure.panels.length / columns), row_of = function (i) { return Math.floor(i / columns); };
    const weight = Array(rows).fill(0);
    figure.panels.forEach(function (p, i) { weight[row_of(i)] = Math.max(weight[row_of(i)], p.height); });
    const room = function (r) {  // above and below the axes of a row
      const places = figure.panels.map(function (p, i) { return i; }).filter(function (i) { return row_of(i) === r && x_of(figure, i); });
      return { above: places.some(function (i) { return figure.panels[i].title; }) ? 26 : 9,
               below: places.some(function (i) { return x_of(figure, i).showticklabels !== false; }) ? (printing ? 36 : 46) : 7 };
    };
    const rooms = weight.map(function (w, r) { return room(r); });
    const used = rooms.reduce(function (sum, r) { return sum + r.above + r.below; }, 0);
    const unit = (height - used) / weight.reduce(function (a, b) { return a + b; }, 0);
    const lines_of = function (axis, i) { return fitted_title(axis.title.text, weight[row_of(i)] * unit).split("<br>").length; };
    const left = function (c) {  // of the axes of a column
      return figure.panels.reduce(function (room, p, i) {
        const axis = y_of(figure, i);
        if (i % columns !== c || !axis || axis.showticklabels === false) return room;
        return Math.max(room, Math.min(0.4 * width, (lines_of(axis, i) > 1 ? 50 : 34) + 6.7 * label_length(axis)));
      }, 12);
    };
    const lefts = Array.from({ length: columns }, function (v, c) { return left(c); }), right = 12;
    const wide = (width - lefts.reduce(function (a, b) { return a + b; }, 0) - right * columns) / columns;
    const tops = [];
    let y = 0;
    weight.forEach(function (w, r) { tops.push(y + rooms[r].above); y += rooms[r].above + w * unit + rooms[r].below; });
    return figure.panels.map(function (p, i) {
      const c = i % columns, r = row_of(i);
      const x0 = lefts.slice(0, c + 1).reduce(function (a, b) { return a + b; }, 0) + c * (wide + right);
      return { x: [x0 / width, (x0 + wide) / width], y: [1 - (tops[r] + weight[r] * unit) / height, 1 - tops[r] / height] };
    });
  }

  // On narrow screens panels that stand side by side go below each other; a corner picture, which has empty places, does not.
  function stacks(figure, width) {
    return width < NARROW && !printing && figure.columns > 1 && !figure.shared_x &&
      figure.panels.every(function (panel, i) { return x_of(figure, i); });
  }

  function stacked(figure) {
    const layout = Object.assign({}, figure.layout);
    figure.panels.forEach(function (panel, i) {
      layout["yaxis" + number_of(i)] = Object.assign({}, y_of(figure, i), { showticklabels: true });
    });
    return Object.assign({}, figure, { columns: 1, layout: layout });
  }

  function picture(shown, width, height, legend) {
    const figure = stacks(shown, width) ? stacked(shown) : shown;
    const narrow = width < NARROW;
    const bar = figure.data.some(function (trace) { return trace.marker && trace.marker.showscale; });
    const below = bar ? 62 : legend ? 40 : 0, area = height - below;
    const cells = cells_of(figure, width, area);
    const layout = {
      width: width, height: height, margin: { l: 0, r: 0, t: 0, b: below, pad: 0 }, hovermode: "closest",
      font: { family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: printing ? 9.5 : narrow ? 11 : 12.5, color: LIGHT.ink },
      paper_bgcolor: LIGHT.paper, plot_bgcolor: LIGHT.paper, shapes: figure.layout.shapes, annotations: [], showlegend: legend,
      legend: { orientation: "h", x: 0, y: 0, yref: "container", yanchor: "bottom", font: { size: 11.5 } },
      hoverlabel: { font: { size: 12 } }, barmode: "overlay", dragmode: "zoom"
    };
    figure.panels.forEach(function (panel, i) {
      if (!x_of(figure, i)) return;
      const cell = cells[i], x = axis_of(x_of(figure, i)), y = axis_of(y_of(figure, i));
      x.domain = cell.x;
      y.domain = cell.y;
      const room = Math.floor((cell.x[1] - cell.x[0]) * width / (7 * label_length(x) + 14));  // labels side by side
      if (x.tickvals && x.tickvals.length > room) {
        const every = Math.ceil(x.tickvals.length / Math.max(1, room)), kept = function (v, k) { return k % every === 0; };
        x.tickvals = x.tickvals.filter(kept);
        x.ticktext = x.ticktext.filter(kept);
      }
      if (!x.tickvals && x.type !== "log") Object.assign(x, { nticks: Math.max(1, Math.min(8, room)), tickangle: 0 });
      y.title.text = fitted_title(y.title.text, (cell.y[1] - cell.y[0]) * area);
      if (!y.tickvals && y.type !== "log") y.nticks = Math.max(3, Math.round((cell.y[1] - cell.y[0]) * area / 34));
      layout["xaxis" + number_of(i)] = x;
      layout["yaxis" + number_of(i)] = y;
      if (panel.title)
        layout.annotations.push({ text: panel.title, showarrow: false, xref: "paper", yref: "paper", x: cell.x[0], y: cell.y[1],
                                  xanchor: "left", yanchor: "bottom", font: { size: printing ? 10 : 12.5 } });
    });
    return { data: figure.data.map(as_drawn), layout: layout };
  }

  function height_of(figure, width) {
    const below = stacks(figure, width) ? 0.8 * figure.columns : 1, lowest = width < NARROW ? 300 : 200;
    if (printing) return Math.round(Math.max(130, width * figure.height * (width > 360 ? 0.78 : 0.9)));
    return Math.round(Math.max(lowest, width * figure.height * (width < NARROW ? 1.25 : 1) * below));
  }

  // Legends are buttons beside the figure: they wrap on narrow screens and answer to the keyboard.
  function add_legend(box, data) {
    const names = new Map();
    data.forEach(function (trace) { if (trace.showlegend && trace.name && !names.has(trace.name)) names.set(trace.name, trace); });
    const known = box.nextElementSibling;
    if (known.classList.contains("legend")) {  // in the colours of the screen, or of paper
      Array.from(names.values()).forEach(function (trace, k) {
        if (known.children[k]) known.children[k].firstChild.style.color = (trace.line || trace.marker).color;
      });
      return;
    }
    if (names.size < 1) return;
    const legend = document.createElement("div");
    legend.className = "legend";
    names.forEach(function (trace, name) {
      const entry = document.createElement("button"), swatch = document.createElement("span");
      entry.type = "button";
      entry.setAttribute("aria-pressed", "true");
      entry.title = "hide or show";
      const look = trace.line || trace.marker;
      swatch.className = "swatch " + mark_of(trace) + (look.dash === "dash" ? " dashed" : "");
      swatch.style.color = look.color;
      swatch.dataset.ink = look.color === LIGHT.ink || look.color === DARK[LIGHT.ink] ? "yes" : "";
      entry.append(swatch, name);
      entry.addEventListener("click", function () {
        const shown = entry.getAttribute("aria-pressed") !== "true", places = [];
        entry.setAttribute("aria-pressed", String(shown));
        box.data.forEach(function (trace, k) { if (trace.legendgroup === name) places.push(k); });
        Plotly.restyle(box, { visible: shown }, places);
      });
      legend.append(entry);
    });
    box.after(legend);
  }

  function zoom(box, factor, shift_x, shift_y) {
    const change = {};
    Object.keys(box.layout).forEach(function (key) {
      if (!/^[xy]axis\d*$/.test(key) || box.layout[key].matches) return;
      const range = box._fullLayout[key].range, middle = (range[0] + range[1]) / 2, half = factor * (range[1] - range[0]) / 2;
      const by = (key[0] === "x" ? shift_x : shift_y) * (range[1] - range[0]);
      change[key + ".range"] = [middle - half + by, middle + half + by];
    });
    Plotly.relayout(box, change);
  }

  const KEYS = { "+": [0.7, 0, 0], "=": [0.7, 0, 0], "-": [1 / 0.7, 0, 0], ArrowLeft: [1, -0.15, 0], ArrowRight: [1, 0.15, 0],
                 ArrowUp: [1, 0, 0.15], ArrowDown: [1, 0, -0.15] };

  function on_key(event) {
    const box = event.currentTarget, id = box.id.slice(5);
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "0") draw(id);
    else if (KEYS[event.key]) zoom(box, ...KEYS[event.key]);
    else return;
    event.preventDefault();
  }

  let drawn = 0;
  const seen = new Set();
  let printing = false;

  // An A4 sheet without its margins is 695 px wide.
  function width_on_paper(id) {
    const box = box_of(id);
    return box.closest(".pair") ? 338 : box.closest(".first") ? 285 : Math.round(695 * Math.min(1, figures.get(id).width || 1));
  }

  // Draws or redraws; `width`: of a sheet of paper instead of the screen.
  function draw(id, width) {
    const figure = figures.get(id), box = box_of(id);
    if (!figure || !box) return;
    const wide = width || box.clientWidth;
    if (!wide) return;
    const made = in_theme(picture(figure, wide, height_of(figure, wide), false));
    box.style.height = made.layout.height + "px";
    box.style.width = width ? width + "px" : "";
    Plotly.react(box, made.data, made.layout, CONFIG);
    add_legend(box, made.data);
    if (seen.has(id)) return;
    seen.add(id);
    box.addEventListener("keydown", on_key);
    const noted = document.documentElement.dataset;
    noted.drawn = String(++drawn);
    if (drawn === 1) noted.firstAfterMs = performance.now().toFixed(0);
    noted.lastAfterMs = performance.now().toFixed(0);
  }

  function redraw_all() { seen.forEach(function (id) { draw(id, printing ? width_on_paper(id) : 0); }); }

  function in_closed_details(box) {
    const details = box.parentElement.closest("details:not([open])");
    return Boolean(details);
  }

  // Those in view at once, the others when the browser has nothing better to do, those folded away when they are opened.
  function start() {
    const boxes = Array.from(document.querySelectorAll(".box"));
    document.documentElement.dataset.figures = String(boxes.filter(function (b) { return !in_closed_details(b); }).length);
    const waiting = new Set(boxes);
    const show = function (box) {
      if (in_closed_details(box)) return;
      waiting.delete(box);
      draw(box.id.slice(5));
    };
    boxes.filter(function (box) { return box.getBoundingClientRect().top < innerHeight; }).forEach(show);
    const later = window.requestIdleCallback || function (work) { return setTimeout(work, 1); };
    const next = function () {
      const box = Array.from(waiting).find(function (b) { return !in_closed_details(b); });
      if (!box) return;
      show(box);
      later(next);
    };
    later(next);
    document.addEventListener("toggle", function (event) {
      if (!event.target.open) return;
      event.target.querySelectorAll(".box").forEach(function (box) { if (waiting.has(box)) show(box); });
    }, true);
    let timer = 0;
    addEventListener("resize", function () { clearTimeout(timer); timer = setTimeout(function () { redraw_all(); }, 120); });
    dark_screen.addEventListener("change", function () { redraw_all(); });
  }

  // On paper: light, as wide as the sheet.
  function for_print(on) {
    printing = on;
    if (on) document.querySelectorAll(".box").forEach(function (box) { if (!in_closed_details(box)) draw(box.id.slice(5)); });
    redraw_all();
  }

  function csv_of(id) {
    const figure = figures.get(id), cell = function (v) {
      if (v === null || v === undefined) return "";
      const text = String(v);
      return /[",\n]/.test(text) ? '"' + text.replace(/"/g, '""') + '"' : text;
    };
    let csv = "panel,series,mark,name,x,y,sd,y_high,note\n";
    figure.panels.forEach(function (panel, p) {
      traces_of(figure, p).forEach(function (t, k) {
        t.x.forEach(function (x, i) {
          csv += [p + 1, k + 1, mark_of(t), t.name, x, t.y[i], t.error_y && t.error_y.array[i], t.customdata && t.customdata[i],
                  t.text && t.text[i]].map(cell).join(",") + "\n";
        });
      });
    });
    return csv;
  }

  // Light, with its legend, whatever the screen shows; a promise of the text.
  function svg_of(id) {
    const figure = figures.get(id), width = 900, made = picture(figure, width, height_of(figure, width) + 40, true);
    return Plotly.toImage(made,
                          { format: "svg", width: width, height: made.layout.height, imageDataOnly: true });
  }

  return { start: start, draw: draw, ids: function () { return Array.from(figures.keys()); }, csv_of: csv_of, svg_of: svg_of, for_print: for_print };
})();
