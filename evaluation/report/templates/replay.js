// The replay: arms as capsules on a canvas, seen from afar, with the reference path and the path of each tool point.
(() => {
  const { element } = torquebench;
  const HEIGHT = 380;

  const colour = (node, name) => getComputedStyle(node).getPropertyValue(name).trim();

  // A view from yaw and pitch: right, up, and towards the eye.
  const viewOf = ({ yaw, pitch }) => {
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return ([x, y, z]) => [-sy * x + cy * y, -sp * (cy * x + sy * y) + cp * z, cp * (cy * x + sy * y) + sp * z];
  };

  // Draws actors {skeleton, frames, planned, style, ghost, ...}; the first is the run of the panel.
  torquebench.replay = () => {
    const canvas = element("canvas", {
      tabindex: 0, role: "img", class: "replay",
      "aria-label": "Replay of the arm. Arrow keys turn it, plus and minus zoom, 0 goes back.",
    });
    const home = { yaw: -0.9, pitch: 0.35, zoom: 1 };
    const camera = { ...home };
    let actors = [], time = 0, magnified = 1, centre = [0, 0, 0.4], size = 1.2;

    const drawLine = (context, points, place, style, width, dash = []) => {
      context.strokeStyle = style;
      context.lineWidth = width;
      context.setLineDash(dash);
      context.beginPath();
      points.forEach((point, i) => { const [x, y] = place(point); if (i) context.lineTo(x, y); else context.moveTo(x, y); });
      context.stroke();
      context.setLineDash([]);
    };
    const drawFloor = (context, place) => {
      const line = colour(canvas, "--line");
      for (let i = -3; i <= 3; i += 1) {
        drawLine(context, [[-0.6, 0.2 * i, 0], [0.6, 0.2 * i, 0]], place, line, 1);
        drawLine(context, [[0.2 * i, -0.6, 0], [0.2 * i, 0.6, 0]], place, line, 1);
      }
    };
    const drawArm = (context, capsules, place, scale, fill, edge) => {
      // Nearer capsules hide those behind: each is drawn with its edge, the farthest first.
      const placed = capsules.map(({ start, end, radius }) => ({ a: place(start), b: place(end), radius }));
      placed.sort((one, other) => one.a[2] + one.b[2] - other.a[2] - other.b[2]);
      context.lineCap = "round";
      for (const { a, b, radius } of placed) {
        for (const [style, width] of [[edge, 2 * radius * scale], [fill, 2 * radius * scale - 3]]) {
          context.strokeStyle = style;
          context.lineWidth = Math.max(1, width);
          context.beginPath();
          context.moveTo(a[0], a[1]);
          context.lineTo(b[0] + 0.01, b[1]);
          context.stroke();
        }
      }
    };
    // Joint deviations may be shown larger than they are: millimetres cannot be seen on an arm of a metre.
    const posture = ({ frames, planned }, i) => frames[i].map((value, k) => planned[i][k] + magnified * (value - planned[i][k]));
    const pathOf = (actor) => actor.frames.map((_, i) => torquebench.toolPoint(actor.skeleton, posture(actor, i)));
    const trace = () => { for (const actor of actors) actor.path = pathOf(actor); };
    const capsulesOf = (actor) => torquebench.capsules(actor.skeleton, posture(actor, actor.frameNumber(time)));
    const shade = (actor) => colour(canvas, `--s${actor.style % 6}`);

    const draw = () => {
      const ratio = window.devicePixelRatio || 1;
      const width = canvas.clientWidth || 460;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(HEIGHT * ratio);
      const context = canvas.getContext("2d");
      context.scale(ratio, ratio);
      context.clearRect(0, 0, width, HEIGHT);
      if (!actors.length) return;
      const view = viewOf(camera), middle = view(centre);
      const scale = (camera.zoom * Math.min(width, HEIGHT)) / size;
      const place = (point) => {
        const [right, up, near] = view(point);
        return [width / 2 + scale * (right - middle[0]), HEIGHT / 2 - scale * (up - middle[1]), near];
      };
      drawFloor(context, place);
      for (const actor of [...actors].reverse()) {
        context.globalAlpha = actor.ghost ? 0.35 : 1;
        if (time <= actor.stop) drawArm(context, capsulesOf(actor), place, scale, shade(actor), colour(canvas, "--page"));
      }
      context.globalAlpha = 1;
      // The run of the panel hides what differs from it by a millimetre: ghosts show their axes through it.
      for (const actor of actors.filter(({ ghost, stop }) => ghost && time <= stop)) {
        for (const { start, end } of capsulesOf(actor)) {
          drawLine(context, [start, end], place, colour(canvas, "--page"), 5);
          drawLine(context, [start, end], place, shade(actor), 3);
        }
      }
      drawLine(context, actors[0].reference, place, colour(canvas, "--text"), 1.5, [5, 4]);
      for (const actor of [...actors].reverse()) {
        const past = actor.path.slice(0, actor.frameNumber(time) + 1);
        drawLine(context, past, place, colour(canvas, "--page"), 4);
        drawLine(context, past, place, shade(actor), 2);
      }
    };

    const turn = (yaw, pitch, zoom) => {
      camera.yaw += yaw;
      camera.pitch = Math.min(1.5, Math.max(-1.5, camera.pitch + pitch));
      camera.zoom = Math.min(20, Math.max(0.3, camera.zoom * zoom));
      draw();
    };
    const reset = () => { Object.assign(camera, home); draw(); };
    const keys = {
      ArrowLeft: () => turn(-0.1, 0, 1), ArrowRight: () => turn(0.1, 0, 1), ArrowUp: () => turn(0, 0.1, 1),
      ArrowDown: () => turn(0, -0.1, 1), "-": () => turn(0, 0, 1 / 1.2), "+": () => turn(0, 0, 1.2),
      "=": () => turn(0, 0, 1.2), 0: reset,
    };
    canvas.addEventListener("keydown", (event) => {
      if (keys[event.key] && !event.ctrlKey && !event.metaKey && !event.altKey) { event.preventDefault(); keys[event.key](); }
    });
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      turn((held[0] - event.clientX) * 0.01, (event.clientY - held[1]) * 0.01, 1);
      held = [event.clientX, event.clientY];
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { held = null; });
    new ResizeObserver(draw).observe(canvas);
    new MutationObserver(draw).observe(document.documentElement, { attributes: true });
    // Paper has colours of its own.
    for (const query of ["(prefers-color-scheme: dark)", "print"]) matchMedia(query).addEventListener("change", draw);

    const fit = () => {
      const { reference, skeleton, planned } = actors[0];
      const arm = torquebench.capsules(skeleton, planned[0]).flatMap(({ start, end }) => [start, end]);
      const points = [...reference, ...arm, [0, 0, 0]].filter((point) => point.every(Number.isFinite));
      const limits = (pick) => [0, 1, 2].map((k) => pick(...points.map((point) => point[k])));
      const low = limits(Math.min), high = limits(Math.max);
      centre = low.map((value, k) => (value + high[k]) / 2);
      size = 1.15 * Math.hypot(...low.map((value, k) => high[k] - value));
    };
    const moves = [
      ["\u2190", "Turn left", -0.2, 0, 1], ["\u2192", "Turn right", 0.2, 0, 1], ["\u2191", "Look from higher", 0, 0.15, 1],
      ["\u2193", "Look from lower", 0, -0.15, 1], ["+", "Nearer", 0, 0, 1.25], ["\u2212", "Farther", 0, 0, 0.8],
    ];
    const buttons = moves.map(([text, label, ...move]) => (
      element("button", { type: "button", "aria-label": label, title: label, click: () => turn(...move) }, text)
    ));
    buttons.push(element("button", { type: "button", click: reset }, "Reset view"));
    const controls = element("p", { class: "controls" }, ...buttons);
    return {
      canvas, controls,
      cast: (found) => { actors = found; trace(); fit(); draw(); },
      show: (at) => { time = at; draw(); },
      magnify: (factor) => { magnified = factor; trace(); draw(); },
    };
  };
})();
