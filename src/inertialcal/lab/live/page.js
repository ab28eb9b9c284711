"use strict";
// Asks for what is new in traces each FRAME, for the state each STATE, for deviations each NOISE [ms]; one question at a
// time is open.
const FRAME = 50, STATE = 500, NOISE = 4000, AGAIN = 500, SILENT = 5000, COLOURS = 6, VALUES = 4, LATEST = 4096, FIRST = 3;
const WORDS = { reading: "reading what was recorded", stalled: "no sign of life", done: "ended", failed: "ended by a fault",
  died: "cut off", ready: "about to begin", stopping: "ending" };
const SLOW = ["degC", "K", "degF"];  // Units without a spectrum
const place = (id) => document.getElementById(id);
const made = (name, parent, text = "", kind = "") => {
  const one = parent.appendChild(document.createElement(name));
  one.textContent = text;
  one.className = kind;
  return one;
};
const said = (one, text, kind) => {  // What does not change is not written: readers of screens would say it again
  if (one.textContent !== text) one.textContent = text;
  if (kind !== undefined && one.className !== kind) one.className = kind;
};
const short = (x) => (x === null || !isFinite(x) ? "-" : Math.abs(x) >= 1e6 || (x && Math.abs(x) < 1e-3) ? x.toExponential(3) : String(+x.toPrecision(6)));
const long = (s) => {
  for (const [size, unit] of [[86400, "d"], [3600, "h"], [60, "min"]]) if (s >= size) return (s / size).toFixed(1) + " " + unit;
  return s.toFixed(0) + " s";
};
const size = (bytes) => (bytes >= 1e9 ? (bytes / 1e9).toFixed(1) + " GB" : (bytes / 1e6).toFixed(1) + " MB");
let web = null, shape = "", shown = [], known = null, next = {}, opened = 0, heard = 0, frames = 0, rate = 0, since = 0, timer = 0;
let drawn = [], newest = 0;  // Of frames with new samples: when they were drawn, stamps of the sample before and of the newest [s, UTC]
window.live = () => ({ frames, rate, drawn, connected: web !== null && web.readyState === 1 });

function connect() {
  web = new WebSocket("ws://" + location.host + "/live" + location.search);
  web.binaryType = "arraybuffer";
  heard = performance.now();
  web.onopen = () => { forget(); next = { state: 0, noise: 800, frame: 0 }; opened = performance.now(); frames = since = 0; ask(); };
  web.onmessage = (event) => {
    heard = performance.now();
    if (typeof event.data === "string") {
      const told = JSON.parse(event.data);
      if (told.kind === "state") showState(told); else showNoise(told);
    } else { counted(); drawTraces(event.data); }
    timer = setTimeout(ask, Math.max(0, Math.min(next.frame, next.state, next.noise) - (performance.now() - opened)));
  };
  web.onclose = () => {
    clearTimeout(timer);
    said(place("link"), "not connected, trying again; what is shown is old", "bad");
    setTimeout(connect, AGAIN);
  };
}

function ask() {
  if (web.readyState !== 1) return;
  const now = performance.now() - opened;
  for (const [word, every] of [["state", STATE], ["noise", NOISE]]) {
    if (now >= next[word]) { next[word] = now + every; web.send(word); return; }
  }
  next.frame = Math.max(next.frame + FRAME, now);
  const first = shown.find((one) => one.traces.length), width = first ? first.traces[0].canvas.clientWidth : 300;
  const points = Math.min(Math.max(Math.round(width), 50), 1000), span = +place("span").value;
  if (!scale || scale.points !== points || scale.span !== span) { scale = { points, span, width: span / points }; forget(); }
  web.send(points + " " + span + " " + run + shown.map((one, i) => (one.last >= 0 ? " " + i + "=" + one.last : "")).join(""));
}

let scale = null, run = 0;  // Of the traces that are asked for: points, span and width of a point [s]; which recording
function forget() { for (const one of shown) { one.last = -1; for (const trace of one.traces) trace.kept = null; } }

function counted() {
  frames += 1;
  const now = performance.now();
  if (!since) { since = now; rate = 0; counted.first = frames; }
  if (now - since >= 1000) { rate = (1000 * (frames - counted.first)) / (now - since); since = now; counted.first = frames; }
}

