// SPDX-License-Identifier: Apache-2.0
// The search tree of a decision. Leaves take a row each, and a node stands beside its first child.

const BOX = { wide: 264, tall: 48, gap: 46, row: 56 };
const NARROW = { wide: 196, gap: 18 }; // on a telephone, so that a part of two levels is in sight
const LETTER = 9.8; // pixels of a title
const FIRST_CHILDREN = 8; // shown of a node until more are asked for
const MOST_OPENED = 40; // nodes that a search opens

function treeOf(element) {
  const search = byId("search"), found = byId("found"), legendNote = byId("tree-said");
  let root = null, focus = null, step = null;

  function draw(given) {
    step = given;
    found.textContent = "";
    search.parentElement.hidden = !step || !step.tree;
    if (!step || !step.tree) {
      root = null;
      legendNote.textContent = step ? "This decision has no search tree." : "";
      return element.replaceChildren();
    }
    root = focus = nodeOf("belief", step.tree, null, 1, step);
    root.open = true;
    legendNote.textContent = step.tree_shown < step.tree_total
      ? `${step.tree_shown} of ${step.tree_total} nodes are here, those that most trials took.`
      : `${step.tree_total} nodes.`;
    if (search.value) find(false);
    else redraw();
    return undefined;
  }

  function redraw(takesFocus = false) {
    if (!root) return;
    const all = visible(root);
    if (!all.includes(focus)) focus = root;
    if (document.documentElement.clientWidth < 544) Object.assign(BOX, NARROW);
    const rows = layOut(root);
    const wide = (Math.max(...all.map((one) => one.level)) + 1) * (BOX.wide + BOX.gap) - BOX.gap + 4;
    const links = all.filter((one) => one.parent).map(link);
    const boxes = all.map((one) => box(one, one === focus, press, draws));
    element.replaceChildren(svg("svg", {
      width: wide, height: rows * BOX.row + 10, class: "tree", role: "tree", "aria-label": "Search tree",
      onkeydown: byKey,
    }, ...links, ...boxes));
    if (takesFocus) {
      const box = element.querySelector("[tabindex='0']");
      box.focus({ preventScroll: true });
      box.scrollIntoView({ block: "nearest", inline: "nearest" });
    }
  }

  function draws(node) { // a node's bounds among those of its siblings
    return domainOf(node.parent ? childrenOf(node.parent) : [node]);
  }

  function press(node) {
    focus = node;
    if (node.kind === "more") node.parent.shown = Infinity;
    else if (canOpen(node)) node.open = !node.open;
    redraw(true);
  }

  function byKey(event) {
    const all = visible(root), at = all.indexOf(focus);
    const moves = {
      ArrowDown: () => all[at + 1], ArrowUp: () => all[at - 1], Home: () => all[0], End: () => all[all.length - 1],
      ArrowRight: () => (canOpen(focus) && !focus.open ? press(focus) : focus.open ? shownOf(focus)[0] : null),
      ArrowLeft: () => (focus.open && focus.parent ? press(focus) : focus.parent),
      Enter: () => press(focus), " ": () => press(focus),
    };
    if (!moves[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const next = moves[event.key]();
    if (next) { focus = next; redraw(true); }
  }

  // Marks the actions whose names have the text, and opens the way to the first of them.
  function find(tells = true) {
    const text = search.value.trim().toLowerCase();
    const hits = [];
    walk(root, (node) => {
      node.hit = text !== "" && node.kind === "action" && node.data.name.toLowerCase().includes(text);
      if (node.hit) hits.push(node);
    });
    hits.sort((a, b) => a.level - b.level || b.data.visits - a.data.visits);
    for (const hit of hits.slice(0, MOST_OPENED))
      for (let above = hit.parent, below = hit; above; below = above, above = above.parent) {
        above.open = true;
        above.shown = Math.max(above.shown, childrenOf(above).indexOf(below) + 1);
      }
    if (hits.length && tells) focus = hits[0];
    found.textContent = !text ? "" : hits.length > MOST_OPENED
      ? `${hits.length} nodes, ${MOST_OPENED} of them opened` : `${hits.length} nodes`;
    redraw();
    const box = tells && hits.length ? element.querySelector(".hit") : null;
    if (box) box.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  search.addEventListener("input", () => root && find());
  search.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || !root) return;
    const hits = visible(root).filter((one) => one.hit);
    focus = hits[(hits.indexOf(focus) + 1) % hits.length] || focus;
    const box = (redraw(), element.querySelector("[tabindex='0']"));
    box.scrollIntoView({ block: "nearest", inline: "nearest" });
  });
  return { draw };
}

