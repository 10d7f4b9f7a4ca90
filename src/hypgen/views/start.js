// SPDX-License-Identifier: Apache-2.0
// Reads the page's data and puts its parts on one time line.

function start() {
  const view = JSON.parse(byId("data").textContent);
  if (view.version !== 1) {
    byId("notes").replaceChildren(html("li", {}, `This page reads data of version 1, and its data have version ${view.version}.`));
    return;
  }
  document.documentElement.classList.add("drawn");
  const moments = view.end ? [...view.steps, view.end] : view.steps;
  const world = view.scene ? worldOf(view, byId("world")) : null;
  const variables = variablesOf(byId("variables"));
  const decision = decisionOf(view, byId("decision"));
  const tree = treeOf(byId("tree"));
  const curves = curvesOf(view, byId("curves"), (place) => timeLine.go(place));

  const history = historyOf(view, byId("history"), (place) => timeLine.go(place));

  function show(at) {
    if (world) world.draw(moments[at]);
    variables.draw(moments[at]);
    decision.draw(at);
    tree.draw(view.steps[at] || null);
    curves.draw(at);
    history.draw(at);
  }
  const last = view.steps.length;
  const names = (at) => (at < last ? `step ${view.steps[at].step} of ${view.steps[last - 1].step}` : "the end");
  const timeLine = timeLineOf(moments.length, names, show, {
    t: () => world && world.toggle("truth"), b: () => world && world.toggle("belief"),
    "/": () => byId("search").focus(), "?": () => byId("help").toggleAttribute("open"),
  });
  const first = view.steps.findIndex((one) => one.step === view.first);
  timeLine.go(Math.max(0, first));
}
start();
