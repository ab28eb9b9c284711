"use strict";
// Asks for the state each STATE [ms], or sends what a phone's sensors said meanwhile; one question at a time is open.
const STATE = 100, AGAIN = 500, SILENT = 5000, NUMBERS = 7, MOST = 500;
const place = (id) => document.getElementById(id);
const said = (one, text, kind) => {  // What does not change is not written: readers of screens would say it again
  if (one.textContent !== text) one.textContent = text;
  if (kind !== undefined && one.className !== kind) one.className = kind;
};
let web = null, heard = 0, timer = 0, wish = "", samples = [], known = null, pose = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], ending = false;

function connect() {
  web = new WebSocket("ws://" + location.host + "/live" + location.search);
  heard = performance.now();
  web.onopen = ask;
  web.onmessage = (event) => {
    heard = performance.now();
    show(JSON.parse(event.data));
    timer = setTimeout(ask, STATE);
  };
  web.onclose = () => {
    clearTimeout(timer);
    const over = known && known.phase === "done";
    said(place("link"), over ? "ended" : "not connected, trying again; what is shown is old", over ? "" : "bad");
    if (!over) setTimeout(connect, AGAIN);
  };
}
setInterval(() => { if (web.readyState === 1 && performance.now() - heard > SILENT) web.close(); }, 1000);

function ask() {
  if (web.readyState !== 1) return;
  if (wish) { web.send(wish); wish = ""; return; }
  if (!samples.length) { web.send("state"); return; }
  const sent = new Float64Array(samples.splice(0, MOST).flat());  // Little endian on every machine that has a browser
  web.send(sent.buffer);
}

function show(told) {
  known = told;
  said(place("title"), told.title || "Guided calibration");
  said(place("link"), "connected", "good");
  said(place("word"), told.word, told.code);
  said(place("text"), told.text);
  if (place("said").textContent !== told.word + ". " + told.said) {
    said(place("said"), told.word + ". " + told.said);
    speak(told.word + ". " + told.said);
  }
  place("fill").style.width = Math.round(100 * told.fill) + "%";
  place("rest").setAttribute("aria-valuenow", Math.round(100 * told.fill));
  place("rest").setAttribute("aria-valuetext", told.still ? "at rest" : "moving");
  const going = told.phase === "guiding" && told.to_go !== null ? ", about " + told.to_go + " to go" : "";
  const state = told.code === "waiting" ? "No samples yet" : told.still ? "At rest" : "Moving";
  said(place("count"), state + " \u00b7 " + told.positions + (told.positions === 1 ? " position" : " positions") + going);
  said(place("temperature"), told.temperature);
  said(place("lies"), told.lies);
  said(place("next"), told.next);
  place("now").setAttribute("aria-label", told.lies ? "now: " + told.lies : "not known how it lies");
  place("then").setAttribute("aria-label", told.next ? "next: " + told.next : "no next position yet");
  pictures(told);
  figures(told);
  list(place("notices"), told.notices.length ? told.notices.slice(-8).reverse() : ["none so far"]);
  list(place("written"), Object.entries(told.written).map(([what, where]) => what + ": " + where));
  place("undo").disabled = told.phase !== "guiding" || !told.positions;
  place("finish").disabled = told.phase === "working" || told.phase === "done";
  place("phone").hidden = !told.phone || sensing || !window.DeviceMotionEvent;
  if (told.phone && window.isSecureContext && !window.DeviceMotionEvent) said(place("sensors"), "This browser gives no motion sensors: open the address in Chrome, Firefox or Safari on the phone", "bad");
  if (told.phone && !window.isSecureContext) said(place("sensors"), "A browser gives no sensors to this address: open it as localhost, as the manual says", "bad");
}

function list(parent, texts) {
  const same = JSON.stringify(texts);
  if (parent.same === same) return;
  parent.same = same;
  parent.replaceChildren(...texts.map((text) => { const one = document.createElement("li"); one.textContent = text; return one; }));
}

