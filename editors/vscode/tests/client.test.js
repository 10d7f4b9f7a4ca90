// SPDX-License-Identifier: Apache-2.0
// The extension with a stand-in for VS Code, and the server over the protocol's own package of npm.
"use strict";

const assert = require("node:assert");
const { spawn } = require("node:child_process");
const { readFileSync } = require("node:fs");
const Module = require("node:module");
const { test } = require("node:test");

const commands = {};
const terminals = [];
const clients = [];

class LanguageClient {
  constructor(id, name, server, options) {
    Object.assign(this, { id, name, server, options, running: false });
    clients.push(this);
  }
  async start() {
    this.running = true;
  }
  async stop() {
    this.running = false;
  }
}

const vscode = {
  workspace: { getConfiguration: () => ({ get: () => "/opt/hypgen" }) },
  commands: { registerCommand: (name, run) => (commands[name] = run) },
  window: {
    createTerminal: (options) => {
      terminals.push(options);
      return { show() {} };
    },
  },
  Uri: { parse: (address) => ({ fsPath: decodeURIComponent(new URL(address).pathname) }) },
};
const standIns = { vscode, "vscode-languageclient/node": { LanguageClient } };
const load = Module._load;
Module._load = (name, ...rest) => standIns[name] ?? load(name, ...rest);
const extension = require("../client.js");
Module._load = load;

test("activation starts the command that the setting names", async () => {
  await extension.activate({ subscriptions: [] });
  assert.deepStrictEqual(clients[0].server, { command: "/opt/hypgen", args: ["lsp"] });
  assert.deepStrictEqual(clients[0].options.documentSelector, [{ language: "hypgen" }]);
  assert.ok(clients[0].running);
});

test("a lens's command gets the file as one argument, without a shell", () => {
  commands["hypgen.check"]("file:///a%20b/t%3Brm.pomdp");
  assert.deepStrictEqual(terminals.pop().shellArgs, ["check", "/a b/t;rm.pomdp"]);
  commands["hypgen.error"]("E0201");
  assert.deepStrictEqual(terminals.pop().shellArgs, ["error", "E0201"]);
  const all = ["check", "error", "explain", "import", "sim"].map((name) => `hypgen.${name}`);
  assert.deepStrictEqual(Object.keys(commands).sort(), all);
});

test("deactivation stops the server", async () => {
  await extension.deactivate();
  assert.ok(!clients[0].running);
});

const server = process.env.HYPGEN_LSP;
test("the server answers the client's protocol package", { skip: !server }, async () => {
  const protocol = require("vscode-languageserver-protocol/node");
  const child = spawn(server, ["lsp"], { stdio: ["pipe", "pipe", "inherit"] });
  const connection = protocol.createProtocolConnection(child.stdout, child.stdin);
  const told = new Promise((resolve) =>
    connection.onNotification(protocol.PublishDiagnosticsNotification.type, resolve),
  );
  connection.listen();
  const greeting = { processId: process.pid, rootUri: null, capabilities: {} };
  const { capabilities } = await connection.sendRequest(protocol.InitializeRequest.type, greeting);
  assert.ok(capabilities.hoverProvider && capabilities.renameProvider);
  const text = readFileSync(`${__dirname}/../../../examples/tiger.pomdp`, "utf8");
  const slip = text.replace("hidden tiger: Door", "hidden tiger: Dor");
  const uri = "file:///no/tiger.pomdp";
  const textDocument = { uri, languageId: "hypgen", version: 1, text: slip };
  connection.sendNotification(protocol.DidOpenTextDocumentNotification.type, { textDocument });
  const { diagnostics } = await told;
  assert.match(diagnostics[0].message, /did you mean 'Door'/);
  const context = { diagnostics };
  const ask = { textDocument: { uri }, range: diagnostics[0].range, context };
  const actions = await connection.sendRequest(protocol.CodeActionRequest.type, ask);
  assert.ok(actions.some((action) => action.edit && action.title === "Write Door"));
  await connection.sendRequest(protocol.ShutdownRequest.type);
  await connection.sendNotification(protocol.ExitNotification.type);
  const ended = new Promise((resolve) => child.on("exit", resolve));
  child.stdin.end();
  assert.strictEqual(await ended, 0);
});
