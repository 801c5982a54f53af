"use strict";
// Numbers, words and figures stand in the page without this script: it sorts and filters tables, and opens runs.
window.torquebench = { runs: {} };

// Makes an element: attributes by name, functions as listeners, texts as text and never as markup.
torquebench.element = (name, attributes = {}, ...children) => {
  const svg = ["svg", "path", "line", "text", "g", "rect", "circle", "title"].includes(name);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key, value);
    else if (value !== false && value !== undefined) node.setAttribute(key, value === true ? "" : value);
  }
  node.append(...children);
  return node;
};

// Returns a number with so many digits, and never as a power of ten where it is large.
torquebench.figure = (value, digits) => (
  Math.abs(value) < 10 ** digits - 0.5 ? value.toPrecision(digits) : value.toFixed(0)
);

// Loads the record of a run once; a page from disk may read scripts beside it, but no other files.
torquebench.load = (() => {
  const asked = new Map();
  return (name) => {
    if (!asked.has(name)) {
      asked.set(name, new Promise((resolve, reject) => {
        const fail = () => { asked.delete(name); reject(new Error(`runs/${name}.js is not beside this page`)); };
        const done = () => (torquebench.runs[name] ? resolve(torquebench.runs[name]) : fail());
        document.head.append(torquebench.element("script", { src: `runs/${name}.js`, load: done, error: fail }));
      }));
    }
    return asked.get(name);
  };
})();

// Returns the samples of a series of sixteen bits, NaN where there is none.
torquebench.samples = (series) => {
  const bytes = Uint8Array.from(atob(series.data), (letter) => letter.charCodeAt(0));
  const found = new Float64Array(bytes.length / 2);
  for (let i = 0; i < found.length; i += 1) {
    const whole = bytes[2 * i] + 256 * bytes[2 * i + 1];
    found[i] = whole === 65535 ? NaN : series.low + series.step * whole;
  }
  return found;
};

// Returns the samples of a curve with their times: two of them stand for a part of the trace.
torquebench.curve = (trace, series) => {
  const values = torquebench.samples(series);
  const step = (series.part * trace.dt) / 2;
  const first = trace.start + (series.part > 2 ? 0.5 * step : 0), last = trace.start + (trace.samples - 1) * trace.dt;
  const times = values.map((_, i) => Math.min(first + i * step, last));
  return { times, values };
};
