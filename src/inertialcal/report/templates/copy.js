"use strict";
(function () {
  var root = document.documentElement;
  root.classList.add("script");
  var said = document.getElementById("said");
  function tell(button, what) {
    var old = button.textContent;
    button.textContent = what;
    said.textContent = what + ": " + (button.getAttribute("aria-label") || old);
    setTimeout(function () { button.textContent = old; }, 1500);
  }
  function textOf(button) {
    var from = button.getAttribute("data-from");
    return from ? document.getElementById(from).textContent : button.getAttribute("data-copy");
  }
  function selected(text) {
    var area = document.createElement("textarea");
    area.value = text;
    area.setAttribute("readonly", "");
    area.className = "aside";
    document.body.appendChild(area);
    area.select();
    var done = document.execCommand("copy");
    area.remove();
    return done;
  }
  document.addEventListener("click", function (event) {
    var button = event.target.closest("button.copy, button.save");
    if (!button) { return; }
    var text = textOf(button);
    if (button.classList.contains("save")) {
      var link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
      link.download = button.getAttribute("data-name");
      link.click();
      setTimeout(function () { URL.revokeObjectURL(link.href); }, 10000);
      tell(button, "saved");
      return;
    }
    if (navigator.clipboard && navigator.clipboard.writeText) {
      navigator.clipboard.writeText(text).then(
        function () { tell(button, "copied"); },
        function () { tell(button, selected(text) ? "copied" : "not copied"); });
    } else {
      tell(button, selected(text) ? "copied" : "not copied");
    }
  });
  var contents = document.querySelector("#contents details");
  var wide = window.matchMedia("(min-width: 68rem)");
  function fit() { contents.open = wide.matches; }
  fit();
  wide.addEventListener("change", fit);
})();
