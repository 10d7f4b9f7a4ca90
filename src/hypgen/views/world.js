// SPDX-License-Identifier: Apache-2.0
// The world: shapes of a scene. What is true has a dark outline; what is believed is pale and has none.

const WIDE = 560; // of the drawing, in its own units
const TALL = 460;

// Gives a function that draws the shapes of a moment into an element. `layers` says which of them are shown.
function worldOf(view, element, layers) {
  const scene = view.scene;
  const moments = view.end ? [...view.steps, view.end] : view.steps;
  const hidden = new Set(moments.flatMap((one) => (one.belief || []).map((shape) => shape.name)));
  const extent = scene.extent || extentOf([scene.static || [], ...moments.map((one) => one.truth || [])].flat());
  const frame = frameOf(extent);
  const ground = svg("g", { class: "ground" }, ...(extent.cells ? gridLines(frame) : []));
  for (const shape of scene.static || []) ground.append(...drawn(shape, frame, "static"));
  const belief = svg("g", { class: "belief" });
  const truth = svg("g", { class: "truth" });
  const picture = svg(
    "svg",
    { viewBox: `0 0 ${frame.width} ${frame.height}`, role: "img", class: "world", "aria-label": "The world" },
    ground, belief, truth,
  );
  const gauges = html("div", { class: "gauges" });
  const said = html("p", { class: "note" });
  const hasPlane = frame.width > 0;
  element.replaceChildren(switches(layers, draw, hidden.size > 0), ...(hasPlane ? [picture] : []), gauges,
    legend(scene.static || [], moments, hidden), said);
  let now = null;

  function draw(moment = now) {
    now = moment;
    const known = (moment.truth || []).filter((one) => layers.truth || !hidden.has(one.name)); // what is seen stays
    const believed = layers.belief ? moment.belief || [] : [];
    belief.replaceChildren(...believed.flatMap((one) => drawn(one, frame, "believed")));
    truth.replaceChildren(...known.flatMap((one) => drawn(one, frame, hidden.has(one.name) ? "true" : "seen")));
    gauges.replaceChildren(...gaugesOf(known, believed));
    said.textContent = beliefSaid(moment);
  }
  return { draw, toggle: (name) => { layers[name] = !layers[name]; draw(); sync(element, layers); } };
}

function switches(layers, draw, hasBelief) {
  const names = hasBelief ? ["truth", "belief"] : [];
  return html("div", { class: "switches" }, ...names.map((name) =>
    html("label", {}, html("input", {
      type: "checkbox", checked: layers[name], "data-layer": name,
      onchange: (event) => { layers[name] = event.target.checked; draw(); },
    }), ` ${name}`)));
}

function sync(element, layers) {
  for (const box of element.querySelectorAll("[data-layer]")) box.checked = layers[box.dataset.layer];
}

function beliefSaid(moment) {
  if (!moment.belief || moment.belief_total === undefined || !moment.belief.length) return "";
  return moment.belief_shown < moment.belief_total
    ? `${moment.belief_shown} of ${moment.belief_total} different shapes of the belief are drawn.`
    : "";
}

function extentOf(shapes) {
  const placed = shapes.filter((one) => typeof one.x === "number" && typeof one.y === "number");
  if (!placed.length) return { x: [0, -1], y: [0, -1], cells: true }; // gauges and labels alone
  const xs = placed.flatMap((one) => [one.x, one.x2 ?? one.x]);
  const ys = placed.flatMap((one) => [one.y, one.y2 ?? one.y]);
  return { x: [Math.min(...xs) - 1, Math.max(...xs) + 1], y: [Math.min(...ys) - 1, Math.max(...ys) + 1] };
}

