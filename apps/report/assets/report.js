// Draws the report's figures from the numbers in #figures with plotly.js: layout only, no results are computed here.
"use strict";
(function () {
  const root = document.documentElement;
  const data = JSON.parse(document.getElementById("figures").textContent);

  // Okabe and Ito's colours, distinct to colour-blind eyes; symbols and dashes carry the same without colour.
  const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];
  const DARKER = ["#00436a", "#7d3700", "#005d44", "#8a3c66", "#8a5f00", "#1f6f9c", "#777777"];  // of the same hues
  const SYMBOLS = ["circle", "square", "diamond", "triangle-up", "x", "cross", "star"];
  const DASHES = ["solid", "dash", "dot", "dashdot"];
  const RAMP = [[0, "#00224e"], [0.25, "#35456c"], [0.5, "#7c7b78"], [0.75, "#bcaf6f"], [1, "#fee838"]];  // cividis
  const MOST_IN_LEGEND = 8;
  const NARROW = 600;  // px, of a figure: below it a legend beside it leaves no room
  const FONT = { family: 'system-ui, "Segoe UI", "DejaVu Sans", sans-serif', size: 13, color: "#1a1a1a" };
  const CONFIG = {
    responsive: true, displaylogo: false, plotlyServerURL: "", showTips: false,
    // Named one by one: plotly's own choice includes a button that sends the chart to its maker's server.
    modeBarButtons: [["zoom2d", "pan2d", "resetScale2d", "toImage"]],
    toImageButtonOptions: { format: "svg", filename: "tribotrack" }
  };

  function axis(title, more) {
    return Object.assign({
      title: { text: title, standoff: 8 }, showline: true, linecolor: "#666", mirror: true, ticks: "outside",
      tickcolor: "#666", gridcolor: "#e6e6e6", zeroline: false, automargin: true
    }, more);
  }

  function layout(more) {
    return Object.assign({
      font: FONT, paper_bgcolor: "#fff", plot_bgcolor: "#fff", margin: { l: 60, r: 14, t: 30, b: 48 },
      hovermode: "closest", hoverlabel: { font: { size: 12 } },
      legend: { orientation: "h", x: 0, y: 0, yref: "container", yanchor: "bottom", font: { size: 12 } }
    }, more);
  }

  function narrow(id) { return document.getElementById("plot-" + id).clientWidth < NARROW; }

  function on_ramp(share) {
    let k = 1;
    while (k < RAMP.length - 1 && RAMP[k][0] < share) ++k;
    const [a, from] = RAMP[k - 1], [b, to] = RAMP[k], t = (share - a) / (b - a);
    const part = function (colour, at) { return parseInt(colour.substr(at, 2), 16); };
    return "rgb(" + [1, 3, 5].map(function (at) {
      return Math.round(part(from, at) + t * (part(to, at) - part(from, at)));
    }).join(",") + ")";
  }

  let drawn = 0;
  function draw(id, traces, look) {
    const box = document.getElementById("plot-" + id);
    Plotly.newPlot(box, traces, look, CONFIG).then(function () { root.dataset.drawn = String(++drawn); });
  }

  // Ticks at multiples of pi -------------------------------------------------------------------------------
  function pi_label(k, n) {  // k pi / n
    if (k === 0) return "0";
    const gcd = function f(a, b) { return b ? f(b, a % b) : a; };
    const d = gcd(Math.abs(k), n), top = Math.abs(k) / d, bottom = n / d;
    return (k < 0 ? "−" : "") + (top === 1 ? "" : top) + "π" + (bottom === 1 ? "" : "/" + bottom);
  }

  // An axis over [low, high] in fractions of pi: thirds where the values lie on sixths but not on quarters.
  function pi_axis(title, low, high, values) {
    const on = function (n) {
      return values.every(function (v) { const k = v * n / Math.PI; return Math.abs(k - Math.round(k)) < 1e-3; });
    };
    const steps = !on(4) && on(6) ? [36, 18, 12, 6, 3, 1] : [48, 24, 12, 8, 4, 2, 1];
    const n = steps.find(function (s) { return (high - low) * s / Math.PI <= 8.5; }) || 1;
    const vals = [], text = [];
    for (let k = Math.ceil(low * n / Math.PI - 1e-9); k * Math.PI / n <= high + 1e-9; ++k) {
      vals.push(k * Math.PI / n);
      text.push(pi_label(k, n));
    }
    return axis(title, { range: [low, high], tickmode: "array", tickvals: vals, ticktext: text, tickangle: 0 });
  }

  // Lowest and highest of a list that may be empty or hold one value only.
  function span(values) {
    if (!values.length) return [0, 1];
    const low = Math.min(...values), high = Math.max(...values);
    return high > low ? [low, high] : [low, low + Math.max(Math.abs(low), 1e-3)];
  }

  function numbers(list) { return list.filter(function (v) { return v !== null; }); }

  // Figures 9a, 9b, 10 -------------------------------------------------------------------------------------
  function dependence(figure) {
    const traces = [], xs = [], ys = [], measured_x = [];
    const many = figure.groups.length > MOST_IN_LEGEND;  // then colour runs with the value that a group shares
    const shared = figure.groups.map(function (group) { return group.shared_rad; }), [first, last] = span(shared);
    figure.groups.forEach(function (group, i) {
      const colour = many ? on_ramp((group.shared_rad - first) / (last - first)) : COLOURS[i % COLOURS.length];
      const p = group.points, c = group.curve;
      const unit = figure.y_is_angle ? " rad" : " mm/s";
      traces.push({
        x: c.x, y: c.y, mode: "lines", name: group.label, legendgroup: "g" + i, showlegend: false, connectgaps: false,
        line: many ? { color: colour, width: 1 }
                   : { color: colour, width: 2, dash: DASHES[Math.floor(i / COLOURS.length) % DASHES.length] },
        hovertemplate: "model, " + group.label + "<br>%{y:.4g}" + unit + "<extra></extra>"
      });
      traces.push({
        x: p.x, y: p.y, mode: "markers", name: group.label, legendgroup: "g" + i, text: p.names, customdata: p.sd,
        showlegend: !many,
        marker: many ? { color: colour, size: 5 }
                     : { color: colour, size: 7.5, symbol: SYMBOLS[i % SYMBOLS.length], line: { color: "#fff", width: 1 } },
        error_y: { type: "data", array: p.sd.map(function (s) { return s === null ? 0 : s; }), color: colour,
                   thickness: 1.5, width: 5 },
        hovertemplate: "%{text}<br>%{y:.4g} ± %{customdata:.2g}" + unit + "<extra></extra>"
      });
      xs.push(...numbers(p.x), ...numbers(c.x));
      measured_x.push(...numbers(p.x));
      ys.push(...numbers(c.y));
      p.y.forEach(function (y, k) { if (y !== null) ys.push(y - (p.sd[k] || 0), y + (p.sd[k] || 0)); });
    });
    if (many) {
      const ticks = pi_axis("", first, last, []);
      traces.push({
        x: [null], y: [null], mode: "markers", showlegend: false, hoverinfo: "skip",
        marker: { color: [first], cmin: first, cmax: last, colorscale: RAMP, showscale: true,
                  colorbar: { title: { text: figure.shared_title }, thickness: 12, tickvals: ticks.tickvals,
                              ticktext: ticks.ticktext } }
      });
    }
    const [x_low, x_high] = span(xs), x_pad = 0.03 * (x_high - x_low);
    const [low, high] = span(ys);
    let y_axis;
    if (!figure.y_is_angle) {
      y_axis = axis(figure.y_title, { range: [Math.min(0, low), 1.08 * high] });
    } else if (high - low > Math.PI) {
      y_axis = pi_axis(figure.y_title, Math.min(low, -0.12), Math.max(high, 2 * Math.PI + 0.12), []);
    } else {
      const pad = Math.max(0.08 * (high - low), 0.1);
      y_axis = pi_axis(figure.y_title, low - pad, high + pad, []);
    }
    draw(figure.id, traces, layout({
      xaxis: pi_axis(figure.x_title, x_low - x_pad, x_high + x_pad, measured_x), yaxis: y_axis
    }));
  }

  // Figure 11 ----------------------------------------------------------------------------------------------
  function trajectories(paths) {
    const traces = [], ends = [], slim = narrow("trajectories");
    const spans = paths.map(function (p) { return span(numbers(p.x).concat(numbers(p.y))); });
    const size = Math.max(...spans.map(function (s) { return s[1]; })) - Math.min(...spans.map(function (s) { return s[0]; }));
    paths.forEach(function (path, i) {
      const colours = Math.floor(i / COLOURS.length) % 2 === 0 ? COLOURS : DARKER;
      const colour = colours[i % COLOURS.length];
      traces.push({
        x: path.x, y: path.y, mode: "lines", name: path.label, connectgaps: false,
        line: { color: colour, width: 1.4 },
        hovertemplate: path.label + "<br>x %{x:.3f} mm, y %{y:.3f} mm<extra></extra>"
      });
      for (let k = path.x.length - 1; k >= 0; --k) {
        if (path.x[k] === null || path.y[k] === null) continue;
        // Paths that end at the same place share a label.
        const same = ends.find(function (e) { return Math.hypot(e.x - path.x[k], e.y - path.y[k]) < 0.02 * size; });
        if (same) {
          same.text = same.text.replace("</b>", ", " + path.number + "</b>");
          break;
        }
        const length = Math.hypot(path.x[k], path.y[k]) || 1;
        ends.push({ x: path.x[k], y: path.y[k], xref: "x", yref: "y", text: "<b>" + path.number + "</b>", showarrow: false,
                    xshift: 22 * path.x[k] / length, yshift: 22 * path.y[k] / length, bgcolor: "rgba(255,255,255,0.8)",
                    borderpad: 0, font: { size: 12, color: colour } });
        break;
      }
    });
    draw("trajectories", traces, layout({
      xaxis: axis("x, mm", {}), yaxis: axis("y, mm", { scaleanchor: "x", scaleratio: 1 }), annotations: ends,
      showlegend: !slim, legend: { x: 1.01, y: 0.97, xanchor: "left", font: { size: 12 } }
    }));
  }

  // Residuals ----------------------------------------------------------------------------------------------
  function residuals(list) {
    const runs = [], by_observable = new Map();
    list.forEach(function (r) {
      if (!runs.includes(r.run)) runs.push(r.run);
      if (!by_observable.has(r.observable)) by_observable.set(r.observable, []);
      by_observable.get(r.observable).push(r);
    });
    const count = by_observable.size, traces = [];
    let i = 0;
    by_observable.forEach(function (rs, observable) {
      const shift = (i - (count - 1) / 2) * 0.16;  // beside each other, not on top
      traces.push({
        x: rs.map(function (r) { return runs.indexOf(r.run) + shift; }),
        y: rs.map(function (r) { return r.standardised; }), mode: "markers", name: observable.split(" (")[0],
        text: rs.map(function (r) { return r.run; }),
        customdata: rs.map(function (r) { return [r.measured, r.modelled, r.sd]; }),
        marker: { color: COLOURS[i % COLOURS.length], size: 9, symbol: SYMBOLS[i % SYMBOLS.length] },
        hovertemplate: "%{text}<br>" + observable + ": measured %{customdata[0]:.5g} ± %{customdata[2]:.2g}, model "
          + "%{customdata[1]:.5g}<br>%{y:.2f} standard deviations<extra></extra>"
      });
      ++i;
    });
    const by_number = runs.length > 24 || narrow("residuals");
    const step = Math.ceil(runs.length / 24);  // labels that fit side by side
    const labelled = runs.map(function (r, k) { return k; }).filter(function (k) { return k % step === 0; });
    const largest = Math.max(3, ...list.map(function (r) { return Math.abs(r.standardised || 0) * 1.1; }));
    draw("residuals", traces, layout({
      showlegend: true,
      xaxis: axis("", { range: [-0.6, runs.length - 0.4], tickmode: "array", tickvals: labelled,
                        ticktext: labelled.map(function (k) { return by_number ? runs[k].split(" ")[0] : runs[k]; }),
                        tickangle: by_number ? 0 : -40, showgrid: false }),
      yaxis: axis("residual / standard deviation", { range: [-largest, largest], zeroline: true, zerolinecolor: "#666" }),
      shapes: [
        { type: "rect", layer: "below", xref: "paper", x0: 0, x1: 1, y0: -2, y1: 2, fillcolor: "#e9e9e9", line: { width: 0 } }
      ]
    }));
  }

  // Free slides --------------------------------------------------------------------------------------------
  function slide(s, i) {
    const dots = { color: COLOURS[0], size: 5 };
    const sigma_um = s.sigma_mm.map(function (v) { return v === null ? 0 : 1000 * v; });
    draw("slide-" + i, [
      { x: s.time_s, y: s.position_mm, mode: "markers", name: "measured", marker: dots,
        hovertemplate: "%{x:.4f} s: %{y:.3f} mm<extra></extra>" },
      { x: s.time_s, y: s.fitted_mm, mode: "lines", name: "fitted", line: { color: COLOURS[1], width: 2 },
        hovertemplate: "fitted %{y:.3f} mm<extra></extra>" },
      { x: s.time_s, y: s.residual_um, mode: "markers", name: "measured − fitted", yaxis: "y2", marker: dots, showlegend: false,
        error_y: { type: "data", array: sigma_um, color: COLOURS[0], thickness: 1, width: 0 },
        hovertemplate: "%{x:.4f} s: %{y:.1f} µm<extra></extra>" }
    ], layout({
      xaxis: axis("time, s", { anchor: "y2", mirror: "all" }),
      yaxis: axis("distance, mm", { domain: [0.4, 1] }),
      yaxis2: axis("residual, µm", { domain: [0, 0.3], zeroline: true, zerolinecolor: "#666" })
    }));
  }

  const jobs = [];
  data.dependences.forEach(function (figure) { jobs.push(function () { dependence(figure); }); });
  if (data.trajectories.length) jobs.push(function () { trajectories(data.trajectories); });
  if (data.residuals.length) jobs.push(function () { residuals(data.residuals); });
  data.slides.forEach(function (s, i) { jobs.push(function () { slide(s, i); }); });
  root.dataset.figures = String(jobs.length);
  jobs.forEach(function (job) { job(); });

  document.querySelectorAll(".frame svg").forEach(function (svg) {
    svg.addEventListener("click", function () { svg.parentElement.classList.toggle("big"); });
  });

  // On paper the boxes are narrower than on the screen, and closed details would be lost.
  function resize_all() {
    document.querySelectorAll(".box").forEach(function (box) { if (box.data) Plotly.Plots.resize(box); });
  }
  addEventListener("beforeprint", function () {
    document.querySelectorAll("details").forEach(function (d) { d.open = true; });
    resize_all();
  });
  addEventListener("afterprint", resize_all);
})();
