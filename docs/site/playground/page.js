// SPDX-License-Identifier: Apache-2.0
// The page: an editor, messages under its lines, and what Python answers. Texts go in as text, never as HTML.
const PAUSE = 300; // milliseconds without a key before the model is checked

const $ = (id) => document.getElementById(id);
const worker = new Worker("worker.js", { type: "module" });
const waiting = new Map();
worker.onmessage = ({ data: { id, answer, error } }) => {
  const { done, failed } = waiting.get(id);
  waiting.delete(id);
  error === undefined ? done(answer) : failed(new Error(error));
};
let calls = 0;
function python(call, ...args) {
  const id = ++calls;
  worker.postMessage({ id, call, args });
  return new Promise((done, failed) => waiting.set(id, { done, failed }));
}

const { examples, words, types } = await (await fetch("models.json")).json();
const whole = (list) => new RegExp(`(?:${list.join("|")})\\b`);
CodeMirror.defineSimpleMode("pomdp", {
  start: [
    { regex: /#.*/, token: "comment" },
    { regex: /"[^"]*"/, token: "string" },
    { regex: /\d+(?:\.\d+)?(?:[eE][+-]?\d+)?/, token: "number" },
    { regex: whole(types), token: "type" },
    { regex: whole(words), token: "keyword" },
    { regex: /[A-Za-z_]\w*/, token: "variable" },
    { regex: /[-=~<>!+*/%^|']+/, token: "operator" },
    { regex: /[{[(]/, indent: true },
    { regex: /[}\])]/, dedent: true },
  ],
  meta: { lineComment: "#" },
});
const editor = CodeMirror($("text"), { mode: "pomdp", lineNumbers: true, indentUnit: 2 });
for (const name of Object.keys(examples)) $("examples").add(new Option(name));
let shown = [];
let pause;

async function check() {
  const text = editor.getValue();
  const { line, diagnostics } = await python("check", text, $("examples").value);
  if (text !== editor.getValue()) return; // a later check is on its way
  editor.operation(() => {
    for (const old of shown) old.clear();
    shown = diagnostics.flatMap(marks);
  });
  $("status").textContent = line;
}

function marks({ severity, code, message, span, remedy }) {
  const box = document.createElement("div");
  box.className = `message ${severity}`;
  box.textContent = `${severity}[${code}]: ${message}\nhelp: ${remedy}`;
  const isHere = span !== null && span.file === $("examples").value;
  const first = isHere ? span.line - 1 : 0;
  const made = [editor.addLineWidget(Math.min(first, editor.lastLine()), box)];
  if (isHere) {
    const from = { line: first, ch: span.column - 1 };
    const to = { line: span.end_line - 1, ch: span.end_column - 1 };
    made.push(editor.markText(from, to, { className: "wrong" }));
  }
  return made;
}

async function show(task) {
  try {
    return await task();
  } catch (error) {
    $("result").textContent = error.message;
  }
}

const layers = { truth: true, belief: true }; // of the world: what is shown

function episode({ text, legal, ended, scene, moment }, isNew) {
  $("result").textContent = (isNew ? "" : $("result").textContent) + text;
  $("result").scrollTop = $("result").scrollHeight;
  $("world").hidden = !scene;
  if (scene) worldOf({ scene, steps: [moment] }, $("world"), layers).draw(moment);
  const last = $("actions").value;
  $("actions").replaceChildren(...legal.map(([code, name]) => new Option(name, code)));
  if (legal.some(([code]) => code === last)) $("actions").value = last;
  for (const button of $("moves").querySelectorAll("button")) {
    button.disabled = ended && !["belief", "undo"].includes(button.dataset.act);
  }
}

$("explain").onclick = () =>
  show(async () => {
    $("moves").hidden = $("world").hidden = true;
    $("result").textContent = await python("explain", editor.getValue(), $("examples").value);
  });
$("start").onclick = () =>
  show(async () => {
    $("result").textContent = "Loading NumPy ...";
    const seed = Number($("seed").value);
    episode(await python("play", editor.getValue(), $("examples").value, seed), true);
    $("moves").hidden = false;
  });
for (const button of $("moves").querySelectorAll("button")) {
  button.onclick = () =>
    show(async () => episode(await python("act", button.dataset.act || $("actions").value), false));
}
editor.on("change", () => {
  clearTimeout(pause);
  pause = setTimeout(() => show(check), PAUSE);
});
$("examples").onchange = () => {
  $("moves").hidden = $("world").hidden = true;
  editor.setValue(examples[$("examples").value]);
};
const asked = decodeURIComponent(location.hash.slice(1));
$("examples").value = asked in examples ? asked : "tiger.pomdp";
editor.setValue(examples[$("examples").value]);
