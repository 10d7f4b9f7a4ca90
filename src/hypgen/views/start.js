// SPDX-License-Identifier: Apache-2.0
// Reads the page's data and puts its parts on one time line.

function start() {
  const view = JSON.parse(byId("data").textContent);
  if (view.version !== 1) {
    byId("notes").replaceChildren(html("li", {}, `This page reads data of version 1, and its data have version ${view.version}.`));
    return;
  }
  document.documentElement.classList.add("drawn");
  const variables = variablesOf(byId("variables"));
  const decision = decisionOf(view, byId("decision"));
  const tree = treeOf(byId("tree"));
  const layers = { truth: true, belief: true };
  let moments, world, curves, history, live = null;

  // Makes what shows all steps; a run that goes on has more of them later.
  function build() {
    moments = view.end ? [...view.steps, view.end] : [...view.steps];
    world = view.scene ? worldOf(view, byId("world"), layers) : null;
    curves = curvesOf(view, byId("curves"), (place) => timeLine.go(place));
    history = historyOf(view, byId("history"), (place) => timeLine.go(place));
    byId("notes").replaceChildren(...view.notes.map((note) => html("li", {}, note)));
  }

  let shown = null;
  function show(at) {
    if (world) world.draw(moments[at]);
    variables.draw(moments[at]);
    decision.draw(at);
    if (moments[at] !== shown) tree.draw(view.steps[at] || null); // what is open stays so while others come
    shown = moments[at];
    curves.draw(at);
    history.draw(at);
  }
  const names = (at) => (at < view.steps.length
    ? `step ${view.steps[at].step} of ${view.steps[view.steps.length - 1].step}` : "the end");
  build();
  const timeLine = timeLineOf(names, show, () => live && live.leave(), {
    t: () => world && world.toggle("truth"), b: () => world && world.toggle("belief"),
    "/": () => byId("search").focus(), "?": () => byId("help").toggleAttribute("open"),
  });
  timeLine.grow(moments.length);
  const first = view.steps.findIndex((one) => one.step === view.first);
  timeLine.show(view.live ? moments.length - 1 : Math.max(0, first));
  if (view.live) live = liveOf(view, () => { build(); timeLine.grow(moments.length); }, () => timeLine.show(moments.length - 1));
}
start();
