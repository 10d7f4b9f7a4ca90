// SPDX-License-Identifier: Apache-2.0
// A row for each hidden variable, a field for each step: pale where the belief finds the truth improbable.

const MOST_HISTORIES = 16;
const ROW = 18; // pixels, of names and fields alike

function historyOf(view, element, go) {
  const rows = historiesOf(view.steps);
  element.closest("section").hidden = !rows.length;
  if (!rows.length) {
    return { draw: () => {} };
  }
  const shown = rows.slice(0, MOST_HISTORIES);
  const fields = shown.flatMap((row, i) => row.values.map((one, at) => one && svg("rect", {
    class: "field", x: at, y: i + 0.08, width: 1.02, height: 0.84,
    "fill-opacity": (0.06 + 0.94 * one.believed).toFixed(3), onclick: () => go(at),
  }, svg("title", {}, fieldText(row.name, view.steps[at].step, one)))));
  const cursor = svg("rect", { class: "here", y: 0, width: 1, height: shown.length });
  element.replaceChildren(
    html("div", { class: "history" },
      html("div", {}, ...shown.map((row) => html("div", { class: "name", title: row.name }, row.name))),
      svg("svg", {
        viewBox: `0 0 ${view.steps.length} ${shown.length}`, preserveAspectRatio: "none", role: "img",
        style: `height: ${shown.length * ROW}px`, "aria-label": "Belief in the truth",
      }, ...fields, cursor)),
    html("p", { class: "note" }, rows.length > shown.length
      ? `The ${shown.length} of ${rows.length} variables whose truth the belief finds least probable. ` : "",
    "Strong colour: the belief holds what is true. Pale: it does not."));
  return { draw: (at) => cursor.setAttribute("x", Math.min(at, view.steps.length - 1)) };
}

function fieldText(name, step, marginal) {
  return `${name}, step ${step}: true ${valueText(marginal.true)}, believed with ${probability(marginal.believed)}`;
}

// The variables and, for each step, their marginal; those come first whose truth is least probable.
function historiesOf(steps) {
  const rows = new Map();
  steps.forEach((step, at) => {
    for (const one of step.marginals) {
      if (one.believed === undefined) continue;
      if (!rows.has(one.variable)) rows.set(one.variable, { name: one.variable, values: steps.map(() => null), sum: 0 });
      const row = rows.get(one.variable);
      row.values[at] = one;
      row.sum += one.believed - 1;
    }
  });
  return [...rows.values()].sort((a, b) => a.sum - b.sum);
}