setInterval(() => { if (web.readyState === 1 && performance.now() - heard > SILENT) web.close(); }, 1000);

function showState(told) {
  known = told;
  const running = told.state === "running", bad = ["stalled", "failed", "died"].includes(told.state);
  said(place("title"), told.title || "Live");
  document.title = (told.title || "Live") + " \u2013 inertialcal";
  said(place("link"), "connected", "good");
  said(place("run"), (WORDS[told.state] || told.state) + ", " + long(told.elapsed) + (rate && running ? ", " + rate.toFixed(0) + " frames/s" : ""), "number" + (bad ? " bad" : ""));
  said(place("why"), told.why, bad ? "bad" : "quiet");
  said(place("status"), told.status);
  const step = told.step;
  said(place("step"), !step ? "" : !step.number ? "the steps begin" : "Step " + step.number + " of " + step.count + (step.name ? ", " + step.name : "") + ": " +
    long(step.left) + " left" + step.values.map(([name, value, unit]) => ", " + name + " " + short(value) + " " + unit).join(""));
  said(place("disk"), size(told.written) + " written" + (told.free === null ? "" : ", " + size(told.free) + " free") +
    (told.full_in === null ? "" : ", full in " + long(told.full_in)));
  const all = JSON.stringify(told.instruments.map((one) => [one.name, one.channels]));
  if (all !== shape) { shape = all; build(told.instruments); }
  const texts = told.remarks.map((one) => [new Date(one.utc).toLocaleTimeString() + " " + one.text, one.severity === "info" ? "" : one.severity === "error" ? "bad" : "warn"]);
  list(place("remarks"), texts.length ? texts.slice(0, FIRST) : [["none so far", "quiet"]]);
  list(place("earlier"), texts.slice(FIRST));
  place("more").hidden = texts.length <= FIRST;
  said(place("many"), texts.length - FIRST + " earlier");
  told.instruments.forEach((one, i) => {
    const counts = ["damaged", "doubled", "late", "lost"].filter((word) => one[word]).map((word) => one[word].toLocaleString("en") + " " + word);
    if (one.intervals) counts.push("saves " + one.intervals);
    said(shown[i].link, one.connected ? "connected" : "not connected", one.connected ? "good" : "bad");
    said(shown[i].rows, !one.channels.length ? "gives no rows" : (one.rate ? short(+one.rate.toPrecision(4)) + " Hz, " : "") + one.acknowledged.toLocaleString("en") + " of " +
      one.rows.toLocaleString("en") + " rows on the disk");
    said(shown[i].counts, counts.join(", "));
    for (const trace of shown[i].traces) trace.gap = one.rate ? 3 / one.rate : 0;
    said(shown[i].identity, one.identity);
  });
}

function list(parent, texts) {
  const same = JSON.stringify(texts);
  if (parent.same === same) return;
  parent.same = same;
  parent.replaceChildren();
  for (const [text, kind] of texts) made("li", parent, text, kind);
}

function build(instruments) {
  const root = place("instruments");
  root.replaceChildren();
  shown = instruments.map((one) => {
    const part = made("section", root);
    made("h2", part, one.name);
    const line = made("p", part, "", "number");
    const found = { link: made("span", line), rows: null, counts: null, identity: null, traces: [], units: [], last: -1 };
    line.append(" \u00b7 ");
    found.rows = made("span", line);
    line.append(" ");
    found.counts = made("span", line, "", "warn");
    found.identity = made("p", part, "", "quiet");
    const grid = made("div", part, "", "traces");
    found.hue = one.channels.map(([, unit], i) => one.channels.slice(0, i).filter((other) => other[1] === unit).length % COLOURS);
    found.traces = one.channels.map(([name, unit], i) => {
      const box = made("div", grid), text = made("p", box), canvas = made("canvas", box);
      made("span", text, name, "k" + found.hue[i]);
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", "last seconds of " + name);
      return { canvas, value: made("span", text, "", "number"), unit, hue: found.hue[i], kept: null, gap: 0 };
    });
    if (one.channels.length) found.basis = made("h3", part, "Allan deviation and spectrum: after the first samples");
    const noise = made("div", part, "", "noise");
    for (const unit of new Set(one.channels.map((channel) => channel[1]).filter((unit) => !SLOW.includes(unit)))) {
      const places = one.channels.map((_, i) => i).filter((i) => one.channels[i][1] === unit), per = unit || "1";
      const drawings = [["Allan deviation", per], ["Spectrum", per + "/\u221aHz"]].map(([what, y]) => {
        const box = made("div", noise);
        made("h3", box, what + " [" + y + "]");
        const canvas = made("canvas", box), key = made("div", box, "", "key");
        for (const i of places) made("span", key, "\u2014 " + one.channels[i][0], "k" + found.hue[i]);
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", what + " of " + places.map((i) => one.channels[i][0]).join(", "));
        return canvas;
      });
      found.units.push({ places, drawings });
    }
    return found;
  });
}

