// The panel of a run: its curves and its replay under one cursor, its figures, and the command that repeats it.
(() => {
  const { element } = torquebench;
  const robots = JSON.parse(document.getElementById("robots").textContent);
  const CURVES = [["position", "Position error", "mm"], ["orientation", "Orientation error", "mrad"]];
  CURVES.push(["joints", "Joint error", "mrad"], ["torque", "Joint torque", "N m"]);
  const MOST_GHOSTS = 5;
  const MAGNIFIED = [1, 5, 20, 100];
  const KEY = "Dashed: reference path. Solid: path of the tool point up to the cursor. Floor lines every 0.2 m. "
    + "Shaded in the plots: lead-in, not scored.";
  let count = 0;

  const rows = () => [...document.querySelectorAll("tr[data-run]")];
  const othersOf = (row) => rows().filter((other) => other !== row && other.dataset.cell === row.dataset.cell);
  const inWords = ([trajectory, load, repetition, role]) => (
    `${trajectory}, ${load}, repetition ${repetition}${role === "run" ? "" : `, twin ${role}`}`
  );

  // What the replay needs of a run: postures and plan by frame.
  const actorOf = ({ trace, robot }, style) => {
    const postures = (series) => {
      const joints = series.map(torquebench.samples);
      return Array.from(joints[0], (_, i) => joints.map((joint) => joint[i]));
    };
    const skeleton = robots[robot], frames = postures(trace.q), planned = postures(trace.q_ref);
    return {
      skeleton, frames, planned, style, ghost: style > 0,
      reference: planned.map((q) => torquebench.toolPoint(skeleton, q)),
      frameNumber: (time) => Math.min(frames.length - 1, Math.max(0, Math.round((time - trace.start) / trace.frame))),
      stop: trace.start + trace.samples * trace.dt + 0.1,
    };
  };

  const ghostChoice = (others, changed) => {
    if (!others.length) return [];
    const chosen = [], boxes = [];
    const change = (box, other) => {
      if (box.checked) chosen.push(other); else chosen.splice(chosen.indexOf(other), 1);
      for (const one of boxes) one.disabled = !one.checked && chosen.length >= MOST_GHOSTS;
      changed(chosen);
    };
    const labels = others.map((other) => {
      const box = element("input", { type: "checkbox", change: () => change(box, other) });
      boxes.push(box);
      return element("label", {}, box, " ", element("bdi", {}, other.dataset.label));
    });
    const legend = element("legend", {}, "Other controllers on the same cell, as ghosts and curves");
    return [element("fieldset", { class: "ghosts" }, legend, ...labels)];
  };

  // Loads the runs of rows: those that have a trace, and a word on each that has none.
  const tracesOf = async (chosen) => {
    const loaded = await Promise.allSettled(chosen.map((row) => torquebench.load(row.dataset.run)));
    const records = loaded.map(({ value }) => value).filter(Boolean);
    const lost = loaded.filter(({ reason }) => reason).map(({ reason }) => reason.message);
    lost.push(...records.filter(({ trace }) => !trace).map(({ label }) => `${label} has no trace`));
    return [records.filter(({ trace }) => trace), lost];
  };

  const sceneOf = (replay) => {
    if (!replay) return element("p", { class: "axis" }, "The robot's file was not at hand for this report: no replay.");
    const options = MAGNIFIED.map((times) => (
      element("option", { value: times }, times === 1 ? "as it is" : `${times} times larger`)
    ));
    const magnify = element("select", { change: () => replay.magnify(Number(magnify.value)) }, ...options);
    const label = element("label", {}, "Deviation from the plan, joint by joint ", magnify);
    return element("div", { class: "scene" }, replay.canvas, replay.controls, element("p", { class: "controls" }, label),
      element("p", { class: "axis" }, KEY));
  };

  const traceParts = (record, row) => {
    const { trace, events } = record, { start, dt } = trace, stop = start + (trace.samples - 1) * dt;
    let now = Math.max(0, start);
    const seek = (time) => { now = time; for (const part of parts) part.show(time); };
    const plots = CURVES.map(([name, title, unit]) => (
      { name, ...torquebench.plot({ title, unit, start, stop, events, seek }) }
    ));
    const player = torquebench.player({ start, stop, step: dt, seek });
    const replay = robots[record.robot] ? torquebench.replay() : null;
    const parts = [...plots, player, ...(replay ? [replay] : [])];

    const jointCurves = () => trace.torque.map((series, joint) => (
      { label: `joint ${joint + 1}`, style: joint, ...torquebench.curve(trace, series) }
    ));
    const runCurves = (records, name) => records.map((one, style) => (
      { label: one.label, style, ...torquebench.curve(one.trace, one.trace[name]) }
    ));
    const cast = (records) => {
      for (const { name, draw } of plots) draw(name === "torque" ? jointCurves() : runCurves(records, name));
      if (replay) replay.cast(records.map(actorOf));
      seek(now);
    };
    const message = element("p", { class: "bad", role: "status" });
    let asked = 0;
    const choice = ghostChoice(othersOf(row), async (chosen) => {
      const own = asked += 1;
      const [records, lost] = await tracesOf(chosen);
      // Files may come late: only the last choice counts.
      if (own !== asked) return;
      message.textContent = lost.join("; ");
      cast([record, ...records]);
    });
    cast([record]);
    const drawn = element("div", { class: "plots" }, ...plots.map(({ node }) => node));
    return [player.node, ...choice, message, element("div", { class: "stage" }, sceneOf(replay), drawn)];
  };

  const commandParts = ({ command, cell }) => {
    if (!command) return [element("p", {}, "No command repeats this run: its controller, or a setting, has no name to give.")];
    const code = element("code", {}, command);
    const click = async () => {
      getSelection().selectAllChildren(code);
      try { await navigator.clipboard.writeText(command); copy.textContent = "Copied"; } catch { copy.textContent = "Selected"; }
    };
    const copy = element("button", { type: "button", click }, "Copy");
    const before = cell[2] > 0 ? " and the repetitions before it" : "";
    const words = `This command repeats the run${before}; the same code gives it the same address. `;
    return [element("p", { class: "command" }, words, copy), element("pre", { tabindex: 0 }, code)];
  };

  const tableParts = (title, head, lines) => {
    if (!lines.length) return [];
    const cell = (text, i) => (i ? element("td", { class: "n" }, text) : element("th", { scope: "row" }, text));
    const heads = head.map((text, i) => element("th", { scope: "col", class: i ? "n" : false }, text));
    const body = lines.map((line) => element("tr", {}, ...line.map(cell)));
    const table = element("table", {}, element("thead", {}, element("tr", {}, ...heads)), element("tbody", {}, ...body));
    return [element("details", {}, element("summary", {}, title), table)];
  };

  const fill = (box, record, row) => {
    // A name that is written from right to left must not take the words after it along.
    const name = element("bdi", {}, record.label);
    const heading = element("p", { class: "panel-title", id: `panel-${(count += 1)}` }, name, `: ${inWords(record.cell)}`);
    const status = record.status === "ok" ? [] : [element("p", { class: "bad" }, `${record.status}: ${record.reason}`)];
    const times = Object.entries(record.timing).map(([name, value]) => [name, value === null ? "" : torquebench.figure(value, 4)]);
    const none = element("p", {}, "No trace of this run was kept, or it cannot be read.");
    box.setAttribute("aria-labelledby", heading.id);
    box.replaceChildren(
      heading, ...status,
      ...(record.trace ? traceParts(record, row) : [none]),
      ...commandParts(record),
      ...tableParts(`All metrics of this run (${record.metrics.length})`, ["Metric", "Unit", "Run", "Steady"], record.metrics),
      ...tableParts("Wall times on the machine that ran it", ["Name", "Value"], times),
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

  for (const row of rows()) {
    const button = element("button", { type: "button", class: "opens", "aria-expanded": "false" });
    const [, trajectory, load, repetition] = row.dataset.cell.split("|");
    button.setAttribute("aria-label", `Open ${row.dataset.label} on ${trajectory}, ${load}, repetition ${repetition}`);
    button.addEventListener("click", () => toggle(row, button));
    row.cells[0].prepend(button);
  }
})();
