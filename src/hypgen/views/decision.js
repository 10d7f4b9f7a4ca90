// SPDX-License-Identifier: Apache-2.0
// The decision of a step: the action by name, why, what it brought and what was seen after it.

function decisionOf(view, element) {
  function draw(index) {
    const step = view.steps[index];
    if (!step) return element.replaceChildren(...ending(view));
    const isDefault = step.default_action === step.action;
    const parts = [html("p", { class: "taken" }, html("code", {}, step.action),
      step.default_action === undefined || step.default_action === null ? null
        : html("span", { class: "badge" }, isDefault ? "as the default policy" : `default policy: ${step.default_action}`))];
    parts.push(html("p", { class: "why" }, step.why));
    const facts = [];
    if (typeof step.lower === "number")
      facts.push(["bounds", `${number(step.lower)} to ${number(step.upper)}`, "of what the belief is worth"]);
    facts.push(["reward", number(step.reward), termsText(step)]);
    if (step.earned !== undefined) facts.push(["earned from here", number(step.earned),
      view.ended === "step_limit" ? "discounted, to the step limit" : "discounted, to the end"]);
    facts.push(["saw after it", seenText(step), ""]);
    if (step.status) facts.push(["search", step.status, searchText(step)]);
    parts.push(html("dl", { class: "facts" }, ...facts.map(([name, value, note]) => html("div", { "data-fact": name },
      html("dt", {}, name), html("dd", {}, html("b", {}, value), note ? html("small", {}, ` ${note}`) : null)))));
    element.replaceChildren(...parts);
    return undefined;
  }
  return { draw };
}

function ending(view) {
  const first = view.steps[0];
  return [html("p", { class: "taken" }, 
    { step_limit: "The step limit has ended it here." }[view.ended] || (view.ended ? "The episode is over." : "The recording ends here.")),
    html("p", { class: "why" }, first && first.earned !== null
      ? `It earned ${number(first.earned)}, discounted, in ${view.steps.length} steps.` : "")];
}

function termsText(step) {
  const terms = Object.entries(step.terms || {}).filter(([, value]) => value !== 0);
  if (!step.terms || Object.keys(step.terms).length < 2) return "";
  return terms.map(([name, value]) => `${name} ${number(value)}`).join(", ");
}

function seenText(step) {
  const seen = Object.entries(step.seen || {});
  return seen.length ? pairs(step.seen).join(", ") : "nothing";
}

function searchText(step) {
  const counts = [["trials", "trials"], ["expansions", "expansions"], ["nodes", "nodes"], ["max_depth", "deep"]];
  return counts.filter(([name]) => step[name] !== undefined).map(([name, said]) => `${number(step[name])} ${said}`).join(", ");
}