function surface(canvas) {
  const scale = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  const w = Math.round(width * scale), h = Math.round(height * scale);
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  return [pen, width, height];
}

let styles = getComputedStyle(document.documentElement);
const colour = (name) => styles.getPropertyValue("--" + name).trim();

function drawTraces(data) {
  const view = new DataView(data), now = view.getFloat64(8, true), utc = view.getFloat64(16, true);
  if (view.getUint32(4, true) !== run) { run = view.getUint32(4, true); forget(); }
  let at = 24, last = 0;
  for (let k = view.getUint32(0, true); k > 0; k--) {
    const i = view.getUint32(at, true), channels = view.getUint32(at + 4, true), points = view.getUint32(at + 8, true);
    last = Math.max(last, view.getFloat64(at + 16, true));
    const parts = at + 24, base = parts + 8 * points, lows = base + 8 * channels, highs = lows + 4 * channels * points;
    at = highs + 4 * channels * points;
    if (!shown[i] || shown[i].traces.length !== channels) continue;
    shown[i].last = view.getFloat64(parts + 8 * (points - 1), true);
    for (let c = 0; c < channels; c++) {
      const one = shown[i].traces[c], zero = view.getFloat64(base + 8 * c, true);
      if (!one.kept || one.kept.size !== scale.points + 2) {
        one.kept = { size: scale.points + 2, part: new Float64Array(scale.points + 2).fill(-1), low: new Float64Array(scale.points + 2), high: new Float64Array(scale.points + 2), last: -1 };
      }
      for (let j = 0; j < points; j++) {
        const part = view.getFloat64(parts + 8 * j, true), n = part % one.kept.size;
        one.kept.part[n] = part;
        one.kept.low[n] = zero + view.getFloat32(lows + 4 * (c * points + j), true);
        one.kept.high[n] = zero + view.getFloat32(highs + 4 * (c * points + j), true);
        one.kept.last = part;
      }
    }
  }
  for (const one of shown) for (const each of one.traces) if (each.kept) trace(each, now);
  if (last > newest) {
    const stamps = [utc - (now - newest), utc - (now - last)], before = newest;
    newest = last;
    if (before) requestAnimationFrame(() => { drawn.push([(performance.timeOrigin + performance.now()) / 1000, ...stamps]); if (drawn.length > LATEST) drawn.shift(); });
  } else if (last && last < newest) newest = last;  // Another clock
}

function trace(one, now) {
  const box = one.canvas.getBoundingClientRect(), { size, part, low, high } = one.kept;
  if (box.bottom < 0 || box.top > window.innerHeight) return;  // Not in sight
  const first = Math.max(Math.floor(now / scale.width) - scale.points, one.kept.last - size + 1, 0);
  let least = Infinity, most = -Infinity;
  for (let p = first; p <= one.kept.last; p++) {
    const n = p % size;
    if (part[n] === p) { if (low[n] < least) least = low[n]; if (high[n] > most) most = high[n]; }
  }
  const [pen, width, height] = surface(one.canvas), room = most > least ? most - least : 1;
  const y = (value) => height - 4 - ((value - least) / room) * (height - 8) - (most > least ? 0 : (height - 8) / 2);
  pen.strokeStyle = colour("c" + one.hue);
  pen.beginPath();
  let before = -1;
  for (let p = first; p <= one.kept.last; p++) {
    const n = p % size, x = width * (1 - Math.max(now - (p + 1) * scale.width, 0) / scale.span);
    if (part[n] !== p || !(low[n] <= high[n]) || x < 0) continue;
    if (before >= 0 && (p - before) * scale.width < Math.max(one.gap, 1.5 * scale.width)) pen.lineTo(x, y(high[n])); else pen.moveTo(x, y(high[n]) - 0.5);
    pen.lineTo(x, y(low[n]) + 0.5);
    before = p;
  }
  pen.stroke();
  pen.font = "11px system-ui, sans-serif";
  if (most > least) for (const [value, under] of [[most, 12], [least, height - 2]]) {
    const text = short(value);
    pen.fillStyle = colour("paper");
    pen.fillRect(1, under - 11, pen.measureText(text).width + 5, 12);
    pen.fillStyle = colour("quiet");
    pen.fillText(text, 3, under - 1);
  }
  if (frames % VALUES) return;
  const last = one.kept.last % size;
  said(one.value, short(one.kept.last < 0 ? NaN : (low[last] + high[last]) / 2) + " " + one.unit);
}

