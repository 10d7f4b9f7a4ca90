// SPDX-License-Identifier: Apache-2.0
// Curves over the episode, one x axis for all. A click goes to its step.

const CURVE = { wide: 340, tall: 150, left: 60, right: 8, top: 10, bottom: 22 };

// Gives a function that moves the cursor of all curves to a step.
function curvesOf(view, element, go) {
  const panels = [
    { name: "Bounds, and what was earned from there", unit: number,
      band: ["lower", "upper"], lines: [[view.ended === "step_limit" ? "earned before the limit" : "earned", (one) => one.earned, "strong"]] },
    { name: "Reward of each step", unit: number, zero: true, lines: [["reward", (one) => one.reward, "strong"]] },
    { name: "Belief: probability of what is true", unit: number, zero: true, lines: [
      ["mean", (one) => one.believed && one.believed.mean, "strong"],
      ["least", (one) => one.believed && one.believed.least, "second"]], note: (one) => one.believed && one.believed.variable },
    { name: "Belief: effective number of particles", unit: number, zero: true,
      lines: [["effective", (one) => one.effective, "strong"]] },
    { name: "Time of search and update", unit: seconds, zero: true,
      lines: [["search", (one) => one.seconds.search, "strong"], ["update", (one) => one.seconds.update, "second"]] },
    { name: "Nodes of the tree", unit: number, zero: true, lines: [["nodes", (one) => one.nodes, "strong"]] },
  ];
  const made = panels.map((panel) => panelOf(panel, view.steps, go)).filter(Boolean);
  element.replaceChildren(...made.map((one) => one.element));
  if (!made.length) element.append(html("p", { class: "note" }, "No numbers of steps are recorded."));
  return { draw: (index) => made.forEach((one) => one.draw(index)) };
}

function panelOf(panel, steps, go) {
  const series = panel.lines.map(([name, value, kind]) => ({ name, kind, values: steps.map(value).map(known) }))
    .filter((one) => one.values.some((value) => value !== null));
  const ends = (panel.band || []).map((name) => steps.map((one) => known(one[name])));
  const all = [...series.map((one) => one.values), ...ends].flat().filter((value) => value !== null);
  if (!all.length) return null;
  const zero = panel.zero ? [0] : [];
  const { low, high } = near(series, ends, Math.min(...all, ...zero), Math.max(...all, ...zero));
  const scale = scaleOf(low, high === low ? low + 1 : high, steps.length);
  const cursor = svg("line", { class: "cursor", y1: CURVE.top, y2: CURVE.tall - CURVE.bottom });
  const dots = series.map((one) => svg("circle", { class: `dot ${one.kind}`, r: 3.5 }));
  const picture = svg("svg", {
    class: "curve", viewBox: `0 0 ${CURVE.wide} ${CURVE.tall}`, role: "img", "aria-label": panel.name,
    onclick: (event) => go(stepAt(event, steps.length)),
  }, ...axes(scale, low, high === low ? low + 1 : high, steps.length, panel.unit), ...band(ends, scale), cursor,
  ...series.map((one) => svg("path", { class: `line ${one.kind}`, d: pathOf(one.values, scale) })), ...dots);
  const figures = html("figcaption", {});

  function draw(index) {
    const at = Math.min(index, steps.length - 1);
    cursor.setAttribute("x1", scale.x(at));
    cursor.setAttribute("x2", scale.x(at));
    series.forEach((one, i) => {
      const value = one.values[at];
      dots[i].setAttribute("visibility", value === null ? "hidden" : "visible");
      if (value !== null) { dots[i].setAttribute("cx", scale.x(at)); dots[i].setAttribute("cy", scale.y(value)); }
    });
    const said = series.map((one) => html("span", { class: one.kind }, `${one.name} ${panel.unit(one.values[at])}`));
    if (ends.length && ends[0][at] !== null) {
      const outside = ends[0][at] < low || ends[1][at] > high ? ", outside the picture" : "";
      said.unshift(html("span", { class: "range" }, `bounds ${number(ends[0][at])} to ${number(ends[1][at])}${outside}`));
    }
    if (panel.note && panel.note(steps[at])) said.push(html("span", { class: "range" }, panel.note(steps[at])));
    figures.replaceChildren(...said);
  }
  return { element: html("figure", {}, html("h3", {}, panel.name), figures, picture), draw };
}

function known(value) {
  return value === undefined || value === null ? null : value;
}

// Cuts off bounds that are so far away that nothing else of the picture could be told apart.
function near(series, ends, low, high) {
  if (!ends.length || !series.length) return { low, high };
  const earned = series[0].values, lines = earned.filter((value) => value !== null);
  const nearest = earned.map((value, i) => (value === null || ends[0][i] === null ? 0
    : Math.min(Math.abs(ends[0][i] - value), Math.abs(ends[1][i] - value))));
  const least = Math.min(...lines), most = Math.max(...lines), room = 4 * Math.max(most - least, ...nearest);
  return room > 0 ? { low: Math.max(low, least - room), high: Math.min(high, most + room) } : { low, high };
}

function scaleOf(low, high, count) {
  const wide = CURVE.wide - CURVE.left - CURVE.right, tall = CURVE.tall - CURVE.top - CURVE.bottom;
  return {
    x: (index) => CURVE.left + (count > 1 ? (wide * index) / (count - 1) : wide / 2),
    y: (value) => CURVE.top + tall * (1 - (Math.min(high, Math.max(low, value)) - low) / (high - low)),
  };
}

function axes(scale, low, high, count, unit) {
  const lines = [low, high].map((value) => svg("line", {
    class: "rule", x1: CURVE.left, x2: CURVE.wide - CURVE.right, y1: scale.y(value), y2: scale.y(value),
  }));
  const texts = [low, high].map((value) => svg("text", {
    class: "tick y", x: CURVE.left - 5, y: scale.y(value) + 4,
  }, unit(value)));
  const ends = [...new Set([0, count - 1])].map((index) => svg("text", {
    class: "tick", x: scale.x(index), y: CURVE.tall - 6, "text-anchor": index ? "end" : "start",
  }, index ? String(index) : "step 0"));
  return [...lines, ...texts, ...ends];
}

function band(ends, scale) {
  if (!ends.length) return [];
  const parts = runsOf(ends[0].map((low, i) => (low === null || ends[1][i] === null ? null : i)));
  return parts.map((run) => {
    const upper = run.map((i) => `${scale.x(i)} ${scale.y(ends[1][i])}`);
    const lower = run.map((i) => `${scale.x(i)} ${scale.y(ends[0][i])}`).reverse();
    return svg("path", { class: "band", d: `M${[...upper, ...lower].join("L")}Z` });
  });
}

// Cuts a list where values are missing.
function runsOf(values) {
  const runs = [[]];
  for (const value of values) value === null ? runs.push([]) : runs[runs.length - 1].push(value);
  return runs.filter((run) => run.length);
}

function pathOf(values, scale) {
  const runs = runsOf(values.map((value, i) => (value === null ? null : i)));
  return runs.map((run) => `M${run.map((i) => `${scale.x(i)} ${scale.y(values[i])}`).join("L")}`).join("");
}

function stepAt(event, count) {
  const box = event.currentTarget.getBoundingClientRect();
  const x = ((event.clientX - box.left) / box.width) * CURVE.wide;
  const share = (x - CURVE.left) / (CURVE.wide - CURVE.left - CURVE.right);
  return Math.round(Math.min(1, Math.max(0, share)) * (count - 1));
}
