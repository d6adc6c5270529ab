// SPDX-License-Identifier: LGPL-3.0-or-later
// What a search finds first: titles of pages, other headings, then texts of the guide, then the API
// reference, and what has changed last.
var Scorer = {
  score: ([page, title, anchor, description, score, file, kind]) =>
    score * (kind === "title" ? (anchor ? 4 : 6) : 1) *
    (page === "changes" ? 0.1 : page.startsWith("api/") ? 0.5 : 1),
  // The values that Sphinx has without this file.
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