function nodeOf(kind, data, parent, share, step) {
  return {
    kind, data, parent, share, step, level: parent ? parent.level + 1 : 0,
    open: false, shown: FIRST_CHILDREN, children: null, isBest: false, hit: false,
  };
}

// Children of a belief are actions, those of an action are beliefs after what is seen. They are made when asked for.
function childrenOf(node) {
  if (node.children) return node.children;
  const actions = node.data.actions || [], groups = node.data.groups || [];
  const visits = actions.reduce((sum, one) => sum + one.visits, 0) || 1;
  node.children = node.kind === "belief"
    ? actions.map((one) => nodeOf("action", one, node, (node.share * one.visits) / visits, node.step))
    : groups.map((one) => nodeOf("belief", one, node, node.share * one.share, node.step));
  const left = node.data.actions_left_out || node.data.groups_left_out || 0;
  if (left) node.children.push(nodeOf("note", { said: `${left} less visited ${left === 1 ? "node is" : "nodes are"} left out` }, node, 0));
  mark(node);
  return node.children;
}

// Marks the action that is taken: at the root the decision, below it the largest lower bound.
function mark(node) {
  if (node.kind !== "belief") return;
  const actions = node.children.filter((one) => one.kind === "action");
  const lower = (one) => one.data.lower ?? -Infinity;
  const largest = actions.reduce((best, one) => (!best || lower(one) > lower(best) ? one : best), null);
  const best = node.parent ? largest : actions.find((one) => one.data.name === node.step.action) || largest;
  if (best) {
    best.isBest = true;
    node.children.splice(node.children.indexOf(best), 1);
    node.children.unshift(best);
  }
  if (!node.parent) for (const one of actions) one.isDefault = one.data.name === node.step.default_action;
}

function shownOf(node) {
  if (!node.open) return [];
  const all = childrenOf(node);
  if (all.length <= node.shown + 1) return all;
  const hidden = all.length - node.shown;
  return [...all.slice(0, node.shown), node.more || (node.more = nodeOf("more", {}, node, 0)), ].map((one) => {
    if (one.kind === "more") one.data = { said: `show ${hidden} more` };
    return one;
  });
}

function canOpen(node) {
  return (node.kind === "belief" || node.kind === "action") && childrenOf(node).length > 0;
}

function visible(node) {
  return [node, ...shownOf(node).flatMap(visible)];
}

function walk(node, visit) {
  visit(node);
  childrenOf(node).forEach((one) => walk(one, visit));
}

// Gives every visible node its row, and returns how many rows there are.
function layOut(root) {
  let rows = 0;
  const place = (node) => {
    const below = shownOf(node);
    if (!below.length) node.row = rows++;
    else {
      below.forEach(place);
      node.row = below[0].row;
    }
    node.x = 2 + node.level * (BOX.wide + BOX.gap);
    node.y = 10 + node.row * BOX.row;
  };
  place(root);
  return rows;
}

function link(node) {
  const [x1, y1] = [node.parent.x + BOX.wide, node.parent.y + BOX.tall / 2];
  const [x2, y2] = [node.x, node.y + BOX.tall / 2];
  const middle = (x1 + x2) / 2;
  const width = Math.max(1, 16 * node.share);
  return svg("path", {
    class: node.isBest ? "link best" : `link ${node.kind}`, "stroke-width": width.toFixed(1),
    d: `M${x1} ${y1}C${middle} ${y1} ${middle} ${y2} ${x2} ${y2}`,
  });
}

