(() => {
  const place = (id) => document.getElementById(id), box = place("operator");
  const say = (word) => { if (line && line.readyState === 1) line.send("operator " + word); };
  for (const word of ["done", "pause", "go", "stop"]) place("say-" + word).onclick = () => {
    if (word !== "stop" || confirm("Stop the sequence? All that moves is brought to its safe state."))
      say(word === "done" ? "done " + number : word);  // a second click is not for the next prompt
  };
  let line = null, timer = 0, number = 0;
  const connect = () => {
    line = new WebSocket("ws://" + location.host + "/live" + location.search);
    line.onopen = () => say("look");
    line.onmessage = (event) => {
      const told = JSON.parse(event.data);
      number = told.number;
      place("asked").textContent = told.asked || (told.paused ? "Paused" : "");
      place("say-done").hidden = !told.asked;
      place("say-pause").hidden = told.paused;
      place("say-go").hidden = !told.paused;
      document.title = (told.asked ? "DO: " + told.asked + " - " : "") + "inertialcal sequence";
      box.hidden = false;
      timer = setTimeout(() => say("look"), 500);
    };
    line.onclose = () => { clearTimeout(timer); box.hidden = true; setTimeout(connect, 1000); };
  };
  connect();
})();
