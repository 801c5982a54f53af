// The panel of a run: its curves and its replay under one cursor, its figures, and the command that repeats it.
(() => {
  const { element } = torquebench;
  const robots = JSON.parse(document.getElementById("robots").textContent);
  const CURVES = [["position", "Position error", "mm"], ["orientation", "Orientation error", "mrad"], ["joints", "Joint error", "mrad"]];
  const MOST_GHOSTS = 5;
  let count = 0;

  const rowsOfCell = (row) => [...document.querySelectorAll("tr[data-run]")].filter((other) => other !== row && other.dataset.cell === row.dataset.cell);
  const inCell = ([trajectory, load, repetition, role]) => `${trajectory}, ${load}, repetition ${repetition}${role === "run" ? "" : `, twin ${role}`}`;

  // What the replay needs of a run.
  const actorOf = (record, style, ghost) => {
    const { trace } = record, skeleton = robots[record.robot];
    const columns = (series) => { const found = series.map(torquebench.samples); return Array.from(found[0], (_, i) => found.map((column) => column[i])); };
    const frames = columns(trace.q), planned = columns(trace.q_ref);
    const frameNumber = (time) => Math.min(frames.length - 1, Math.max(0, Math.round((time - trace.start) / trace.frame)));
    const reference = planned.map((q) => torquebench.toolPoint(skeleton, q));
    return { skeleton, frames, planned, reference, style, ghost, frameNumber, stop: trace.start + trace.samples * trace.dt + 0.1 };
  };

  const player = (start, stop, step, seek) => {
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    let playing = false, from = 0, last = 0;
    const slider = element("input", { type: "range", min: start, max: stop, step, value: start, "aria-label": "Time", input: () => seek(Number(slider.value)) });
    const speed = element("select", { "aria-label": "Speed" }, ...[0.1, 0.25, 0.5, 1, 2, 4].map((factor) => element("option", { value: factor, selected: factor === 1 }, `${factor} \u00d7`)));
    const time = element("output", { class: "time" });
    const name = () => { button.textContent = playing ? "Pause" : "Play"; };
    const tick = (now) => {
      if (!playing || !button.isConnected) { playing = false; name(); return; }
      // Whoever asked for less motion gets four pictures a second.
      if (!still.matches || now - last >= 250) {
        const next = from + ((now - last) / 1000) * Number(speed.value);
        last = now;
        from = next;
        seek(Math.min(next, stop));
        if (next >= stop) playing = false;
      }
      if (playing) requestAnimationFrame(tick); else name();
    };
    const button = element("button", {
      type: "button", class: "play",
      click: () => {
        playing = !playing;
        name();
        if (!playing) return;
        from = Number(slider.value) >= stop - step ? start : Number(slider.value);
        last = performance.now();
        requestAnimationFrame(tick);
      },
    }, "Play");
    const show = (at) => { slider.value = at; if (!playing) from = at; time.textContent = `${at.toFixed(2)} s`.replace("-", "\u2212"); };
    return { node: element("div", { class: "controls player" }, button, slider, time, element("label", {}, "Speed ", speed)), show };
  };

  const ghostChoice = (row, changed) => {
    const others = rowsOfCell(row);
    if (!others.length) return [];
    const chosen = [];
    const boxes = others.map((other) => {
      const box = element("input", {
        type: "checkbox",
        change: () => {
          if (box.checked) chosen.push(other); else chosen.splice(chosen.indexOf(other), 1);
          for (const one of boxes) one.box.disabled = !one.box.checked && chosen.length >= MOST_GHOSTS;
          changed(chosen);
        },
      });
      return { box, node: element("label", {}, box, ` ${other.dataset.label}`) };
    });
    return [element("fieldset", { class: "ghosts" }, element("legend", {}, "Other controllers on the same cell, as ghosts and curves"), ...boxes.map(({ node }) => node))];
  };

  const traceParts = (record, row) => {
    const { trace } = record, stop = trace.start + (trace.samples - 1) * trace.dt;
    const seek = (time) => { now = time; for (const part of parts) part.show(time); };
    const plots = [...CURVES, ["torque", "Joint torque", "N m"]].map(([name, title, unit]) => ({ name, ...torquebench.plot({ title, unit, start: trace.start, stop, events: record.events, seek }) }));
    const time = player(trace.start, stop, trace.dt, seek);
    const drawable = robots[record.robot];
    const replay = drawable ? torquebench.replay() : null;
    const parts = [...plots, time, ...(replay ? [replay] : [])];
    let now = Math.max(0, trace.start);

    const cast = (records) => {
      for (const { name, draw } of plots) {
        if (name === "torque") draw(trace.torque.map((series, joint) => ({ label: `joint ${joint + 1}`, style: joint, ...torquebench.curve(trace, series) })));
        else draw(records.map((one, style) => ({ label: one.label, style, ...torquebench.curve(one.trace, one.trace[name]) })));
      }
      if (replay) replay.cast(records.filter((one) => robots[one.robot]).map((one, style) => actorOf(one, style, style > 0)));
      seek(now);
    };
    const message = element("p", { class: "bad", role: "status" });
    const choice = ghostChoice(row, async (chosen) => {
      const loaded = await Promise.allSettled(chosen.map((other) => torquebench.load(other.dataset.run)));
      const records = loaded.filter(({ status }) => status === "fulfilled").map(({ value }) => value);
      const lost = [...loaded.filter(({ status }) => status === "rejected").map(({ reason }) => reason.message), ...records.filter((one) => !one.trace).map((one) => `${one.label} has no trace`)];
      message.textContent = lost.join("; ");
      cast([record, ...records.filter((one) => one.trace)]);
    });
    const magnify = element("select", { change: () => replay.magnify(Number(magnify.value)) }, ...[1, 5, 20, 100].map((factor) => element("option", { value: factor }, factor === 1 ? "as it is" : `${factor} times larger`)));
    const scene = replay
      ? element("div", { class: "scene" }, replay.canvas, replay.controls, element("p", { class: "controls" }, element("label", {}, "Deviation from the plan, joint by joint ", magnify)), element("p", { class: "axis" }, "Dashed: reference path. Solid: path of the tool point up to the cursor. Floor lines every 0.2 m. Shaded in the plots: lead-in, not scored."))
      : element("p", { class: "axis" }, "The robot's file was not at hand when this report was written: no replay.");
    cast([record]);
    return [time.node, ...choice, message, element("div", { class: "stage" }, scene, element("div", { class: "plots" }, ...plots.map(({ node }) => node)))];
  };

  const commandPart = (record) => {
    const { command } = record;
    if (!command) return [element("p", {}, "No command repeats this run: its controller was a Python object without a name.")];
    const code = element("code", {}, command);
    const copy = element("button", { type: "button", click: async () => {
      getSelection().selectAllChildren(code);
      try { await navigator.clipboard.writeText(command); copy.textContent = "Copied"; } catch { copy.textContent = "Selected"; }
    } }, "Copy");
    return [element("p", { class: "command" }, `This command repeats the run${record.cell[2] > 0 ? " and the repetitions before it" : ""}; the same code gives it the same address. `, copy), element("pre", { tabindex: 0 }, code)];
  };
  const tablePart = (title, head, rows) => {
    if (!rows.length) return [];
    const cells = (row) => element("tr", {}, element("th", { scope: "row" }, row[0]), ...row.slice(1).map((text) => element("td", { class: "n" }, text)));
    return [element("details", {}, element("summary", {}, title), element("table", {}, element("thead", {}, element("tr", {}, ...head.map((text, i) => element("th", { scope: "col", class: i ? "n" : false }, text)))), element("tbody", {}, ...rows.map(cells))))];
  };

  const fill = (box, record, row) => {
    const heading = element("p", { class: "panel-title", tabindex: -1, id: `panel-${(count += 1)}` }, `${record.label}: ${inCell(record.cell)}`);
    const status = record.status === "ok" ? [] : [element("p", { class: "bad" }, `${record.status}: ${record.reason}`)];
    const timing = Object.entries(record.timing).map(([name, value]) => [name, value === null ? "" : String(Number(value.toPrecision(4)))]);
    box.setAttribute("aria-labelledby", heading.id);
    box.replaceChildren(
      heading, ...status,
      ...(record.trace ? traceParts(record, row) : [element("p", {}, "No trace of this run was kept, or it cannot be read.")]),
      ...commandPart(record),
      ...tablePart(`All metrics of this run (${record.metrics.length})`, ["Metric", "Unit", "Run", "Steady"], record.metrics),
      ...tablePart("Wall times on the machine that ran it", ["Name", "Value"], timing),
      element("p", { class: "axis" }, `Address ${record.address}`),
    );
  };

  const toggle = async (row, button) => {
    const open = button.getAttribute("aria-expanded") === "true";
    button.setAttribute("aria-expanded", String(!open));
    if (open) { row.nextElementSibling.remove(); return; }
    const box = element("div", { class: "panel", role: "region" }, element("p", { role: "status" }, "Loading"));
    row.after(element("tr", { class: "run-panel" }, element("td", { colspan: row.cells.length }, box)));
    try {
      fill(box, await torquebench.load(row.dataset.run), row);
    } catch (problem) {
      box.replaceChildren(element("p", { class: "bad", role: "status" }, `This run cannot be shown: ${problem.message}.`));
    }
  };

  for (const row of document.querySelectorAll("tr[data-run]")) {
    const button = element("button", { type: "button", class: "opens", "aria-expanded": "false", click: () => toggle(row, button) });
    button.setAttribute("aria-label", `Open the run of ${row.dataset.label} (${row.dataset.cell.split("|").slice(1, 4).join(", ")})`);
    row.cells[0].prepend(button);
  }
})();
