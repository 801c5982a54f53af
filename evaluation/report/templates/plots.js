// Curves over time as SVG, which prints and takes the page's colours, with a cursor that others may move.
(() => {
  const { element } = torquebench;
  const WIDTH = 460, HEIGHT = 124, LEFT = 46, RIGHT = 10, TOP = 10, BOTTOM = 22;

  const ticks = (low, high, most) => {
    const size = 10 ** Math.floor(Math.log10(high - low || 1));
    const step = [0.1, 0.2, 0.25, 0.5, 1, 2].map((part) => part * size).find((one) => (high - low) / one <= most) || size;
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) found.push(i * step);
    return found;
  };
  const text = (value) => String(Number(value.toPrecision(4))).replace("-", "\u2212");
  const range = (curves) => {
    let low = 0, high = 0;
    for (const { values } of curves) {
      for (const value of values) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    return high > low ? [low, high + 0.04 * (high - low)] : [low, low + 1];
  };
  const nearest = (times, time) => {
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    return time - times[low] < times[high] - time ? low : high;
  };
  // Colour and dash: each alone tells the curves apart.
  const DASHES = [undefined, "7 3", "2 2", "9 3 2 3", "4 2", "1 3", "12 4"];
  const stroke = (style) => ({ class: `curve s${style % 6}`, "stroke-dasharray": DASHES[style % DASHES.length] });

  // Draws curves {label, style, times, values} from start to stop; `seek` is told of a time that is pointed at.
  torquebench.plot = ({ title, unit, start, stop, events, seek }) => {
    const x = (time) => LEFT + ((WIDTH - LEFT - RIGHT) * (time - start)) / (stop - start || 1);
    const drawing = element("svg", {
      class: "lines", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": `${title} over time`,
    });
    const legend = element("p", { class: "legend" });
    const node = element("figure", { class: "plot" }, element("figcaption", {}, `${title} [${unit}]`), drawing, legend);
    const cursor = element("path", { class: "cursor" });
    let shown = [];

    const point = (event) => {
      const box = drawing.getBoundingClientRect();
      const place = ((event.clientX - box.left) / box.width) * WIDTH;
      seek(Math.min(stop, Math.max(start, start + ((place - LEFT) / (WIDTH - LEFT - RIGHT)) * (stop - start))));
    };
    drawing.addEventListener("pointerdown", point);
    drawing.addEventListener("pointermove", (event) => { if (event.pointerType === "mouse" || event.buttons) point(event); });

    const draw = (curves) => {
      const [low, high] = range(curves);
      const y = (value) => HEIGHT - BOTTOM - ((HEIGHT - TOP - BOTTOM) * (value - low)) / (high - low);
      drawing.replaceChildren();
      for (const value of ticks(low, high, 5)) {
        drawing.append(element("path", { class: "grid", d: `M${LEFT} ${y(value)}H${WIDTH - RIGHT}` }));
        drawing.append(element("text", { class: "tick", x: LEFT - 5, y: y(value) + 4, "text-anchor": "end" }, text(value)));
      }
      for (const time of ticks(start, stop, 8)) {
        drawing.append(element("text", { class: "tick", x: x(time), y: HEIGHT - 6, "text-anchor": "middle" }, `${text(time)} s`));
      }
      if (start < 0) {
        const width = x(0) - x(start);
        const place = { class: "lead-in", x: x(start), y: TOP, width, height: HEIGHT - TOP - BOTTOM };
        drawing.prepend(element("rect", place, element("title", {}, "lead-in, not scored")));
      }
      for (const [time, what] of events) {
        drawing.append(element("path", { class: "event", d: `M${x(time)} ${TOP}V${HEIGHT - BOTTOM}` }));
        drawing.append(element("text", { class: "tick", x: x(time) + 3, y: TOP + 8 }, what));
      }
      // The first curve is what the panel is about: it is drawn last, on top.
      for (const { style, times, values } of [...curves].reverse()) {
        let path = "", pen = "M";
        values.forEach((value, i) => {
          if (Number.isNaN(value)) { pen = "M"; return; }
          path += `${pen}${x(times[i]).toFixed(1)} ${y(value).toFixed(1)}`;
          pen = "L";
        });
        drawing.append(element("path", { ...stroke(style), d: path }));
      }
      drawing.append(cursor);
      shown = curves.map((curve) => {
        const value = element("b");
        const line = element("path", { ...stroke(curve.style), d: "M0 5h24" });
        const sample = element("svg", { width: 24, height: 10, "aria-hidden": "true" }, line);
        return { curve, value, entry: element("span", {}, sample, element("bdi", {}, curve.label), value) };
      });
      legend.replaceChildren(...shown.map(({ entry }) => entry));
    };
    const show = (time) => {
      cursor.setAttribute("d", `M${x(time).toFixed(1)} ${TOP}V${HEIGHT - BOTTOM}`);
      for (const { curve, value } of shown) {
        const found = curve.values[nearest(curve.times, time)];
        const ended = !(time <= curve.times[curve.times.length - 1] + 0.1) || Number.isNaN(found);
        value.textContent = ended ? "" : torquebench.figure(found, 3).replace("-", "\u2212");
      }
    };
    return { node, draw, show };
  };
})();