// How places become places of the drawing: y grows upwards, and a cell reaches half a unit to each side.
function frameOf(extent) {
  const margin = extent.cells ? 0.5 : 0;
  const [left, right] = [extent.x[0] - margin, extent.x[1] + margin];
  const [low, high] = [extent.y[0] - margin, extent.y[1] + margin];
  const wide = Math.max(right - left, 0), tall = Math.max(high - low, 0);
  const unit = wide && tall ? Math.min(WIDE / wide, TALL / tall) : 0;
  return {
    unit, extent, width: wide * unit, height: tall * unit,
    glyph: extent.cells ? unit : Math.min(26, 0.08 * Math.min(wide, tall) * unit + 6),
    x: (value) => (value - left) * unit, y: (value) => (high - value) * unit,
  };
}

function gridLines(frame) {
  const lines = [];
  for (let x = 0; x <= frame.width + 0.1; x += frame.unit)
    lines.push(svg("line", { class: "grid", x1: x, x2: x, y1: 0, y2: frame.height }));
  for (let y = 0; y <= frame.height + 0.1; y += frame.unit)
    lines.push(svg("line", { class: "grid", x1: 0, x2: frame.width, y1: y, y2: y }));
  return lines;
}

// The elements of a shape. `kind` is static, seen, true or believed. What is improbable is pale at each step alike.
function drawn(shape, frame, kind) {
  const style = `--c: var(--c-${shape.colour || "grey"}, var(--axis))`;
  const most = frame.extent.cells ? 0.75 : 0.4; // points in the plane lie on each other
  const weight = kind === "believed" ? 0.1 + most * Math.sqrt(shape.p ?? 1) : null;
  const draw = { cell, marker, rectangle, line, label }[shape.shape];
  if (!draw || frame.unit === 0) return [];
  if (typeof shape.x !== "number" || typeof shape.y !== "number") return [];
  const said = [shape.name, shape.text, shape.p === undefined ? null : `p = ${number(shape.p)}`];
  const group = svg("g", { class: `shape ${shape.shape} ${kind} of-${shape.colour || "grey"}`, style, "fill-opacity": weight, "stroke-opacity": weight }, ...draw(shape, frame, kind));
  group.append(svg("title", {}, said.filter(Boolean).join(", ")));
  return [group];
}

function cell(shape, frame, kind) {
  const square = (side, kinds) => svg("rect", {
    class: kinds, x: frame.x(shape.x) - side / 2, y: frame.y(shape.y) - side / 2, width: side, height: side,
  });
  const squares = kind === "true" // a ring in its colour leaves the belief below in sight
    ? [square(0.86 * frame.unit, "rim"), square(0.7 * frame.unit, "ring")] : [square(frame.unit, "whole")];
  return [...squares, ...glyph(shape, frame, "on")];
}

function marker(shape, frame, kind) {
  const [x, y] = [frame.x(shape.x), frame.y(shape.y)];
  const radius = (kind !== "believed" ? 0.32 : frame.extent.cells ? 0.24 : 0.16) * frame.glyph;
  const elements = [];
  if (typeof shape.heading === "number") {
    const degrees = (-180 * shape.heading) / Math.PI;
    const tip = `M${1.7 * radius} 0L${0.3 * radius} ${0.9 * radius}V${-0.9 * radius}Z`;
    elements.push(svg("path", { d: tip, transform: `translate(${x} ${y}) rotate(${degrees})` }));
  }
  elements.push(svg("circle", { cx: x, cy: y, r: radius }));
  return [...elements, ...(kind === "believed" ? [] : glyph(shape, frame, "on"))];
}

function rectangle(shape, frame, kind) {
  const [wide, tall] = [(shape.width ?? 1) * frame.unit, (shape.height ?? 1) * frame.unit];
  const degrees = (-180 * (shape.heading || 0)) / Math.PI;
  const place = `translate(${frame.x(shape.x)} ${frame.y(shape.y)}) rotate(${degrees})`;
  const box = svg("rect", { x: -wide / 2, y: -tall / 2, width: wide, height: tall, rx: Math.min(4, tall / 6) });
  const front = typeof shape.heading === "number"
    ? [svg("path", { class: "front", d: `M${wide * 0.22} ${-tall / 2}L${wide / 2} 0L${wide * 0.22} ${tall / 2}` })]
    : [];
  return [svg("g", { transform: place }, box, ...front), ...(kind === "believed" ? [] : glyph(shape, frame, "on"))];
}

