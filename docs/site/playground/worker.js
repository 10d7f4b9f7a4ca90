// SPDX-License-Identifier: Apache-2.0
// Pyodide runs beside the page, so that typing never waits for a check.
import { loadPyodide } from "./pyodide/pyodide.mjs";

// NumPy is no part of the npm package. Pyodide fetches it where it publishes it, and compares its hash.
const PACKAGES = "https://cdn.jsdelivr.net/pyodide/v%PYODIDE%/full/";

const ready = (async () => {
  const pyodide = await loadPyodide({ packageBaseUrl: PACKAGES });
  const archive = await fetch("python.zip");
  pyodide.unpackArchive(await archive.arrayBuffer(), "zip", { extractDir: "/hypgen" });
  pyodide.runPython("import sys, os; sys.path.insert(0, '/hypgen'); os.chdir('/hypgen/examples')");
  return { pyodide, module: pyodide.pyimport("browser") };
})();

onmessage = async ({ data: { id, call, args } }) => {
  try {
    const { pyodide, module } = await ready;
    if (call === "play") {
      await pyodide.loadPackage("numpy");
      pyodide.runPython("import numpy");
    }
    const answer = call === "ready" ? null : module[call](...args);
    postMessage({ id, answer: answer?.toJs ? answer.toJs({ dict_converter: Object.fromEntries }) : answer });
  } catch (error) {
    const isNumPy = call === "play" && /numpy/i.test(error.message);
    const text = "Episodes need NumPy from Pyodide's server, which does not answer. `hypgen sim` plays them here.";
    postMessage({ id, error: isNumPy ? text : error.message });
  }
};
