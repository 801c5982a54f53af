// The player: a slider that is the cursor for the keyboard, and a button that moves it.
(() => {
  const { element } = torquebench;
  const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
  const CALM = 250;

  // Plays from start to stop [s]; `seek` is told of every new time.
  torquebench.player = ({ start, stop, step, seek }) => {
    const calm = matchMedia("(prefers-reduced-motion: reduce)");
    let playing = false, time = start, drawn = 0;
    const options = SPEEDS.map((speed) => element("option", { value: speed, selected: speed === 1 }, `${speed} \u00d7`));
    const speed = element("select", {}, ...options);
    const shown = element("output", { class: "time" });
    const slider = element("input", {
      type: "range", min: start, max: stop, step, value: start, "aria-label": "Time",
      input: () => seek(Number(slider.value)),
    });

    const play = (wanted) => {
      playing = wanted;
      button.textContent = playing ? "Pause" : "Play";
    };
    const tick = (now) => {
      // A panel that was closed plays no more.
      if (!playing || !button.isConnected) { play(false); return; }
      // Whoever asked for less motion gets four pictures a second.
      if (!calm.matches || now - drawn >= CALM) {
        const next = Math.min(stop, time + ((now - drawn) / 1000) * Number(speed.value));
        drawn = now;
        seek(next);
        if (next >= stop) play(false);
      }
      if (playing) requestAnimationFrame(tick);
    };
    const press = () => {
      play(!playing);
      if (!playing) return;
      if (time >= stop - step) time = start;
      drawn = performance.now();
      requestAnimationFrame(tick);
    };
    const button = element("button", { type: "button", class: "play", click: press }, "Play");
    const node = element("div", { class: "controls player" }, button, slider, shown, element("label", {}, "Speed ", speed));
    const show = (at) => {
      time = at;
      slider.value = at;
      shown.textContent = `${at.toFixed(2)} s`.replace("-", "\u2212");
    };
    return { node, show };
  };
})();