function showNoise(told) {
  told.instruments.forEach((one, i) => {
    if (!one || !shown[i]) return;
    said(shown[i].basis, "Allan deviation and spectrum of the last " + one.samples.toLocaleString("en") + " samples, " + long(one.seconds));
    for (const { places, drawings } of shown[i].units) {
      curves(drawings[0], shown[i].hue, places, "averaging time [s]", one.tau, one.deviation, one.low, one.high);
      curves(drawings[1], shown[i].hue, places, "frequency [Hz]", one.frequency, one.density);
    }
  });
}

function curves(canvas, hue, places, axis, xs, all, lows, highs) {
  const [pen, width, height] = surface(canvas), left = 48, under = 34;
  const values = places.flatMap((i) => (all[i] || []).filter((one) => one > 0));
  pen.font = "11px system-ui, sans-serif";
  pen.fillStyle = colour("quiet");
  if (!values.length) { pen.fillText("nothing that varies yet", 8, 16); return; }
  const spread = (list) => { const a = Math.log10(Math.min(...list)), b = Math.log10(Math.max(...list)); return b - a < 0.5 ? [(a + b) / 2 - 0.25, (a + b) / 2 + 0.25] : [a, b]; };
  const [x0, x1] = spread(xs), [y0, y1] = spread(values);
  const px = (x) => left + ((Math.log10(x) - x0) / (x1 - x0)) * (width - left - 8);
  const py = (y) => height - under - 4 - ((Math.log10(y) - y0) / (y1 - y0)) * (height - under - 12);
  const ticks = (a, b) => {
    const found = [], decades = [];
    for (let d = Math.floor(a); d <= Math.ceil(b); d++) { decades.push(10 ** d); for (const m of [1, 2, 5]) found.push(m * 10 ** d); }
    const inside = (list) => list.filter((one) => Math.log10(one) >= a - 1e-9 && Math.log10(one) <= b + 1e-9);
    const some = inside(decades), step = Math.ceil(some.length / 6);
    return some.length > 1 ? some.filter((_, i) => i % step === 0) : inside(found);
  };
  const label = (x) => (x >= 0.01 && x < 1e4 ? String(+x.toPrecision(3)) : x.toExponential(0));
  pen.strokeStyle = colour("line");
  pen.beginPath();
  for (const x of ticks(x0, x1)) { pen.moveTo(px(x), 4); pen.lineTo(px(x), height - under); pen.textAlign = "center"; pen.fillText(label(x), Math.min(px(x), width - 14), height - 20); }
  for (const y of ticks(y0, y1)) { pen.moveTo(left, py(y)); pen.lineTo(width, py(y)); pen.textAlign = "right"; pen.fillText(label(y), left - 4, Math.max(py(y) + 4, 11)); }
  pen.stroke();
  pen.textAlign = "center";
  pen.fillText(axis, (left + width) / 2, height - 5);
  for (const i of places) {
    pen.strokeStyle = colour("c" + hue[i]);
    pen.beginPath();
    let before = false;
    xs.forEach((x, j) => {
      const y = (all[i] || [])[j];
      if (!(y > 0)) { before = false; return; }
      if (before) pen.lineTo(px(x), py(y)); else pen.moveTo(px(x), py(y));
      before = true;
      if (lows && lows[i][j] > 0 && highs[i][j] > 0) { pen.moveTo(px(x), py(lows[i][j])); pen.lineTo(px(x), py(highs[i][j])); pen.moveTo(px(x), py(y)); }
    });
    pen.stroke();
  }
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { styles = getComputedStyle(document.documentElement); });
connect();
