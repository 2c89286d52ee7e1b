// Frames of a recording to scrub and to point into: circles for the part, a mark and a lamp, a rectangle for a part
// that is no disc. Pixel centres lie at integers, as everywhere in tribotrack.
(function () {
  "use strict";
  var data = JSON.parse(document.getElementById("data").textContent);
  var canvas = document.getElementById("picture"), paper = canvas.getContext("2d");
  var slider = document.getElementById("frame"), number = document.getElementById("number");
  var form = document.getElementById("targets"), lines = document.getElementById("lines");
  var image = new Image(), shown = -1, chosen = data.targets[0].key;

  canvas.width = Math.max(data.width, 640);
  var scale = canvas.width / data.width;
  canvas.height = Math.round(data.height * scale);
  slider.max = String(data.frames.length - 1);
  slider.value = String(data.start);

  function target(key) { return data.targets.find(function (t) { return t.key === key; }); }
  function place(v) { return (v + 0.5) * scale; }
  function rounded(v) { return Math.round(v * 10) / 10; }

  function draw() {
    paper.drawImage(image, 0, 0, canvas.width, canvas.height);
    data.targets.forEach(function (t) {
      if (!t.values) return;
      paper.strokeStyle = t.colour;
      paper.lineWidth = t.key === chosen ? 3 : 2;
      paper.beginPath();
      if (t.rectangle) paper.rect(place(t.values[0] - 0.5), place(t.values[1] - 0.5), t.values[2] * scale, t.values[3] * scale);
      else paper.arc(place(t.values[0]), place(t.values[1]), t.values[2] * scale, 0, 2 * Math.PI);
      paper.stroke();
    });
  }

  function write() {
    var text = data.head;
    data.targets.forEach(function (t) {
      if (t.values) text += t.key + " = [" + t.values.map(rounded).join(", ") + "]\n";
    });
    lines.textContent = text;
    draw();
  }

  function show() {
    var k = Number(slider.value);
    number.textContent = String(data.numbers[k]);
    if (k === shown) return;
    shown = k;
    image.onload = draw;
    image.src = "data:image/jpeg;base64," + data.frames[k];
  }

  function numbersOf(t) {
    return t.inputs.map(function (input) { return input.value === "" ? NaN : Number(input.value); });
  }

  function fill(t) {
    t.inputs.forEach(function (input, k) { input.value = t.values ? String(rounded(t.values[k])) : ""; });
  }

  data.targets.forEach(function (t, index) {
    var set = document.createElement("fieldset"), legend = document.createElement("legend");
    var label = document.createElement("label"), radio = document.createElement("input");
    radio.type = "radio"; radio.name = "target"; radio.value = t.key; radio.checked = index === 0;
    radio.addEventListener("change", function () {
      chosen = t.key;
      form.querySelectorAll("fieldset").forEach(function (f) { f.dataset.on = f === set ? "1" : "0"; });
      draw();
    });
    set.dataset.on = index === 0 ? "1" : "0";
    label.append(radio, " " + t.name);
    legend.append(label);
    var row = document.createElement("div");
    row.className = "numbers";
    t.inputs = (t.rectangle ? ["x", "y", "width", "height"] : ["x", "y", "radius"]).map(function (word) {
      var field = document.createElement("label"), input = document.createElement("input");
      input.type = "number"; input.step = "0.1";
      input.addEventListener("input", function () {
        var values = numbersOf(t);
        t.values = values.every(isFinite) ? values : null;
        write();
      });
      field.append(word, input);
      row.append(field);
      return input;
    });
    var clear = document.createElement("button");
    clear.type = "button"; clear.textContent = "There is none";
    clear.addEventListener("click", function () { t.values = null; fill(t); write(); });
    set.append(legend, row, clear);
    form.append(set);
    fill(t);
  });

  function at(event) {
    var box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) * data.width / box.width - 0.5, (event.clientY - box.top) * data.height / box.height - 0.5];
  }

  var begun = null;
  canvas.addEventListener("pointerdown", function (event) { begun = at(event); canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointermove", function (event) {
    if (!begun) return;
    var t = target(chosen), now = at(event), dx = now[0] - begun[0], dy = now[1] - begun[1];
    if (t.rectangle) {
      t.values = [Math.min(begun[0], now[0]), Math.min(begun[1], now[1]), Math.abs(dx), Math.abs(dy)].map(Math.round);
    } else {
      if (Math.hypot(dx, dy) < 1) return;
      t.values = [begun[0], begun[1], Math.hypot(dx, dy)];
    }
    fill(t);
    write();
  });
  canvas.addEventListener("pointerup", function () { begun = null; });
  canvas.addEventListener("keydown", function (event) {
    var step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key], t = target(chosen);
    if (!step || !t.values) return;
    event.preventDefault();
    t.values[0] += 0.5 * step[0];
    t.values[1] += 0.5 * step[1];
    fill(t);
    write();
  });
  slider.addEventListener("input", show);
  document.getElementById("copy").addEventListener("click", function () {
    var said = document.getElementById("copied");
    navigator.clipboard.writeText(lines.textContent).then(
      function () { said.textContent = "copied"; },
      function () { said.textContent = "select the lines and copy them by hand"; });
  });
  show();
  write();
})();
