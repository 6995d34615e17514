/* Ranking of the full-text search.

   Sphinx shows only pages with every word of a query, and ranks them by their best word. People type questions: words that a
   page says otherwise, and words such as "how". Here a page may lack some of the words, rare words weigh more than common ones,
   words of titles more than words of the text, and the pages that answer questions more than the tables of studies. */
"use strict";
(() => {
  if (typeof Search === "undefined") return; // not the search page

  // Words of questions, as stems; they count if there are no others.
  const ASIDE = new Set("how what whi when where which who my me i do doe did can should must need get want use ani".split(" "));
  const SECTIONS = [
    [/^questions\//, 1.5],
    [/^(how-to|tutorial|coming-from)\//, 1.25],
    [/^(study|decisions)\/|^(changelog|fuzzing|contributing)/, 0.7],
  ];
  const TITLE = 3; // weight of a word in a title, over that in the text
  const PARTIAL = 0.4; // of a word that is only a part of one in the page
  const ENOUGH = 0.4; // least share of the weight of all words that a page has

  const list = (files) => (files === undefined ? [] : Array.isArray(files) ? files : [files]);

  // Files with a word, and how well: 1, or less for a part of a word.
  const matches = (index, word) => {
    if (Object.hasOwn(index, word)) return new Map(list(index[word]).map((file) => [file, 1]));
    const found = new Map();
    if (word.length > 2)
      for (const [term, files] of Object.entries(index))
        if (term.includes(word)) for (const file of list(files)) found.set(file, PARTIAL);
    return found;
  };

  Search.performTermsSearch = (searchTerms, excludedTerms) => {
    const { terms, titleterms, titles, docnames, filenames } = Search._index;
    const all = [...searchTerms];
    const some = all.filter((word) => !ASIDE.has(word));
    let possible = 0;
    const scores = new Map();
    const shares = new Map();
    for (const word of some.length ? some : all) {
      const inText = matches(terms, word);
      const inTitle = matches(titleterms, word);
      const files = new Set([...inText.keys(), ...inTitle.keys()]);
      const rarity = Math.log(1 + docnames.length / (1 + files.size));
      possible += rarity;
      for (const file of files) {
        const [text, title] = [inText.get(file) ?? 0, inTitle.get(file) ?? 0];
        shares.set(file, (shares.get(file) ?? 0) + rarity);
        scores.set(file, (scores.get(file) ?? 0) + rarity * (text + TITLE * title));
      }
    }
    const excluded = new Set([...excludedTerms].flatMap((word) => [...list(terms[word]), ...list(titleterms[word])]));
    const results = [];
    for (const [file, score] of scores) {
      if (excluded.has(file) || shares.get(file) < ENOUGH * possible) continue;
      const factor = SECTIONS.find(([section]) => section.test(docnames[file]))?.[1] ?? 1;
      // Between the scores of titles and objects, which Sphinx finds by the whole query.
      const scaled = (10 * factor * score) / possible;
      results.push([docnames[file], titles[file], "", null, scaled, filenames[file], SearchResultKind.text]);
    }
    return results;
  };

  // Excerpts come from a file of the site, because a page that is opened from a folder may not read other pages. Below its title
  // a result has the part of the page with a word of the query, not the title again.
  const LENGTH = 240; // characters of an excerpt
  const BEFORE = 80; // characters before the word
  const script = document.createElement("script");
  const loaded = new Promise((resolve) => { script.onload = script.onerror = () => resolve(window.SEARCH_TEXTS ?? {}); });
  script.src = `${document.documentElement.dataset.content_root ?? ""}_static/search-texts.js`;
  document.head?.append(script);
  const inPage = window.fetch?.bind(window);
  window.fetch = async (url, ...options) => {
    const texts = await loaded;
    const page = decodeURI(String(url)).replace(/^(\.\/|\.\.\/)+/, "").replace(/\.html$/, "");
    return Object.hasOwn(texts, page) ? { ok: true, text: async () => texts[page] } : inPage(url, ...options);
  };
  Search.makeSearchSummary = (text, keywords) => {
    const lower = text.toLowerCase();
    const places = [...keywords].filter((word) => !ASIDE.has(word)).map((word) => lower.indexOf(word.toLowerCase())).filter((place) => place >= 0);
    const start = places.length ? Math.max(0, Math.min(...places) - BEFORE) : 0;
    const from = start ? text.indexOf(" ", start) + 1 : 0;
    const summary = document.createElement("p");
    summary.classList.add("context");
    summary.textContent = `${from ? "… " : ""}${text.slice(from, from + LENGTH).replace(/\s\S*$/, "")}${from + LENGTH < text.length ? " …" : ""}`;
    return summary;
  };
})();
