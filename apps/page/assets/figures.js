// Draws figures (apps/figures/figure.h) from their numbers in #figures with plotly.js. Nothing is computed here but places
// on the screen; results, ranges and ticks come with the figure.
"use strict";
const TribotrackFigures = (function () {
  // Okabe and Ito's colours, distinct to colour-blind eyes; symbols and dashes carry the same without colour.
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#8a5f00"];
  const ON_DARK = { "#0072b2": "#4aa3df", "#7f7f7f": "#a8a8a8", "#8a5f00": "#c9a04a" };  // of the same hues, lighter
  const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "x", "cross", "star", "hexagon"];
  const RAMP = [[0, "#00224e"], [0.25, "#35456c"], [0.5, "#7c7b78"], [0.75, "#bcaf6f"], [1, "#fee838"]];  // cividis
  const LIGHT = { ink: "#1a1a1a", soft: "#666666", grid: "#e6e6e6", paper: "#ffffff", stripe: "#ededed" };
  const DARK = { ink: "#e8e8e8", soft: "#a5a5a5", grid: "#3a3d42", paper: "#1b1d21", stripe: "#2a2d33" };
  const NARROW = 600;  // px, of a figure
  const CONFIG = { responsive: false, displayModeBar: false, doubleClick: "reset", showTips: false, plotlyServerURL: "" };
  const dark_screen = matchMedia("(prefers-color-scheme: dark)");

  const figures = new Map(JSON.parse(document.getElementById("figures").textContent)
    .map(function (figure) { return [figure.id, figure]; }));

  function box_of(id) { return document.getElementById("plot-" + id); }

  function on_ramp(share) {
    const t = Math.min(1, Math.max(0, share));
    let k = 1;
    while (k < RAMP.length - 1 && RAMP[k][0] < t) ++k;
    const [a, from] = RAMP[k - 1], [b, to] = RAMP[k], s = (t - a) / (b - a);
    return "rgb(" + [1, 3, 5].map(function (at) {
      const low = parseInt(from.substr(at, 2), 16), high = parseInt(to.substr(at, 2), 16);
      return Math.round(low + s * (high - low));
    }).join(",") + ")";
  }

  function colour_of(series, figure, theme) {
    if ("value" in series) {
      const scale = figure.colours;
      return on_ramp(series.value === null || !scale ? 0 : (series.value - scale.low) / (scale.high - scale.low || 1));
    }
    if (series.colour === -1) return theme.ink;
    if (series.colour === -2) return theme.soft;
    const colour = COLOURS[series.colour % COLOURS.length];
    return theme === DARK && ON_DARK[colour] || colour;
  }

  function faded(colour, share) {
    const parts = colour[0] === "#" ? [1, 3, 5].map(function (at) { return parseInt(colour.substr(at, 2), 16); })
                                    : colour.match(/\d+/g);
    return "rgba(" + parts.join(",") + "," + share + ")";
  }

  // A band as closed outlines, one for each stretch without a gap.
  function outline(series) {
    const x = [], y = [];
    let begin = 0;
    const close = function (end) {
      if (end - begin > 1) {
        for (let i = begin; i < end; ++i) { x.push(series.x[i]); y.push(series.y[i]); }
        for (let i = end - 1; i >= begin; --i) { x.push(series.x[i]); y.push(series.y_high[i]); }
        x.push(null); y.push(null);
      }
      begin = end + 1;
    };
    for (let i = 0; i < series.x.length; ++i)
      if (series.x[i] === null || series.y[i] === null || series.y_high[i] === null) close(i);
    close(series.x.length);
    return { x: x, y: y };
  }

  function trace_of(series, figure, panel_index, theme) {
    const n = panel_index === 0 ? "" : String(panel_index + 1);
    const colour = colour_of(series, figure, theme), marked = series.name || "";
    const trace = { xaxis: "x" + n, yaxis: "y" + n, name: marked, legendgroup: marked || undefined,
                    showlegend: Boolean(series.in_legend), x: series.x, y: series.y, connectgaps: false };
    const symbol = series.colour >= 0 ? SYMBOLS[series.colour % SYMBOLS.length] : "circle";
    if (series.mark === "line") {
      const width = "value" in series || series.small ? 1.1 : 1.9;
      return Object.assign(trace, { mode: "lines", hovertemplate: (marked ? marked + "<br>" : "") + "%{x:.5g}, %{y:.5g}<extra></extra>",
        line: { color: colour, width: width, simplify: false, dash: series.dashed ? "dash" : "solid" } });
    }
    if (series.mark === "band")
      return Object.assign(trace, outline(series), { mode: "lines", fill: "toself", fillcolor: faded(colour, 0.22),
                                                      line: { width: 0, color: colour }, hoverinfo: "skip" });
    if (series.mark === "bars")
      return Object.assign(trace, { type: "bar", orientation: "h", width: 0.62, marker: { color: colour },
        text: series.notes, hovertemplate: "%{text}<br>%{x:.4g}<extra></extra>", textposition: "none" });
    if (series.mark === "text")
      return Object.assign(trace, { mode: "text", text: series.notes.map(function (t) { return "<b>" + t + "</b>"; }),
                                    textfont: { color: colour, size: 12 }, hoverinfo: "skip", cliponaxis: false });
    const many = "value" in series;
    Object.assign(trace, { mode: "markers", text: series.notes, customdata: series.sd,
      marker: { color: colour, symbol: symbol, size: series.small ? 3 : many ? 5 : series.large ? 11 : 7.5,
                line: { color: theme.paper, width: series.small || many ? 0 : 0.8 } },
      hovertemplate: (series.notes ? "%{text}<br>" : marked ? marked + "<br>" : "") + "%{x:.5g}, %{y:.5g}" +
        (series.sd ? " ± %{customdata:.2g}" : "") + "<extra></extra>" });
    if (series.sd)
      trace.error_y = { type: "data", array: series.sd.map(function (s) { return s || 0; }), color: colour,
                        thickness: series.small ? 0.7 : 1.3, width: series.small ? 0 : 3 };
    return trace;
  }

  function axis_of(axis, theme) {
    const look = {
      showline: true, linecolor: theme.soft, mirror: true, ticks: "outside", ticklen: 4, tickcolor: theme.soft,
      gridcolor: theme.grid, zeroline: false, exponentformat: "power", minexponent: 4,
      showticklabels: !axis.hidden, title: { text: axis.hidden ? "" : axis.title, standoff: 6 }
    };
    if (axis.log)
      Object.assign(look, { type: "log", dtick: 1, exponentformat: "power", range: [Math.log10(axis.low), Math.log10(axis.high)] });
    else
      look.range = [axis.low, axis.high];
    if (axis.ticks) Object.assign(look, { tickmode: "array", tickvals: axis.ticks, ticktext: axis.labels, tickangle: 0 });
    return look;
  }

  // How many characters the numbers along an axis take.
  function label_length(axis) {
    if (axis.labels) return axis.labels.reduce(function (n, label) { return Math.max(n, label.length); }, 1);
    if (axis.log) return 4;
    const step = (axis.high - axis.low) / 8, most = Math.max(Math.abs(axis.low), Math.abs(axis.high));
    const whole = Math.max(1, Math.ceil(Math.log10(most + 1e-300))), behind = Math.max(0, Math.ceil(-Math.log10(step)));
    return most >= 1e5 || behind > 9 ? 7 : whole + (behind ? behind + 1 : 0) + (axis.low < 0 ? 1 : 0);
  }

  // Where each panel lies in a box of this size, px.
  function cells_of(figure, width, height) {
    const columns = figure.columns;
    const rows = Math.ceil(figure.panels.length / columns), row_of = function (i) { return Math.floor(i / columns); };
    const weight = Array(rows).fill(0);
    figure.panels.forEach(function (p, i) { weight[row_of(i)] = Math.max(weight[row_of(i)], p.height || 1); });
    const room = function (r) {  // above and below the axes of a row
      const panels = figure.panels.filter(function (p, i) { return row_of(i) === r && p.series.length; });
      return { above: panels.some(function (p) { return p.title; }) ? 26 : 9,
               below: panels.some(function (p) { return !p.x.hidden; }) ? (printing ? 36 : 46) : 7 };
    };
    const rooms = weight.map(function (w, r) { return room(r); });
    const used = rooms.reduce(function (sum, r) { return sum + r.above + r.below; }, 0);
    const unit = (height - used) / weight.reduce(function (a, b) { return a + b; }, 0);
    const left = function (c) {  // of the axes of a column
      return figure.panels.reduce(function (room, p, i) {
        if (i % columns !== c || !p.series.length || p.y.hidden) return room;
        return Math.max(room, Math.min(0.4 * width, 34 + 6.7 * label_length(p.y)));
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
      return { x0: x0 / width, x1: (x0 + wide) / width,
               y0: 1 - (tops[r] + weight[r] * unit) / height, y1: 1 - tops[r] / height, row: r, column: c };
    });
  }

  // On narrow screens panels that stand side by side go below each other; a corner picture, which has empty places, does not.
  function stacks(figure, width) {
    return width < NARROW && !printing && figure.columns > 1 && !figure.shared_x &&
      figure.panels.every(function (panel) { return panel.series.length; });
  }

  function stacked(figure) {
    return Object.assign({}, figure, { columns: 1, panels: figure.panels.map(function (panel) {
      return Object.assign({}, panel, { y: Object.assign({}, panel.y, { hidden: false }) });
    }) });
  }

  function picture(shown, width, height, theme, legend) {
    const figure = stacks(shown, width) ? stacked(shown) : shown;
    const narrow = width < NARROW, traces = [];
    const below = figure.colours ? 62 : legend ? 40 : 0, area = height - below;
    const cells = cells_of(figure, width, area);
    const layout = {
      width: width, height: height, margin: { l: 0, r: 0, t: 0, b: below, pad: 0 }, hovermode: "closest",
      font: { family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: printing ? 9.5 : narrow ? 11 : 12.5, color: theme.ink },
      paper_bgcolor: theme.paper, plot_bgcolor: theme.paper, shapes: [], annotations: [], showlegend: legend,
      legend: { orientation: "h", x: 0, y: 0, yref: "container", yanchor: "bottom", font: { size: 11.5 } },
      hoverlabel: { font: { size: 12 } }, barmode: "overlay", dragmode: "zoom"
    };
    figure.panels.forEach(function (panel, i) {
      if (!panel.series.length) return;
      const n = i === 0 ? "" : String(i + 1), cell = cells[i];
      const x = axis_of(panel.x, theme), y = axis_of(panel.y, theme);
      Object.assign(x, { domain: [cell.x0, cell.x1], anchor: "y" + n });
      Object.assign(y, { domain: [cell.y0, cell.y1], anchor: "x" + n });
      const room = Math.floor((cell.x1 - cell.x0) * width / (7 * label_length(panel.x) + 14));  // labels side by side
      if (x.tickvals && x.tickvals.length > room) {
        const every = Math.ceil(x.tickvals.length / Math.max(1, room)), kept = function (v, k) { return k % every === 0; };
        x.tickvals = x.tickvals.filter(kept);
        x.ticktext = x.ticktext.filter(kept);
      }
      if (!x.tickvals && !panel.x.log) Object.assign(x, { nticks: Math.max(2, Math.min(8, room)), tickangle: 0 });
      if (!y.tickvals && !panel.y.log) y.nticks = Math.max(3, Math.round((cell.y1 - cell.y0) * area / 34));
      if (figure.shared_x) {
        const first = figure.panels.findIndex(function (p, k) { return p.series.length && cells[k].column === cell.column; });
        if (first !== i) x.matches = "x" + (first === 0 ? "" : first + 1);
      }
      if (panel.equal_scale) Object.assign(y, { scaleanchor: "x" + n, scaleratio: 1 });
      if (panel.zero_line) Object.assign(y, { zeroline: true, zerolinecolor: theme.soft, zerolinewidth: 1 });
      layout["xaxis" + n] = x;
      layout["yaxis" + n] = y;
      (panel.stripes || []).forEach(function (stripe) {
        layout.shapes.push({ type: "rect", layer: "below", xref: "x" + n + " domain", x0: 0, x1: 1, yref: "y" + n,
                             y0: stripe[0], y1: stripe[1], fillcolor: theme.stripe, line: { width: 0 } });
      });
      (panel.spans || []).forEach(function (span) {
        layout.shapes.push({ type: "rect", layer: "below", xref: "x" + n, x0: span[0], x1: span[1], yref: "y" + n + " domain",
                             y0: 0, y1: 1, fillcolor: faded("#d55e00", 0.18), line: { width: 0 } });
      });
      if (panel.title)
        layout.annotations.push({ text: panel.title, showarrow: false, xref: "paper", yref: "paper", x: cell.x0, y: cell.y1,
                                  xanchor: "left", yanchor: "bottom", font: { size: printing ? 10 : 12.5 } });
      panel.series.forEach(function (series) { traces.push(trace_of(series, figure, i, theme)); });
    });
    if (figure.colours) {
      const scale = figure.colours;
      traces.push({ x: [null], y: [null], mode: "markers", showlegend: false, hoverinfo: "skip",
        marker: { color: [scale.low], cmin: scale.low, cmax: scale.high, colorscale: RAMP, showscale: true,
          colorbar: { orientation: "h", title: { text: scale.title, side: "top", font: { size: 12 } }, thickness: 10, len: 0.8,
                      x: 0.5, y: 0, yanchor: "top", ypad: 6, outlinewidth: 0,
                      tickvals: scale.ticks, ticktext: scale.labels } } });
    }
    return { traces: traces, layout: layout };
  }

  function height_of(figure, width) {
    const below = stacks(figure, width) ? 0.8 * figure.columns : 1, lowest = width < NARROW ? 300 : 200;
    if (printing) return Math.round(Math.max(130, width * figure.height * (width > 360 ? 0.78 : 0.9)));
    return Math.round(Math.max(lowest, width * figure.height * (width < NARROW ? 1.25 : 1) * below));
  }

  // Legends are buttons beside the figure: they wrap on narrow screens and answer to the keyboard.
  function add_legend(box, figure, theme) {
    const names = new Map();
    figure.panels.forEach(function (panel) {
      panel.series.forEach(function (s) { if (s.in_legend && s.name && !names.has(s.name)) names.set(s.name, s); });
    });
    if (names.size < 1 || box.nextElementSibling.classList.contains("legend")) return;
    const legend = document.createElement("div");
    legend.className = "legend";
    names.forEach(function (series, name) {
      const entry = document.createElement("button"), swatch = document.createElement("span");
      entry.type = "button";
      entry.setAttribute("aria-pressed", "true");
      entry.title = "hide or show";
      swatch.className = "swatch " + series.mark + (series.dashed ? " dashed" : "");
      swatch.style.color = colour_of(series, figure, theme);
      swatch.dataset.ink = series.colour === -1 ? "yes" : "";
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
  function theme_now() { return dark_screen.matches && !printing ? DARK : LIGHT; }
  let printing = false;

  // An A4 sheet without its margins is 695 px wide.
  function width_on_paper(id) {
    const box = box_of(id);
    if (box.closest(".alone")) return 695;
    return box.closest(".pair") ? 338 : box.closest(".first") ? 285 : Math.round(695 * Math.min(1, figures.get(id).width || 1));
  }

  // Draws or redraws; `width`: of a sheet of paper instead of the screen.
  function draw(id, width) {
    const figure = figures.get(id), box = box_of(id);
    if (!figure || !box) return;
    const wide = width || box.clientWidth;
    if (!wide) return;
    const theme = theme_now(), made = picture(figure, wide, height_of(figure, wide), theme, false);
    box.style.height = made.layout.height + "px";
    box.style.width = width ? width + "px" : "";
    Plotly.react(box, made.traces, made.layout, CONFIG);
    if (seen.has(id)) return;
    seen.add(id);
    add_legend(box, figure, theme);
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
      panel.series.forEach(function (s, k) {
        s.x.forEach(function (x, i) {
          csv += [p + 1, k + 1, s.mark, s.name, x, s.y[i], s.sd && s.sd[i], s.y_high && s.y_high[i], s.notes && s.notes[i]]
            .map(cell).join(",") + "\n";
        });
      });
    });
    return csv;
  }

  // Light, with its legend, whatever the screen shows; a promise of the text.
  function svg_of(id) {
    const figure = figures.get(id), width = 900, made = picture(figure, width, height_of(figure, width) + 40, LIGHT, true);
    return Plotly.toImage({ data: made.traces, layout: made.layout },
                          { format: "svg", width: width, height: made.layout.height, imageDataOnly: true });
  }

  return { start: start, draw: draw, csv_of: csv_of, svg_of: svg_of, for_print: for_print };
})();
