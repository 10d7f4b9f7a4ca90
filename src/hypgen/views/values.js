// SPDX-License-Identifier: Apache-2.0
// Texts of values, and elements of the page.

const SVG = "http://www.w3.org/2000/svg";

// Four significant digits, and all before the point: texts.py has the same rule.
function number(value) {
  if (value === null || value === undefined) return "unknown";
  const size = Math.abs(value);
  if (size >= 1000 && size < 1e9) return String(Math.round(value));
  if (value === 0 || (size >= 1e-4 && size < 1000)) return plain(value.toPrecision(4));
  const [digits, power] = value.toExponential(3).split("e");
  return `${plain(digits)}e${power[0]}${power.slice(1).padStart(2, "0")}`;
}

function plain(text) {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

function seconds(value) {
  if (value === null || value === undefined) return "unknown";
  if (value !== 0 && value < 1e-3) return `${number(value * 1e6)} µs`;
  return value < 1 ? `${number(value * 1e3)} ms` : `${number(value)} s`;
}

function probability(value) {
  if (value > 0 && value < 0.001) return "<0.001";
  return value < 1 && value > 0.999 ? ">0.999" : number(Math.round(1000 * value) / 1000);
}

function percent(share) {
  if (share > 0 && share < 0.005) return "<1 %";
  return share < 1 && share > 0.995 ? ">99 %" : `${Math.round(100 * share)} %`;
}

// Any value of a model: enums are texts, arrays lists, records objects.
function valueText(value, most = 24) {
  if (value === null || value === undefined) return "unknown";
  if (Array.isArray(value)) {
    if (value.length && value.every((one) => typeof one === "boolean")) // false and true as they lie
      return value.slice(0, 4 * most).map((one) => (one ? "●" : "○")).join("") + (value.length > 4 * most ? "…" : "");
    const shown = value.slice(0, most).map((one) => valueText(one, most)).join(", ");
    return value.length > most ? `[${shown}, … ${value.length - most} more]` : `[${shown}]`;
  }
  if (typeof value === "object") return pairs(value).join(", ");
  return typeof value === "number" ? number(value) : String(value);
}

function pairs(values) {
  return Object.entries(values).map(([name, value]) => `${name} = ${valueText(value)}`);
}

// Makes an element of HTML with attributes and children; texts are never read as HTML.
function html(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

function shortened(text, most) {
  return text.length > most ? `${text.slice(0, most - 1)}…` : text;
}

function byId(name) {
  return document.getElementById(name);
}
