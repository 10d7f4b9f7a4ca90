// SPDX-License-Identifier: Apache-2.0
// The table of variables: what the agent sees, and its belief in what it does not see, beside the truth.

const MOST_ROWS = 8; // of an array that is not opened
const MOST_VALUES = 5;

function variablesOf(element) {
  const opened = new Set(); // the arrays that the reader has opened, through all steps
  let now = null;

  function draw(moment = now) {
    now = moment;
    const marginals = moment.marginals || [];
    const believed = groupsOf(marginals);
    const names = new Set(marginals.map((one) => one.variable.replace(/\[.*$/, "")));
    const seen = Object.entries(moment.state || {}).filter(([name]) => !names.has(name));
    const rows = [...believed].flatMap(([name, group]) => groupRows(name, group));
    const parts = [];
    if (rows.length) parts.push(table(["hidden variable", "truth", "belief"], rows));
    if (moment.marginals_left_out)
      parts.push(html("p", { class: "note" }, `${moment.marginals_left_out} more variables are left out.`));
    if (seen.length) {
      const heading = marginals.length ? "variable that is seen" : "variable";
      parts.push(table([heading, "value"], seen.map(([name, value]) => html("tr", {},
        html("th", { scope: "row" }, name), html("td", {}, valueText(value))))));
    }
    if (!parts.length) parts.push(html("p", { class: "note" }, "No values are recorded."));
    element.replaceChildren(...parts);
  }

  function groupRows(name, group) {
    const few = group.length <= MOST_ROWS || opened.has(name);
    const order = few ? group : [...group].sort((a, b) => doubt(b) - doubt(a));
    const rows = (few ? order : order.slice(0, MOST_ROWS)).map(marginalRow);
    if (group.length > MOST_ROWS) {
      const said = few ? `${name}: show the most doubtful alone` : `${name}: the ${MOST_ROWS} most doubtful of ${group.length}; show all`;
      rows.push(html("tr", { class: "more" }, html("td", { colspan: 3 }, html("button", {
        type: "button",
        onclick: () => { few ? opened.delete(name) : opened.add(name); draw(); },
      }, said))));
    }
    return rows;
  }
  return { draw };
}

function groupsOf(marginals) {
  const groups = new Map();
  for (const one of marginals) {
    const name = one.variable.replace(/\[[^\]]*\]/g, "[]");
    groups.set(name, [...(groups.get(name) || []), one]);
  }
  return groups;
}

function doubt(marginal) {
  return marginal.values ? 1 - Math.max(...marginal.values.map((one) => one.probability)) : marginal.deviation || 0;
}

function table(headings, rows) {
  return html("div", { class: "scroll" }, html("table", {},
    html("thead", {}, html("tr", {}, ...headings.map((one) => html("th", { scope: "col" }, one)))),
    html("tbody", {}, ...rows)));
}

function marginalRow(one) {
  const truth = one.true === undefined ? "" : valueText(one.true);
  const belief = one.values
    ? html("div", { class: "bars" }, ...barsOf(one, truth))
    : html("span", { class: "figure" }, `${number(one.mean)} ± ${number(one.deviation)}`);
  return html("tr", { "data-variable": one.variable },
    html("th", { scope: "row" }, one.variable), html("td", { class: "truth" }, truth), html("td", {}, belief));
}

// A bool has one bar, that of true.
function isBool(marginal) {
  return marginal.values.every((one) => String(one.value) === "true" || String(one.value) === "false");
}

function trueOf(marginal) {
  return marginal.values.find((one) => String(one.value) === "true") || { value: "true", probability: 0 };
}

function barsOf(marginal, truth) {
  const likely = isBool(marginal) ? [trueOf(marginal)] : marginal.values.filter((one) => one.probability >= 0.0005);
  const shown = likely.slice(0, MOST_VALUES);
  if (marginal.values_left_out) shown.push({
    value: `${marginal.values_left_out} ${marginal.values_left_out === 1 ? "other" : "others"}`,
    probability: Math.max(0, 1 - marginal.values.reduce((sum, one) => sum + one.probability, 0)),
  });
  return shown.map((one) => {
    const isTrue = String(one.value) === truth;
    return html("div", { class: isTrue ? "bar true" : "bar", title: isTrue ? "the truth" : null },
      html("span", { class: "value" }, (isTrue ? "◆ " : "") + valueText(one.value)),
      html("span", { class: "track" }, html("span", { class: "fill", style: `width: ${(100 * one.probability).toFixed(1)}%` })),
      html("span", { class: "figure" }, probability(one.probability)));
  });
}
