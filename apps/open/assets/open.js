// The page of `tribotrack open`. The campaign file is the truth: what is shown comes from `state`, what is typed is
// written there at once, and what takes long is a command of the program, shown as it would be typed.
(function () {
  "use strict";
  if (!document.body.classList.contains("open")) return;
  const root = document.documentElement, $ = (id) => document.getElementById(id);
  root.dataset.errors = "0";
  addEventListener("error", (e) => count(e.message));
  addEventListener("unhandledrejection", (e) => count(String(e.reason)));
  document.addEventListener("securitypolicyviolation", (e) => count("policy: " + e.violatedDirective));
  function count(text) {
    root.dataset.errors = String(Number(root.dataset.errors) + 1);
    root.dataset.errorsText = (root.dataset.errorsText || "") + text + "; ";
  }

  let state = {}, seen = -1, closed = -1, job = {}, wasRunning = false, views = {};
  const probed = new Map();  // recording -> what `probe --json` says, or {failure}

  // What is asked of the program, and what it answers.
  async function ask(path, body) {
    const answer = await fetch(path, body === undefined ? {} :
      { method: "POST", body: JSON.stringify(body), headers: { "Content-Type": "application/json" } });
    if (answer.ok) return answer.json();
    const error = new Error((await answer.text()).trim());
    error.status = answer.status;
    throw error;
  }
  function say(text, kind) {
    $("said").textContent = text;
    $("said").className = kind || "";
  }
  function h(tag, attributes, ...children) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes || {}))
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, value === true ? "" : value);
    element.append(...children.filter((c) => c !== null && c !== undefined));
    return element;
  }
  const query = (path, values) => path + "?" + new URLSearchParams(values);
  const has = () => state.revision !== undefined && state.revision !== "none";

  async function load() {
    try { state = await ask("state"); } catch (error) { return say(error.message, "bad"); }
    show();
  }
  // Writes to the campaign; a page that shows an older one is refused, and shows the newer one.
  async function write(changes, what) {
    try {
      state = await ask("campaign", { revision: state.revision, ...changes });
      say(what + ": written to " + state.campaign, "good");
      show();
      return true;
    } catch (error) {
      if (error.status === 409) await load();
      say(error.message, "bad");
      return false;
    }
  }
  async function start(what, more) {
    try {
      job = await ask("start", { what, ...more });
      wasRunning = true;
      showJob();
    } catch (error) { say(error.message, "bad"); }
  }

  // TOML of what was typed: a number as it was typed, all else as a text. A decimal comma is meant as a point.
  const quoted = (text) => JSON.stringify(text).replace(/\u007f/g, "\\u007F");
  const isNumber = (text) => /^[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?$/.test(text);
  function toml(typed, kind) {
    let text = typed.trim();
    if (text === "") return "";
    if (kind === "text") return quoted(text);
    text = text.replace(/^([+-]?\d+),(\d+)/, "$1.$2").replace(/\s*°$/, "deg");
    if (isNumber(text)) return text.replace(/^([+-]?)\./, "$10.").replace(/\.(?=$|[eE])/, ".0").replace(/^([+-]?)0+(?=\d)/, "$1");
    return kind === "angle" ? quoted(text) : quoted(typed.trim());
  }
  // An input for a key, written when it is left.
  function field(label, value, place, kind, cls) {
    const input = h("input", { "aria-label": label, class: cls, autocomplete: "off", "data-key": place.key,
      placeholder: kind === "angle" && place.section === "run" ? "45deg" : null });
    input.value = value === undefined || value === null ? "" : String(value);
    input.dataset.before = input.value;
    const leave = () => {
      if (!input.isConnected || input.value.trim() === input.dataset.before) return;
      input.dataset.before = input.value.trim();
      write({ edits: [{ ...place, value: toml(input.value, kind) }] }, label);
    };
    input.addEventListener("change", leave);
    input.addEventListener("blur", leave);
    return input;
  }
  const valuesOf = (section) => section.split(".").reduce((v, key) => (v || {})[key], state.values || {}) || {};

  const kShared = [["platform", "amplitude_mm", "Amplitude A, mm"], ["platform", "frequency_hz", "Frequency, Hz"],
    ["part", "diameter_mm", "Diameter of the part, mm"], ["part", "chamfer_mm", "Width of its chamfer, mm"], ["camera", "mm_per_px", "Scale, mm/px"],
    ["camera", "frame_rate_hz", "Frame rate, frames/s"], ["camera", "frame_rate_reason", "How the frame rate is known", "text"],
    ["fit", "cycles", "Cycles measured over, at most"]];

  // Recordings: a row for each run and for each recording without one.
  function rateText(p) {
    const t = p.time_base || {};
    const given = valuesOf("camera").frame_rate_hz;
    return given ? given + "/s, given" : t.rate_hz ? +t.rate_hz.toPrecision(6) + "/s by the " + (t.from || t.source || "file") : "rate not known: give the frame rate";
  }
  function look(recording, cell) {
    const p = probed.get(recording);
    cell.replaceChildren();
    if (!p) return cell.append("looking …");
    if (p.failure) return cell.append(h("strong", {}, "cannot be read: "), p.failure);
    cell.append(p.frames + " frames, " + rateText(p));
    const notes = p.notes || [];
    if (notes.length) cell.append(h("details", {}, h("summary", {}, notes.length + " finding" + (notes.length > 1 ? "s" : "")),
      h("ul", {}, ...notes.map((n) => h("li", {}, n)))));
  }
  function recordingsTable() {
    const runs = (state.values || {}).run || [], named = new Set(runs.map((r) => r.video));
    const inList = listed().map((r) => r.video).filter((video) => !named.has(video));  // of [data] runs
    const rows = runs.map((run, k) => ({ run, k, video: run.video })).concat(inList.map((video) => ({ video, list: true })),
      (state.recordings || []).filter((r) => !named.has(r) && !inList.includes(r)).map((video) => ({ video })));
    const labelled = (text, input) => h("label", {}, h("span", {}, text + " "), input);
    const body = rows.map(({ run, k, video, list }) => {
      const cell = h("td", { class: "seen", "data-recording": video });
      if (video) look(video, cell);
      const name = video || (run || {}).name || "measured elsewhere", place = (key) => ({ section: "run", run: k, key });
      const slide = run && run.kind === "free_slide";
      return h("tr", {}, h("td", {}, video ? h("img", { src: query("frame", { recording: video, side: 168 }), alt: "First frame of " + video, loading: "lazy" }) : null),
        h("th", { scope: "row" }, name), cell,
        ...(run ? [h("td", {}, slide ? "free slide" : labelled("phi", field("phi of " + name, run.phi_rad, place("phi_rad"), "angle"))),
          h("td", {}, slide ? "" : labelled("dtau", field("dtau of " + name, run.dtau_rad, place("dtau_rad"), "angle"))),
          h("td", {}, labelled("name", field("name of " + name, run.name, place("name"), "text", "name")))]
          : list ? [h("td", { colspan: 3 }, "by the list ", h("code", {}, valuesOf("data").runs))]
            : has() ? [h("td", { colspan: 3 }, h("button", { type: "button", onclick: () => write({ add: [video] }, video) }, "Add to the campaign"))] : []));
    });
    const head = ["", "Recording", "What it is"].concat(has() ? ["phi", "dtau", "Name"] : []);
    $("runs").replaceChildren(rows.length ? h("table", { class: "listed" }, h("thead", {}, h("tr", {}, ...head.map((t) =>
      t ? h("th", { scope: "col" }, t) : h("td", {})))), h("tbody", {}, ...body))
      : h("p", {}, "There is no recording in this folder: copy some into it (.cine, video, TIFF stack, folders of pictures), then reload this page."));
    for (const { video } of rows) if (video && !probed.has(video)) wanted.add(video);
    probeNext();
  }
  const wanted = new Set();
  let probing = false;
  async function probeNext() {
    if (probing) return;
    probing = true;
    for (const recording of wanted) {
      wanted.delete(recording);
      try { probed.set(recording, await ask(query("probe", { recording }))); }
      catch (error) { probed.set(recording, { failure: error.message }); }
      document.querySelectorAll("td.seen").forEach((cell) => { if (cell.dataset.recording === recording) look(recording, cell); });
      if (["#point", "#track", "#check"].includes(location.hash)) show();
    }
    probing = false;
    root.dataset.probed = String(probed.size);
  }
  function showRecordings() {
    $("draft").hidden = has() || !(state.recordings || []).length;
    $("paste").hidden = $("shared-box").hidden = !has();
    recordingsTable();
    $("shared").replaceChildren(...kShared.map(([section, key, label, kind]) =>
      h("label", {}, label, field(label, valuesOf(section)[key], { section, key }, kind || "number"))));
  }
  $("again").addEventListener("click", load);
  const draftFields = () => Object.fromEntries([...new FormData($("draft-form"))].map(([k, v]) => [k, v.trim().replace(",", ".")]));
  function draftCommand() {
    const d = draftFields();
    $("draft-command").textContent = "as a command: tribotrack init . --from ." + (d.diameter_mm ? " --disc-diameter-mm " + d.diameter_mm : "") +
      (d.chamfer_mm ? " --chamfer-mm " + d.chamfer_mm : "") + (d.fps ? " --fps " + d.fps : "");
  }
  $("draft-form").addEventListener("input", draftCommand);
  $("draft-form").addEventListener("submit", (e) => { e.preventDefault(); start("init", draftFields()); });
  $("take").addEventListener("click", async () => {
    if (await write({ list: $("pasted").value }, "the table")) $("pasted").value = "";
  });

  // Which run the steps look at.
  let which = "";
  const listed = () => (state.runs || []).filter((r) => r.video);
  const current = () => listed().find((r) => r.name === which) || listed()[0];
  document.querySelectorAll("select.which").forEach((select) => select.addEventListener("change", () => { which = select.value; views = {}; show(); }));
  function showWhich() {
    document.querySelectorAll("select.which").forEach((select) => {
      select.replaceChildren(...listed().map((r) => h("option", { value: r.name }, r.name)));
      if (current()) select.value = current().name;
    });
  }
  // The canvas of a section for a recording, made anew where that has changed.
  function view(section, recording, make) {
    const key = recording + "\n" + make.key;
    if (views[section] && views[section].key === key) return views[section];
    const old = $(section).querySelector(".pointing"), box = old.cloneNode(true);
    box.querySelector(".targets").replaceChildren();
    old.replaceWith(box);
    const data = make(), made = pointing(box, data, data.changed || (() => {}));
    return views[section] = { key, data, ...made };
  }
  const sourceOf = (recording) => (k) => query("frame", { recording, index: k, side: 1280 });

  // Point.
  const circle = (v) => Array.isArray(v) && v.length >= 3 ? v.map(Number) : null;
  function placesOf(run) {
    const own = ((state.values || {}).run || []).find((r) => r.video === run.video) || {};
    return (key) => circle(own[key]) || circle(valuesOf("camera")[key]);
  }
  function showPoint() {
    const run = current(), p = run && probed.get(run.video);
    if (!p || p.failure || !p.frames) return;
    const survey = p.survey || { discs: [], lamps: [] }, given = placesOf(run);
    const discs = survey.discs.concat(survey.lamps).map((d) => d.circle_px);
    const make = () => {
      const target = (key, name, colour, shape) => ({ key, name, colour, shape, values: given(key) });
      return { width: p.width_px, height: p.height_px, count: p.frames, start: Math.max(0, (survey.frame || 0) - p.first_image),
        number: (k) => p.first_image + k, source: sourceOf(run.video), discs, changed: pointed,
        targets: [target("disc_px", "The part, a disc", "#50ff50", "circle"), target("marker_px", "A mark on the platform", "#33bbff", "circle"),
          target("gate_px", "Gate LED, lit while the actuator is on", "#ff6060", "circle"), target("template_px", "A part that is no disc", "#ffd040", "rectangle"),
          { key: "ruler", name: "A ruler: two clicks", colour: "#ff80ff", shape: "line", values: null }] };
    };
    make.key = state.revision;
    view("point", run.video, make);
    pointed();
  }
  function scale() {
    const v = views.point && views.point.data.targets[4].values, mm = Number($("ruler-form").length.value.replace(",", "."));
    return v && mm > 0 ? Number((mm / Math.hypot(v[2] - v[0], v[3] - v[1])).toPrecision(5)) : null;
  }
  function placeEdits() {
    const run = current(), one = $("for-whom").value === "run", given = placesOf(run);
    const index = state.values.run.findIndex((r) => r.video === run.video), edits = [];
    for (const t of views.point.data.targets.slice(0, 4)) {
      const value = t.values ? "[" + t.values.map(views.point.rounded).join(", ") + "]" : "";
      const before = given(t.key), as = before ? "[" + before.map(views.point.rounded).join(", ") + "]" : "";
      if (value !== as) edits.push(one && index >= 0 && t.key !== "gate_px" ? { section: "run", run: index, key: t.key, value } : { section: "camera", key: t.key, value });
    }
    if (scale()) edits.push({ section: "camera", key: "mm_per_px", value: String(scale()) });
    return edits;
  }
  function pointed() {
    const edits = views.point ? placeEdits() : [];
    $("point-lines").textContent = edits.map((e) => (e.section === "run" ? "[[run]] " : "[camera] ") + (e.value ? e.key + " = " + e.value : "# " + e.key)).join("\n") ||
      "nothing new to write";
    $("write-places").disabled = !edits.length;
  }
  $("ruler-form").addEventListener("input", pointed);
  $("ruler-form").addEventListener("submit", (e) => e.preventDefault());
  $("for-whom").addEventListener("change", pointed);
  $("write-places").addEventListener("click", () => write({ edits: placeEdits() }, "the places"));

  // Track: of all of a run where there is one, else of its first second.
  function rowsOf(csv) {
    const lines = csv.trim().split("\n"), names = lines[0].split(",");
    return lines.slice(1).map((line) => {
      const cells = line.split(",");
      return Object.fromEntries(names.map((name, k) => [name, name === "status" ? cells[k] : cells[k] === "" ? NaN : Number(cells[k])]));
    });
  }
  const median = (values) => { const v = values.filter(isFinite).sort((a, b) => a - b); return v.length ? v[Math.floor(v.length / 2)] : NaN; };
  let newest = {};  // run -> "tracks" or "first_second/tracks"
  async function showTrack() {
    const run = current(), p = run && probed.get(run.video);
    $("track-command").textContent = run ? "as a command: tribotrack track --campaign " + state.campaign + " --run " + run.name + " -o " + state.output + "/tracks/" + run.name + ".csv" : "";
    if (!run || !p || p.failure) { $("track-view").hidden = true; return; }
    const order = newest[run.name] ? [newest[run.name]] : ["tracks", "first_second/tracks"];
    let csv = null, from = "";
    for (const folder of order) {
      const answer = await fetch("out/" + folder + "/" + encodeURIComponent(run.name) + ".csv");
      if (answer.ok) { csv = await answer.text(); from = folder; break; }
    }
    $("track-view").hidden = csv === null;
    if (csv === null) return;
    const rows = rowsOf(csv), ok = rows.filter((r) => r.status === "ok"), byFrame = new Map(rows.map((r) => [r.frame, r]));
    const radius = (placesOf(run)("disc_px") || ((p.survey || {}).discs || []).map((d) => d.circle_px)[0] || [0, 0, 10])[2];
    $("track-numbers").textContent = (from === "tracks" ? "All of it: " : "The first second: ") + ok.length + " of " + rows.length + " frames tracked; sd of a position " +
      median(ok.map((r) => Math.hypot(r.sigma_x_px, r.sigma_y_px) / Math.SQRT2)).toPrecision(2) + " px (median); correlation with the pattern " +
      median(ok.map((r) => r.ncc)).toFixed(4) + " (median), " + Math.min(...ok.map((r) => r.ncc)).toFixed(4) + " (least).";
    const lost = rows.filter((r) => r.status !== "ok"), jump = (frame) => views.track.show(frame - p.first_image);
    $("lost").replaceChildren(...(lost.length ? lost.slice(0, 500).map((r) => h("li", {}, h("button", { type: "button", onclick: () => jump(r.frame) }, "frame " + r.frame + ": " + r.status)))
      : [h("li", {}, "none")]));
    const make = () => ({ width: p.width_px, height: p.height_px, count: p.frames, start: Math.max(0, rows[0].frame - p.first_image), targets: [],
      number: (k) => p.first_image + k, source: sourceOf(run.video),
      over: (paper, k, z) => {
        paper.lineWidth = 1.5 / z;
        paper.strokeStyle = "#d55e00";
        paper.beginPath();
        ok.forEach((r, n) => n ? paper.lineTo(r.x_px, r.y_px) : paper.moveTo(r.x_px, r.y_px));
        paper.stroke();
        const r = byFrame.get(p.first_image + k);
        $("track-row").textContent = !r ? "this frame was not analysed" : r.status !== "ok" ? "frame " + r.frame + ": " + r.status :
          "frame " + r.frame + ": (" + r.x_px.toFixed(3) + ", " + r.y_px.toFixed(3) + ") px, sd " + r.sigma_x_px.toPrecision(2) + " and " + r.sigma_y_px.toPrecision(2) +
          " px, correlation " + r.ncc.toFixed(5);
        if (!r || r.status !== "ok") return;
        paper.strokeStyle = "#50ff50";
        paper.beginPath();
        paper.arc(r.x_px, r.y_px, radius, 0, 2 * Math.PI);
        paper.stroke();
      } });
    make.key = csv.length + from + seen;
    view("track", run.video, make);
  }

  // Check.
  const digits = (v) => v === null || v === undefined ? "" : String(+Number(v).toPrecision(5));
  function showCheck() {
    const platform = valuesOf("platform"), form = $("ask");
    if (!form.amplitude_mm.value) form.amplitude_mm.value = platform.amplitude_mm || "";
    if (!form.frequency_hz.value) form.frequency_hz.value = platform.frequency_hz ||
      (platform.angular_frequency_rad_s ? digits(platform.angular_frequency_rad_s / 2 / Math.PI) : "");
    $("times").replaceChildren(...listed().map((r) => {
      const p = probed.get(r.video) || {}, t = p.time_base || {}, bad = [];
      if (p.failure) return h("li", {}, r.name + ": " + p.failure);
      if (!p.frames) return h("li", {}, r.name + ": looking …");
      if (!t.rate_hz && !valuesOf("camera").frame_rate_hz) bad.push(t.why_unknown || "frame rate not known");
      if ((t.gaps || []).length) bad.push(t.gaps.length + " gaps");
      if (((p.repeats || {}).repeated_images || []).length) bad.push(p.repeats.repeated_images.length + " repeated frames");
      return h("li", {}, r.name + ": " + rateText(p) +
        (bad.length ? "; " + bad.join(", ") : ", sound"));
    }));
    const driven = (state.runs || []).filter((r) => !r.free_slide), scoped = driven.filter((r) => r.scope).length;
    $("phi-from").textContent = !driven.length ? "No run is driven." :
      scoped ? scoped + " of " + driven.length + " runs have an oscilloscope trace: phi and dtau are measured from it." :
        valuesOf("camera").gate_px ? "The gate LED is seen: phi and dtau are measured from it where that is better than what was commanded." :
          "As commanded, in " + driven.length + " runs: any constant error of phi goes into the phase lag.";
    $("conditions").replaceChildren(h("table", {}, h("thead", {}, h("tr", {}, ...["Quantity", "Value", "sd", "Where from"].map((t) => h("th", { scope: "col" }, t)))),
      h("tbody", {}, ...(state.conditions || []).map((c) => h("tr", {}, h("th", { scope: "row" }, c.name),
        h("td", {}, field(c.name, valuesOf(c.section)[c.key] === undefined ? digits(c.given) : valuesOf(c.section)[c.key], { section: c.section, key: c.key }, "angle")),
        h("td", {}, field("sd of " + c.name, valuesOf(c.section)[c.key + "_sd"] === undefined ? "" : valuesOf(c.section)[c.key + "_sd"],
          { section: c.section, key: c.key + "_sd" }, "number"), c.sd ? " counted: " + digits(c.sd) : ""), h("td", {}, c.from))))));
  }
  $("ask").addEventListener("submit", async (e) => {
    e.preventDefault();
    $("forecast").textContent = "computing …";
    try {
      const f = await ask(query("forecast", Object.fromEntries([...new FormData($("ask"))].map(([k, v]) => [k, v.trim().replace(",", ".")]))));
      $("forecast").replaceChildren(h("p", {}, f.sentence),
        f.parameters ? h("table", {}, h("thead", {}, h("tr", {}, ...["Parameter", "Value assumed ± sd to expect"].map((t) => h("th", { scope: "col" }, t)))),
          h("tbody", {}, ...Object.entries(f.parameters).map(([name, v]) => h("tr", {}, h("th", { scope: "row" }, name), h("td", {}, v.sd === null ? digits(v.assumed) + ", not determined" : withSd(v.assumed, v.sd)))))) : "",
        h("ul", {}, ...(f.weak || []).map((w) => h("li", {}, w))), f.next ? h("p", {}, f.next) : "",
        f.parameters ? h("p", { class: "note" }, "From the model alone, each displacement known to 1 % and 0.01 mm, at the assumed values ([fit.guess] sets others).") : "");
    } catch (error) { $("forecast").textContent = error.message; }
  });

  // Fit and report.
  // To two digits of the sd.
  function withSd(value, sd) {
    const places = sd > 0 && isFinite(sd) ? Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(sd)))) : -1;
    return places < 0 ? digits(value) + ", not determined" : value.toFixed(places) + " ± " + sd.toFixed(places);
  }
  let reported = "";
  function showReport() {
    $("run-command").textContent = "as a command: tribotrack run " + state.campaign;
    const fit = state.fit, kinds = { use: "good", care: "care", do_not_use: "bad" };
    const words = { use: "Can be used", care: "Use with care", do_not_use: "Do not use" };
    $("verdict").replaceChildren(...(fit ? [h("div", { class: "verdict " + (kinds[fit.verdict] || "none") }, h("h3", {}, words[fit.verdict] || "Fitted"),
      h("p", {}, Object.entries(fit.parameters || {}).map(([name, v]) => name + " = " + withSd(v.estimate, v.sd)).join(", ")))] : []));
    $("report-link").hidden = $("report-frame").hidden = !state.report;
    if (!state.report) return;
    const address = "out/report.html?" + state.report;
    if (reported === address) return;
    $("report-link").firstElementChild.href = address;
    $("report-frame").src = reported = address;
  }

  // The command at work.
  function showJob() {
    const any = Boolean(job.command);
    $("job").hidden = !any || job.version === closed;
    if (!any) return;
    $("job-command").textContent = job.command;
    $("job-bar").hidden = !job.running;
    $("stop").textContent = job.running ? "Stop" : "Close";
    if (job.percent === null || job.percent === undefined) $("job-bar").removeAttribute("value");
    else $("job-bar").value = job.percent;
    $("job-progress").textContent = job.running ? job.progress || "at work …" : "";
    $("job-lines").textContent = (job.lines || []).join("\n");
    const ends = ["finished", "failed", "refused: wrong usage", "refused: see what it said", "finished with a reservation: see what it said", "finished: the fit cannot be used; see what it said"];
    $("job-end").textContent = job.running ? "What it says" : ends[job.exit_code] || "ended (" + job.exit_code + ")";
    if (job.running ? job.command.startsWith("tribotrack watch") : job.exit_code || job.command.endsWith("--dry-run")) $("job-more").open = true;
    document.querySelectorAll("button[data-start], #draft-form button").forEach((b) => { b.disabled = job.running; });
    root.dataset.running = String(Boolean(job.running));
  }
  async function follow() {
    for (;;) {
      try {
        job = await ask(query("job", { seen }));
        seen = job.version;
        showJob();
        const ended = wasRunning && !job.running, stale = state.revision !== undefined && (job.revision !== state.revision || job.report !== state.report);
        wasRunning = job.running;
        if (ended) say(job.command.split(" ").slice(0, 2).join(" ") + ": " + $("job-end").textContent, job.exit_code ? "bad" : "good");
        if ((ended || stale) && !(document.activeElement && document.activeElement.id === "text" && stale && !ended)) await load();
      } catch (error) {
        if (error.status === undefined) say("The program has ended: start `tribotrack open` again, and use the address that it prints.", "bad");
        await new Promise((done) => setTimeout(done, 2000));
      }
    }
  }
  $("stop").addEventListener("click", () => {
    if (job.running) return ask("stop", {});
    closed = job.version;
    showJob();
  });
  document.querySelectorAll("button[data-start]").forEach((b) => b.addEventListener("click", () => {
    const run = current(), what = b.dataset.start;
    if (run && what === "track") newest[run.name] = "tracks";
    if (run && what === "first_second") newest[run.name] = "first_second/tracks";
    start(what, what === "watch" ? { until: $("until").value.trim() } : run ? { run: run.name } : {});
  }));

  // The file itself.
  function showFile() {
    $("text-label").textContent = state.campaign;
    if ($("text").dataset.revision !== state.revision) {
      $("text").value = state.text || "";
      $("text").dataset.revision = state.revision;
    }
  }
  $("save").addEventListener("click", () => write({ text: $("text").value }, "the text"));
  $("discard").addEventListener("click", () => { $("text").value = state.text || ""; });

  // Steps.
  const steps = [...document.querySelectorAll("#steps a")];
  // Anew, the keyboard where it was, with what was being typed there.
  function show() {
    const active = document.activeElement, label = active && active.getAttribute("aria-label"), typed = active && active.value;
    const dirty = active && active.dataset.before !== undefined && typed !== active.dataset.before;
    render();
    if (!label || active.isConnected) return;
    const again = document.querySelector('[aria-label="' + CSS.escape(label) + '"]');
    if (!again) return;
    if (dirty) again.value = typed;
    again.focus();
    if (!dirty && again.select) again.select();
  }
  function render() {
    const step = steps.map((a) => a.hash).includes(location.hash) ? location.hash : "#recordings";
    steps.forEach((a) => { if (a.hash === step) a.setAttribute("aria-current", "page"); else a.removeAttribute("aria-current"); });
    document.querySelectorAll("main > section").forEach((s) => { s.hidden = "#" + s.id !== step; });
    $("folder").textContent = (state.folder || "") + (has() ? " – " + state.campaign : "");
    const open = ((state.text || "").match(/^# TO FILL IN: .*$/gm) || []).map((l) => l.slice(14));
    if (open.length) {
      const names = open.map((l) => (l.match(/^phi_rad and dtau_rad of (.*?): /) || [])[1]).filter(Boolean);
      const others = open.filter((l) => !l.startsWith("phi_rad and dtau_rad of "));
      say("To fill in: " + others.concat(names.length ? ["phi and dtau of " + names.slice(0, 4).join(", ") +
        (names.length > 4 ? " and " + (names.length - 4) + " more" : "")] : []).join("; "), "care");
    }
    else if (state.problem) say(state.problem, "bad");
    if (state.revision === undefined) return;
    showWhich();
    ({ "#recordings": showRecordings, "#point": showPoint, "#track": showTrack, "#check": showCheck, "#report": showReport, "#file": showFile })[step]();
    if (step !== "#recordings") { listed().forEach((r) => { if (!probed.has(r.video)) wanted.add(r.video); }); probeNext(); }
    root.dataset.revision = state.revision;
  }
  addEventListener("hashchange", () => { say(""); show(); });
  draftCommand();
  load().then(follow);
})();
