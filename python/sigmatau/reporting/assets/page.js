// Elements, colours and the data of the page.

/** The data that the charts draw: of the page itself, or of the result that an application shows. */
export let content = JSON.parse(document.getElementById("charts")?.textContent ?? "null");

export function setContent(charts) {
  content = charts;
}

/** An element: make("button", {type: "button", onclick: f}, "Text", child). Text is never read as HTML. */
export function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key in made && key !== "list") made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** A colour of the style sheet: colour("axis-0"). */
export function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

/** The colour of a channel among all of its sensor; beyond six, hues evenly spread. */
export function channelColour(k, count) {
  if (count <= 6) return colour(`axis-${k}`);
  const dark = getComputedStyle(document.documentElement).colorScheme === "dark";
  return `hsl(${Math.round((360 * k) / count)} 65% ${dark ? 65 : 36}%)`;
}