function figures(told) {
  const same = JSON.stringify([told.figures, told.positions]);
  if (figures.same === same) return;
  figures.same = same;
  const rows = told.figures.map((one) => {
    const row = document.createElement("tr"), head = row.appendChild(document.createElement("th"));
    head.scope = "row";
    head.textContent = one.name;
    const value = row.insertCell(), wanted = row.insertCell();
    value.textContent = one.value === "-" ? "not known yet" : one.value + " " + one.unit;
    value.className = "number";
    wanted.textContent = !one.asked ? "" : one.reached ? "reached" : one.ratio === null ? "not yet" : one.ratio.toPrecision(2) + " times as wide";
    wanted.className = one.reached ? "good" : "";
    return row;
  });
  place("figures").replaceChildren(...rows);
  chart(told);
}

const SVG = "http://www.w3.org/2000/svg";
function drawn(parent, name, given, text) {
  const one = parent.appendChild(document.createElementNS(SVG, name));
  for (const [key, value] of Object.entries(given)) one.setAttribute(key, value);
  if (text !== undefined) one.textContent = text;
  return one;
}

// Uncertainty over what was asked for, after each position: 1 is reached.
function chart(told) {
  const svg = place("chart"), left = 44, right = 350, top = 10, under = 184;
  svg.replaceChildren();
  const all = Object.values(told.history).flat().filter((x) => x !== null && x > 0);
  const most = Math.max(10, ...all), least = Math.min(0.3, ...all), last = Math.max(told.positions, 14), first = 1;
  const px = (n) => left + ((n - first) / (last - first)) * (right - left);
  const py = (x) => top + ((Math.log10(most) - Math.log10(x)) / (Math.log10(most) - Math.log10(least))) * (under - top);
  for (let d = Math.ceil(Math.log10(least)); d <= Math.floor(Math.log10(most)); d++) {
    const y = py(10 ** d);
    drawn(svg, "line", { x1: left, x2: right, y1: y, y2: y, stroke: d ? "var(--line)" : "var(--ink)", "stroke-width": d ? 1 : 1.5 });
    drawn(svg, "text", { x: left - 5, y: y + 4, "text-anchor": "end", "font-size": 11, fill: "var(--quiet)" }, d < 3 && d > -3 ? String(10 ** d) : "1e" + d);
  }
  drawn(svg, "text", { x: left + 4, y: py(1) - 4, "font-size": 11, fill: "var(--ink)" }, "asked for");
  for (let n = first; n <= last; n += Math.max(1, Math.ceil((last - first) / 7)))
    drawn(svg, "text", { x: px(n), y: under + 15, "text-anchor": "middle", "font-size": 11, fill: "var(--quiet)" }, n);
  drawn(svg, "text", { x: (left + right) / 2, y: under + 31, "text-anchor": "middle", "font-size": 11, fill: "var(--quiet)" }, "positions");
  for (const [name, past] of Object.entries(told.history)) {
    const kind = ["bias", "scale factor", "misalignment"].findIndex((one) => name.replace("gyro ", "").startsWith(one));
    const points = past.map((x, n) => (x === null ? null : [px(n), py(x)])).filter((one) => one !== null);
    if (!points.length) continue;
    drawn(svg, "polyline", { points: points.map((one) => one.map((x) => x.toFixed(1)).join(",")).join(" "), fill: "none", stroke: "var(--c" + kind + ")", "stroke-width": 1.5 });
    drawn(svg, "circle", { cx: points.at(-1)[0], cy: points.at(-1)[1], r: 2.5, fill: "var(--c" + kind + ")" });
  }
  if (!all.length) drawn(svg, "text", { x: (left + right) / 2, y: 90, "text-anchor": "middle", "font-size": 13, fill: "var(--quiet)" }, "nothing yet: nine positions, and four more");
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const turned = (m, v) => m.map((row) => dot(row, v));

// The pose, body to room, nearest to another one in which a direction of the body points up: by the shortest turn.
function upright(from, direction) {
  const a = turned(from, direction), v = cross(a, [0, 0, 1]), s = Math.hypot(...v), c = a[2];
  let k = s > 1e-6 ? v.map((x) => x / s) : [1, 0, 0];
  const angle = Math.atan2(s, c), sin = Math.sin(angle), cos = Math.cos(angle);
  return [0, 1, 2].map((i) => [0, 1, 2].map((j) => {
    const column = from.map((row) => row[j]), across = cross(k, column);
    return column[i] * cos + across[i] * sin + k[i] * dot(k, column) * (1 - cos);
  }));
}

const HALF = [58, 40, 16], TILT = 0.42, SIDE = 0.5;  // A flat box; how the room is looked at [rad]
function seen(point) {
  const x = point[0] * Math.cos(SIDE) - point[1] * Math.sin(SIDE), y = point[0] * Math.sin(SIDE) + point[1] * Math.cos(SIDE);
  return [x, -(point[2] * Math.cos(TILT) + y * Math.sin(TILT)), y * Math.cos(TILT) - point[2] * Math.sin(TILT)];
}

function box(svg, m, direction, labels) {
  svg.replaceChildren();
  const faces = [];
  for (let axis = 0; axis < 3; axis++) for (const sign of [1, -1]) {
    const normal = [0, 0, 0], a = (axis + 1) % 3, b = (axis + 2) % 3;
    normal[axis] = sign;
    const corners = [[1, 1], [1, -1], [-1, -1], [-1, 1]].map(([p, q]) => {
      const one = [0, 0, 0];
      one[axis] = sign * HALF[axis]; one[a] = p * HALF[a]; one[b] = q * HALF[b];
      return seen(turned(m, one));
    });
    const name = "xyz"[axis] + (sign > 0 ? "+" : "-"), towards = seen(turned(m, normal))[2] < -1e-6;
    faces.push({ corners, towards, name, up: turned(m, normal)[2], middle: seen(turned(m, normal.map((n, i) => n * HALF[i]))), size: Math.min(HALF[a], HALF[b]) });
  }
  drawn(svg, "ellipse", { cx: 0, cy: 62, rx: 92, ry: 26, fill: "var(--line)", opacity: 0.5 });  // The table
  const highest = Math.max(...faces.map((one) => one.up));
  for (const one of faces.filter((face) => face.towards)) {
    drawn(svg, "polygon", { points: one.corners.map((p) => p[0].toFixed(1) + "," + p[1].toFixed(1)).join(" "), fill: one.up > highest - 0.05 ? "var(--up)" : "var(--face)", stroke: "var(--ink)", "stroke-width": 1.5, "stroke-linejoin": "round" });
    if (labels[one.name] && one.size > 20) drawn(svg, "text", { x: one.middle[0], y: one.middle[1] + 4, "text-anchor": "middle", "font-size": 12, fill: "var(--ink)" }, labels[one.name].slice(0, 16));
  }
  [0, 1, 2].forEach((axis) => {
    const end = [0, 0, 0], begin = [0, 0, 0];
    end[axis] = HALF[axis] + 26; begin[axis] = HALF[axis];
    const p = seen(turned(m, begin)), q = seen(turned(m, end)), out = seen(turned(m, end.map((x) => (x ? 1 : 0))));
    const length = Math.hypot(q[0] - p[0], q[1] - p[1]), colour = "var(--" + "xyz"[axis] + ")", hidden = out[2] > 1e-6;
    drawn(svg, "line", { x1: p[0], y1: p[1], x2: q[0], y2: q[1], stroke: colour, "stroke-width": 3, "stroke-dasharray": hidden ? "4 3" : "none" });
    if (length > 4) {
      const ux = (q[0] - p[0]) / length, uy = (q[1] - p[1]) / length;
      drawn(svg, "polygon", { points: [[q[0] + 7 * ux, q[1] + 7 * uy], [q[0] - 5 * uy, q[1] + 5 * ux], [q[0] + 5 * uy, q[1] - 5 * ux]].map((r) => r.join(",")).join(" "), fill: colour });
    } else drawn(svg, "circle", { cx: q[0], cy: q[1], r: 5, fill: colour });
    const far = length > 4 ? [q[0] + (15 * (q[0] - p[0])) / length, q[1] + (15 * (q[1] - p[1])) / length + 5] : [q[0] + 12, q[1] - 6];
    drawn(svg, "text", { x: far[0], y: far[1], "text-anchor": "middle", "font-size": 15, "font-weight": 700, fill: colour }, "xyz"[axis]);
  });
  drawn(svg, "path", { d: "M -98 30 V -70 M -104 -60 L -98 -72 L -92 -60", fill: "none", stroke: "var(--quiet)", "stroke-width": 2 });
  drawn(svg, "text", { x: -98, y: -80, "text-anchor": "middle", "font-size": 12, fill: "var(--quiet)" }, "up");
}

function pictures(told) {
  const round = (v) => v && v.map((x) => Math.round(50 * x));
  const same = JSON.stringify([round(told.up), told.target, told.labels]);
  if (pictures.same === same) return;
  pictures.same = same;
  if (told.up) { pose = upright(pose, told.up); box(place("now"), pose, told.up, told.labels); } else place("now").replaceChildren();
  if (told.target) box(place("then"), upright(pose, told.target), told.target, told.labels); else place("then").replaceChildren();
}

function speak(text) {
  if (!place("aloud").checked || !window.speechSynthesis) return;
  speechSynthesis.cancel();
  speechSynthesis.speak(new SpeechSynthesisUtterance(text));
}

// Who presses the button looks at the screen, so z points up: some browsers give gravity in place of specific force.
// Of gravity some browsers give the force that holds the phone, others, as on iPhones, the opposite: up at the screen is
// taken as up from the first FIRST samples. More than 25 deg off, nobody can tell which it is.
const FIRST = 10, FLAT = 0.9, HIDDEN = 2000;
const ALLOW = "iPhone: close this page and the browser, open the address again, and choose Allow. Android: allow motion sensors in the settings of this site, at the left of the address, and load the page again";
let sensing = false, listening = false, last = -1, sign = 0, first = [], without = false;
async function sense() {
  try {  // Some browsers ask the person, and only when a button was pressed
    if (DeviceMotionEvent.requestPermission && (await DeviceMotionEvent.requestPermission()) !== "granted") {
      said(place("sensors"), "The phone does not allow its sensors. " + ALLOW, "bad");
      return;
    }
  } catch (error) {
    said(place("sensors"), "The phone does not give its sensors (" + error.message + "). " + ALLOW, "bad");
    return;
  }
  sensing = true;
  first = [];
  place("phone").hidden = true;
  if (!listening) window.addEventListener("devicemotion", moved);
  listening = true;
  setTimeout(() => {
    if (last >= 0) return;
    said(place("sensors"), without ? "This device has no gyros, or its browser keeps them back: record it by an app, and give its file to inertialcal positions"
      : "This device sends no motion: it has no sensors, or its browser keeps them back. " + ALLOW, "bad");
  }, HIDDEN);
  if (navigator.wakeLock) navigator.wakeLock.request("screen").catch(() => {});
}

function moved(event) {
  const f = event.accelerationIncludingGravity, w = event.rotationRate, t = event.timeStamp;
  if (!sensing || !f || f.x === null || t <= last) return;
  if (!w || w.alpha === null) { without = true; return; }
  last = t;
  if (!sign) {
    first.push([f.x, f.y, f.z]);
    if (first.length < FIRST) return;
    const [x, y, z] = [0, 1, 2].map((i) => first.reduce((sum, one) => sum + one[i], 0));
    if (Math.abs(z) < FLAT * Math.hypot(x, y, z)) {  // The button comes back
      sensing = false;
      said(place("sensors"), "The phone does not lie flat: lay it down with its screen up, and press again", "bad");
      return;
    }
    sign = z < 0 ? -1 : 1;
  }
  samples.push([t, sign * f.x, sign * f.y, sign * f.z, w.alpha, w.beta, w.gamma]);
  if (samples.length > 4 * MOST) samples.shift();
  if (samples.length === 1) said(place("sensors"), "The sensors of this phone are used: keep the page open, and the screen on", "");
}

place("phone").addEventListener("click", sense);
place("undo").addEventListener("click", () => { wish = "undo"; });
place("finish").addEventListener("click", () => {
  if (ending) { wish = "finish"; return; }
  ending = true;
  said(place("finish"), "Press again to end");
  setTimeout(() => { ending = false; said(place("finish"), "End now (F)"); }, 4000);
});
place("aloud").addEventListener("change", () => { if (known) speak(known.word + ". " + known.said); });
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const key = event.key.toLowerCase();
  if (key === "u" && !place("undo").disabled) place("undo").click();
  if (key === "f" && !place("finish").disabled) place("finish").click();
  if (key === "s") place("aloud").click();
});
connect();
