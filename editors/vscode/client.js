// SPDX-License-Identifier: Apache-2.0
// Starts `hypgen lsp` for `.pomdp` files, and runs the commands of its code lenses in a terminal.
"use strict";

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function command() {
  return vscode.workspace.getConfiguration("hypgen").get("command");
}

// The shell must not read a file's name: it is an argument of the process itself.
function run(name, argument) {
  const terminal = vscode.window.createTerminal({
    name: `hypgen ${name}`,
    shellPath: command(),
    shellArgs: [name, argument],
  });
  terminal.show();
}

exports.activate = async (context) => {
  const ofFile = (name) => (address) => run(name, vscode.Uri.parse(address).fsPath);
  for (const name of ["check", "sim", "explain", "import"]) {
    context.subscriptions.push(vscode.commands.registerCommand(`hypgen.${name}`, ofFile(name)));
  }
  const explain = (code) => run("error", code);
  context.subscriptions.push(vscode.commands.registerCommand("hypgen.error", explain));
  client = new LanguageClient(
    "hypgen",
    "hypgen",
    { command: command(), args: ["lsp"] },
    { documentSelector: [{ language: "hypgen" }] },
  );
  await client.start();
};

exports.deactivate = () => client && client.stop();
