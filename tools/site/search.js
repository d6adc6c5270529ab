// SPDX-License-Identifier: LGPL-3.0-or-later
// Print the first pages that the search of the site finds: search.js FOLDER QUERY...
const fs = require("fs");
const path = require("path");
const vm = require("vm");

const [site, ...queries] = process.argv.slice(2);
const statics = path.join(site, "_static");
// As much of a browser as the scripts touch while they are loaded.
const element = { dataset: { content_root: "" }, addEventListener() {} };
const context = {
  console, URLSearchParams, RegExp, Map, Set,
  document: {
    documentElement: element, addEventListener() {}, readyState: "loading",
    querySelector: () => null, querySelectorAll: () => [], getElementById: () => null,
  },
  localStorage: { setItem() {}, getItem: () => null, removeItem() {} },
  location: { search: "", pathname: "/", href: "" },
};
context.window = context;
vm.createContext(context);
const run = (file) => vm.runInContext(fs.readFileSync(file, "utf-8"), context, { filename: file });
for (const name of ["documentation_options.js", "doctools.js", "sphinx_highlight.js"]) {
  const file = path.join(statics, name);
  if (fs.existsSync(file)) run(file);
}
run(path.join(statics, "language_data.js"));
const tools = fs.readFileSync(path.join(statics, "searchtools.js"), "utf-8");
vm.runInContext(tools + "\nthis.Search = Search;", context);
run(path.join(site, "searchindex.js"));

const found = {};
for (const query of queries) {
  const parsed = vm.runInContext(`Search._parseQuery(${JSON.stringify(query)})`, context);
  context.parsed = parsed;
  const results = vm.runInContext("Search._performSearch(...parsed)", context);
  found[query] = results.reverse().slice(0, 3).map((result) => result[0]);
}
console.log(JSON.stringify(found));
