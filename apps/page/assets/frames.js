// Frames of a recording to scrub, to zoom and to point into: circles for the part, a mark and a lamp, a rectangle for a
// part that is no disc, a line along a ruler. Pixel centres lie at integers, as everywhere in tribotrack.
//
// pointing(root, data, changed): root.querySelector gives .picture (canvas), .scrub (slider), .number, .targets;
// data {width, height, count, start, number(k), source(k), targets: [{key, name, colour, shape, values}], discs: [[x, y,
// r]], over(paper, k)}. changed(target) is told of every new place. {show(k), draw()} comes back.
function pointing(root, data, changed) {
  "use strict";
  const part = (name) => root.querySelector("." + name);
  const canvas = part("picture"), paper = canvas.getContext("2d"), slider = part("scrub"), number = part("number");
  const form = part("targets"), image = new Image(), words = { circle: ["x", "y", "radius"],
    rectangle: ["x", "y", "width", "height"], line: ["x1", "y1", "x2", "y2"] };
  const view = { zoom: 1, x: 0, y: 0 };
  let chosen = data.targets[0], shown = -1, begun = null;

  canvas.width = Math.max(data.width, 640);
  const scale = canvas.width / data.width;
  canvas.height = Math.round(data.height * scale);
  slider.max = String(data.count - 1);
  slider.value = String(data.start);

  const rounded = (v) => Math.round(v * 10) / 10;

  function draw() {
    const z = scale * view.zoom;
    paper.setTransform(1, 0, 0, 1, 0, 0);
    paper.fillStyle = "#000";
    paper.fillRect(0, 0, canvas.width, canvas.height);
    // From here on in pixels of the recording, whose centres lie at integers.
    paper.setTransform(z, 0, 0, z, (0.5 - view.x) * z, (0.5 - view.y) * z);
    paper.imageSmoothingEnabled = z < 4;
    if (image.complete && image.naturalWidth) paper.drawImage(image, -0.5, -0.5, data.width, data.height);
    data.targets.forEach((t) => {
      if (!t.values) return;
      const v = t.values;
      paper.strokeStyle = t.colour;
      paper.lineWidth = (t === chosen ? 3 : 2) / z;
      paper.beginPath();
      if (t.shape === "rectangle") paper.rect(v[0] - 0.5, v[1] - 0.5, v[2], v[3]);
      else if (t.shape === "line") { paper.moveTo(v[0], v[1]); paper.lineTo(v[2], v[3]); }
      else paper.arc(v[0], v[1], Math.max(v[2], 0), 0, 2 * Math.PI);
      paper.stroke();
    });
    if (data.over) data.over(paper, shown, z);
  }

  function show(k) {
    slider.value = String(k);
    k = Number(slider.value);
    number.textContent = String(data.number(k));
    if (k === shown) return draw();
    shown = k;
    image.src = data.source(k);
  }
  image.onload = draw;

  function place(t, values, typed) {
    t.values = values;
    if (!typed) t.inputs.forEach((input, k) => { input.value = values ? String(rounded(values[k])) : ""; });
    changed(t);
    draw();
  }

  function choose(t) {
    chosen = t;
    form.querySelectorAll("fieldset").forEach((set, k) => { set.dataset.on = data.targets[k] === t ? "1" : "0"; });
    form.querySelectorAll("input[type=radio]").forEach((radio, k) => { radio.checked = data.targets[k] === t; });
    draw();
  }

  function zoom(factor, at) {
    const next = Math.min(32, Math.max(1, view.zoom * factor)), share = 1 / view.zoom - 1 / next;
    view.x += (at[0] + 0.5 - view.x) * view.zoom * share;
    view.y += (at[1] + 0.5 - view.y) * view.zoom * share;
    view.zoom = next;
    pan(0, 0);
  }
  function pan(dx, dy) {
    view.x = Math.min(data.width * (1 - 1 / view.zoom), Math.max(0, view.x + dx));
    view.y = Math.min(data.height * (1 - 1 / view.zoom), Math.max(0, view.y + dy));
    draw();
  }
  const middle = () => [view.x + data.width / view.zoom / 2, view.y + data.height / view.zoom / 2];

  data.targets.forEach((t) => {
    const set = document.createElement("fieldset"), legend = document.createElement("legend");
    const label = document.createElement("label"), radio = document.createElement("input");
    radio.type = "radio"; radio.name = "target"; radio.value = t.key;
    radio.addEventListener("change", () => choose(t));
    label.append(radio, " " + t.name);
    legend.append(label);
    const row = document.createElement("div");
    row.className = "numbers";
    t.inputs = words[t.shape].map((word) => {
      const field = document.createElement("label"), input = document.createElement("input");
      input.type = "number"; input.step = "0.1"; input.name = t.key + " " + word;
      input.addEventListener("input", () => {
        const values = t.inputs.map((i) => i.value === "" ? NaN : Number(i.value));
        place(t, values.every(isFinite) ? values : null, true);
      });
      field.append(word, input);
      row.append(field);
      return input;
    });
    const clear = document.createElement("button");
    clear.type = "button"; clear.textContent = "There is none";
    clear.setAttribute("aria-label", "There is none: " + t.name);
    clear.addEventListener("click", () => place(t, null));
    set.append(legend, row, clear);
    form.append(set);
    if (t.values) t.inputs.forEach((input, k) => { input.value = String(rounded(t.values[k])); });
  });

  function at(event) {
    const box = canvas.getBoundingClientRect();
    return [view.x + (event.clientX - box.left) * data.width / box.width / view.zoom - 0.5,
      view.y + (event.clientY - box.top) * data.height / box.height / view.zoom - 0.5];
  }
  /// A click: the smallest disc found there; else the circle moves there as it is.
  function click(t, p) {
    if (t.shape === "line") {
      const open = t.first;
      t.first = open ? null : p;
      if (open) place(t, [open[0], open[1], p[0], p[1]]);
      return;
    }
    if (t.shape === "rectangle") return;
    const found = (data.discs || []).filter((d) => Math.hypot(d[0] - p[0], d[1] - p[1]) <= d[2]);
    found.sort((a, b) => a[2] - b[2]);
    place(t, found.length ? found[0].slice() : [p[0], p[1], t.values ? t.values[2] : data.width / 20]);
  }
  canvas.addEventListener("pointerdown", (event) => {
    begun = { p: at(event), x: event.clientX, y: event.clientY, far: false, pans: event.shiftKey || event.button === 1 };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!begun) return;
    const a = begun.p, b = at(event), t = chosen;
    begun.far = begun.far || Math.hypot(event.clientX - begun.x, event.clientY - begun.y) > 4;
    if (!begun.far) return;
    if (begun.pans || !t) pan(a[0] - b[0], a[1] - b[1]);
    else if (t.shape === "rectangle")
      place(t, [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1])].map(Math.round));
    else if (t.shape === "line") place(t, [a[0], a[1], b[0], b[1]]);
    else place(t, [a[0], a[1], Math.hypot(b[0] - a[0], b[1] - a[1])]);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (begun && !begun.far && chosen) click(chosen, at(event));
    begun = null;
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(event.deltaY < 0 ? 1.25 : 0.8, at(event));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    const t = chosen, v = t && t.values;
    if (event.key === "+" || event.key === "=") zoom(1.25, v ? v : middle());
    else if (event.key === "-") zoom(0.8, middle());
    else if (event.key === "0") zoom(0, middle());
    else if (event.key === "PageDown") show(shown + 1);
    else if (event.key === "PageUp") show(shown - 1);
    else if ((event.key === "[" || event.key === "]") && v && t.shape === "circle")
      place(t, [v[0], v[1], Math.max(0.5, v[2] + (event.key === "]" ? 0.5 : -0.5))]);
    else if (step && (event.shiftKey || !v)) pan(step[0] * 20 / view.zoom, step[1] * 20 / view.zoom);
    else if (step) place(t, v.map((c, k) => k < 2 || t.shape === "line" ? c + 0.5 * step[k % 2] : c));
    else return;
    event.preventDefault();
  });
  slider.addEventListener("input", () => show(Number(slider.value)));
  if (chosen) choose(chosen);
  show(data.start);
  return { show, draw, rounded };
}

// The page of `probe --page`: all frames in the page, and lines to copy.
(function () {
  "use strict";
  const holder = document.getElementById("data");
  if (!holder) return;
  const data = JSON.parse(holder.textContent), lines = document.getElementById("lines");
  data.count = data.frames.length;
  data.number = (k) => data.numbers[k];
  data.source = (k) => "data:image/jpeg;base64," + data.frames[k];
  function write() {
    lines.textContent = data.head + data.targets.filter((t) => t.values).map((t) =>
      t.key + " = [" + t.values.map((v) => Math.round(v * 10) / 10).join(", ") + "]\n").join("");
  }
  pointing(document.querySelector(".pointing"), data, write);
  document.getElementById("copy").addEventListener("click", () => {
    const said = document.getElementById("copied");
    navigator.clipboard.writeText(lines.textContent).then(
      () => { said.textContent = "copied"; },
      () => { said.textContent = "select the lines and copy them by hand"; });
  });
  write();
})();