function domainOf(siblings) {
  const ends = siblings.flatMap((one) => [one.data.lower, one.data.upper]).filter((one) => typeof one === "number");
  return ends.length ? [Math.min(...ends), Math.max(...ends)] : [0, 1];
}

function box(node, hasFocus, press, domain) {
  const names = ["node", node.kind, node.isBest && "best", node.hit && "hit", node.data.terminal && "over"];
  const opens = canOpen(node);
  const group = svg("g", {
    class: names.filter(Boolean).join(" "), role: "treeitem", tabindex: hasFocus ? 0 : -1,
    "aria-level": node.level + 1, "aria-expanded": opens ? String(node.open) : null,
    transform: `translate(${node.x} ${node.y})`, onclick: () => press(node),
  });
  if (node.data.said) {
    group.append(svg("rect", { class: "hull", width: BOX.wide, height: BOX.tall, rx: 6 }),
      svg("text", { x: 12, y: 29, class: "said" }, node.data.said));
    return group;
  }
  const title = titleOf(node);
  const right = node.kind === "action" ? `${node.data.visits} ×` : node.parent ? percent(node.data.share) : "";
  group.append(svg("title", {}, hint(node, title)),
    svg("rect", { class: "hull", width: BOX.wide, height: BOX.tall, rx: node.kind === "action" ? 6 : 20 }),
    svg("text", { x: 12, y: 18, class: "title" }, shortened(title, Math.round(BOX.wide / LETTER) + (node.kind === "action" ? 0 : 2))),
    svg("text", { x: BOX.wide - 22, y: 18, class: "right" }, right),
    svg("text", { x: 12, y: 34, class: "figures" }, boundsText(node)));
  if (node.isDefault) group.append(svg("g", { class: "tag" }, svg("rect", { x: BOX.wide - 104, y: -9, width: 88, height: 15, rx: 7 }),
    svg("text", { x: BOX.wide - 60, y: 2 }, "default policy")));
  if (opens) group.append(svg("text", { x: BOX.wide - 7, y: 28, class: "opens" }, node.open ? "−" : "+"));
  group.append(...interval(node.data, domain(node)));
  return group;
}

function titleOf(node) {
  if (node.kind === "action") return `${node.isBest ? "★ " : ""}${node.data.name}`;
  if (!node.parent) return "belief at this step";
  if (node.data.terminal) return "the end";
  const seen = node.data.seen ? Object.values(node.data.seen).map((one) => valueText(one)).join(", ") : "";
  return seen ? `sees ${seen}` : "sees nothing";
}

function boundsText(node) {
  const { lower, upper, mean } = node.data;
  if (typeof mean === "number") return `mean ${number(mean)}`;
  if (typeof lower !== "number" || typeof upper !== "number") return "no bounds";
  return `${number(lower)} … ${number(upper)}  gap ${number(upper - lower)}`;
}

// Everything of a node, under the pointer and for readers of screens.
function hint(node, title) {
  const { lower, upper, visits, scenarios, share, seen } = node.data;
  const parts = [title];
  if (seen) parts.push(...pairs(seen));
  parts.push(`lower ${number(lower)}, upper ${number(upper)}`, `${number(visits)} trials`);
  if (scenarios !== undefined) parts.push(`${number(scenarios)} scenarios`);
  if (share !== undefined) parts.push(`${percent(share)} of the scenarios above`);
  if (node.kind === "belief" && !node.data.actions && !node.data.terminal) parts.push("a leaf: its bounds are those of rollouts or of the model");
  return parts.join("\n");
}

function interval(data, [low, high]) {
  if (typeof data.lower !== "number" || typeof data.upper !== "number") return [];
  const at = (value) => 12 + ((BOX.wide - 34) * (value - low)) / (high - low || 1);
  return [svg("line", { class: "range", x1: 12, x2: BOX.wide - 22, y1: 42, y2: 42 }),
    svg("line", { class: "interval", x1: at(data.lower), x2: Math.max(at(data.upper), at(data.lower) + 2), y1: 42, y2: 42 })];
}
