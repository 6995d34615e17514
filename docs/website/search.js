// Run the search of the built site as its search page does: `node search.js SITE QUERY…` prints the pages found, as JSON.
"use strict";
const fs = require("fs");
const path = require("path");
const vm = require("vm");

const [site, ...queries] = process.argv.slice(2);
const nothing = () => {};
const element = new Proxy({}, { get: (_, name) => (name === "children" ? [] : nothing), set: () => true });
const context = {
  console: { ...console, log: nothing, debug: nothing },
  document: {
    addEventListener: nothing,
    createElement: () => element,
    getElementById: () => null,
    querySelector: () => null,
    querySelectorAll: () => [],
    documentElement: { dataset: {} },
    readyState: "loading",
  },
  localStorage: { getItem: nothing, setItem: nothing },
  location: { search: "", pathname: "/search.html" },
  navigator: { userAgent: "" },
  URLSearchParams,
};
context.window = context;
vm.createContext(context);

// The scripts of search.html that the search needs, in the order in which a browser runs them: deferred ones last.
const wanted = /(documentation_options|doctools|sphinx_highlight|searchtools|language_data|searchindex|search-ranking)\.js/;
const page = fs.readFileSync(path.join(site, "search.html"), "utf8");
const scripts = [...page.matchAll(/<script([^>]*)\bsrc="([^"?]+)[^"]*"([^>]*)>/g)]
  .filter(([, , source]) => wanted.test(source))
  .map(([, before, source, after]) => ({ source, last: /\bdefer\b/.test(before + after) }));
for (const { source } of [...scripts.filter((s) => !s.last), ...scripts.filter((s) => s.last)]) {
  vm.runInContext(fs.readFileSync(path.join(site, source), "utf8"), context, { filename: source });
}

const search = vm.runInContext(
  // The results come in ascending order; the page shows the last one first.
  "(query) => Search._performSearch(...Search._parseQuery(query)).reverse().map((result) => result[0])",
  context,
);
const found = Object.fromEntries(queries.map((query) => [query, [...new Set(search(query))]]));
process.stdout.write(JSON.stringify(found));
