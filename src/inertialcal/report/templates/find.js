"use strict";
(function () {
  var data = JSON.parse(document.getElementById("data").textContent);
  var box = document.getElementById("serial"), shown = document.getElementById("unit");
  function made(name, text, parent, kind) {
    var one = document.createElement(name);
    if (text !== undefined) { one.textContent = text; }
    if (kind) { one.className = kind; }
    if (parent) { parent.appendChild(one); }
    return one;
  }
  function table(unit) {
    var frame = made("div", undefined, undefined, "scroll");
    frame.tabIndex = 0;
    var whole = made("table", undefined, frame);
    made("caption", unit.serial + ": " + unit.about, whole);
    var head = made("tr", undefined, made("thead", undefined, whole));
    ["figure", "test", "value", "u", "unit", "from the mean", "limits"].forEach(function (name, i) {
      made("th", name, head, i > 1 && i !== 4 ? "n" : "").scope = "col";
    });
    var body = made("tbody", undefined, whole);
    data.figures.forEach(function (one, i) {
      if (unit.values[i] === null) { return; }
      var row = made("tr", undefined, body), far = one.sd ? (unit.values[i] - one.mean) / one.sd : null;
      made("th", one.name, row).scope = "row";
      made("td", one.test, row);
      made("td", String(unit.values[i]), row, "n");
      made("td", unit.u[i] === null ? "" : String(unit.u[i]), row, "n");
      made("td", one.unit, row);
      made("td", far === null ? "" : far.toFixed(1) + " s", row, "n");
      made("td", one.limits, row, "n");
    });
    return frame;
  }
  function find() {
    var asked = box.value.trim().toLowerCase();
    shown.textContent = "";
    if (!asked) { return; }
    var found = data.units.filter(function (one) { return one.serial.toLowerCase() === asked; });
    if (!found.length) {
      found = data.units.filter(function (one) { return one.serial.toLowerCase().indexOf(asked) >= 0; });
      if (found.length > 1) {
        made("p", found.length + " units: " + found.slice(0, 20).map(function (one) { return one.serial; }).join(", ") +
          (found.length > 20 ? ", ..." : ""), shown);
        return;
      }
    }
    if (!found.length) { made("p", "no such unit on this page", shown); return; }
    found.forEach(function (one) { shown.appendChild(table(one)); });
  }
  document.getElementById("find").addEventListener("click", find);
  box.addEventListener("keydown", function (event) { if (event.key === "Enter") { find(); } });
})();