function line(shape, frame) {
  return [svg("line", {
    x1: frame.x(shape.x), y1: frame.y(shape.y), x2: frame.x(shape.x2), y2: frame.y(shape.y2),
  })];
}

function label(shape, frame) {
  return glyph(shape, frame, "free");
}

function glyph(shape, frame, where) {
  if (shape.text === undefined || shape.text === null || shape.text === "") return [];
  const text = String(shape.text);
  const size = where === "on" ? frame.glyph * Math.min(0.46, 0.95 / text.length) : 13;
  if (size < 6) return [];
  return [svg("text", { class: where, x: frame.x(shape.x), y: frame.y(shape.y), "font-size": size }, text)];
}

// A gauge is a bar from low to high: a mark for what is true, pale marks for what is believed.
function gaugesOf(known, believed) {
  const names = [...new Set([...known, ...believed].filter((one) => one.shape === "gauge").map((one) => one.name))];
  return names.map((name) => {
    const mine = (shapes) => shapes.filter((one) => one.shape === "gauge" && one.name === name);
    const [truths, beliefs] = [mine(known), mine(believed)];
    const first = truths[0] || beliefs[0];
    const heaviest = Math.max(...beliefs.map((one) => one.p), 0);
    const place = (value) => 100 * Math.min(1, Math.max(0, (value - first.low) / (first.high - first.low || 1)));
    const mark = (one, kind, weight) => html("i", {
      class: kind, style: `left: ${place(one.value)}%; height: ${Math.round(100 * weight)}%; --c: var(--c-${one.colour || "grey"})`,
      title: `${name} ${number(one.value)}${one.p === undefined ? "" : `, p = ${number(one.p)}`}`,
    });
    return html("div", { class: "gauge" }, html("span", {}, first.text || name),
      html("span", { class: "span" }, ...beliefs.map((one) => mark(one, "believed", one.p / heaviest)),
        ...truths.map((one) => mark(one, "true", 1))),
      html("span", { class: "figure" }, truths.map((one) => number(one.value)).join(", ")));
  });
}

// A row for each declaration: what it looks like where it is true, and where it is believed.
function legend(fixed, moments, hidden) {
  const kinds = new Map();
  const shapes = moments.flatMap((moment) => [...(moment.truth || []), ...(moment.belief || [])]);
  for (const one of [...fixed, ...shapes])
    if (one.shape !== "label" && one.shape !== "gauge") kinds.set(`${one.name} ${one.colour}`, one);
  const names = new Map();
  for (const one of kinds.values()) names.set(one.name, [...(names.get(one.name) || []), one]);
  const rows = [...names].map(([name, shapes]) => html("li", {},
    ...shapes.slice(0, 4).map((one) => swatch(one, hidden.has(name) ? "true" : "static")),
    ...(hidden.has(name) ? shapes.slice(0, 1).map((one) => swatch(one, "believed")) : []),
    hidden.has(name) ? `${name}: true, believed` : name));
  return html("ul", { class: "legend" }, ...rows);
}

function swatch(shape, kind) {
  const frame = { ...frameOf({ x: [0, 0], y: [0, 0], cells: true }), unit: 16, glyph: shape.shape === "marker" ? 22 : 16,
    x: () => 8, y: () => 8 };
  const small = { ...shape, x: 0, y: 0, x2: 0, y2: 0, text: "", width: 0.9, height: 0.6, heading: null };
  const content = shape.shape === "line"
    ? svg("g", { class: `shape line ${kind}`, style: `--c: var(--c-${shape.colour})` },
      svg("line", { x1: 1, y1: 8, x2: 15, y2: 8 }))
    : drawn(small, frame, kind)[0];
  return svg("svg", { class: "swatch", viewBox: "0 0 16 16", "aria-hidden": "true" }, ...(content ? [content] : []));
}
