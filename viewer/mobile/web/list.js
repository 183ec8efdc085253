// SPDX-License-Identifier: BSD-3-Clause
// The list of models: an entry for each, with its title and room for a picture. Pictures and search come with gallery.js, which
// is fetched when there is time, or when there are many models.

import { mayKeep, root } from "./line.js";
import { storedPaths } from "./storage.js";
import { language, t } from "./words.js";

const place = document.getElementById("models");
const manyModels = 12; // with more models than this, there is a search

let pages = ""; // the folder where each model has its own page; "" if there is none

// Returns the address of the model's page, if it has one.
export const pageOf = (id) => pages && root + pages + id;

// The title without characters that would change the direction of the text after it.
export const nameOf = ({ title, id }) => title?.replace(/[\u202a-\u202e\u2066-\u2069]/g, "").trim() || id;

// Reads models and site from a list that the viewer has accepted; other members are ignored.
export function readList(bytes) {
  const { models, site, pages: folder } = JSON.parse(new TextDecoder().decode(bytes));
  pages = folder === "m/" && folder;
  const text = (value) => (typeof value === "string" ? value.trim() : "");
  const { compare } = new Intl.Collator(language, { numeric: true });
  const all = models.map(({ id, digest, title, description, vertices, triangles, notes }) =>
    ({ id, digest, title: text(title), description: text(description), vertices, triangles, notes }));
  return {
    models: all.sort((one, other) => compare(nameOf(one), nameOf(other)) || compare(one.id, other.id)),
    site: { title: text(site?.title), text: text(site?.text) },
  };
}

export function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

function entry(model, choose) {
  const picture = make("span", { className: "picture" }, make("img", { alt: "", hidden: true, decoding: "async" }));
  const words = make("span", { className: "words" }, make("span", { className: "name", dir: "auto", textContent: nameOf(model) }));
  if (model.description) {
    words.append(make("span", { className: "facts", dir: "auto", textContent: model.description }));
  }
  words.append(make("span", { className: "kept", textContent: t("available offline"), hidden: true }));
  const button = make("button", { type: "button" }, picture, words);
  button.dataset.model = model.id;
  button.addEventListener("click", () => choose(model.id));
  return make("li", {}, button);
}

export const entryOf = (id) => place.querySelector(`[data-model="${CSS.escape(id)}"]`);

// choose: called with the id of the model that is chosen.
export function showEntries(models, choose) {
  marked = null;
  place.replaceChildren(...models.map((model) => entry(model, choose)));
  document.getElementById("search").hidden = models.length <= manyModels;
}

let ownHeading = ""; // the page's own heading, in the user's language

export function showSite({ title, text }) {
  const heading = document.getElementById("site");
  ownHeading ||= heading.textContent;
  heading.textContent = title || ownHeading;
  const introduction = document.getElementById("introduction");
  introduction.textContent = text;
  introduction.hidden = !text;
}

let marked = null; // id

// Call this in every frame.
export function markChosen(id) {
  if (marked !== id) {
    marked = id;
    for (const button of place.querySelectorAll("button")) {
      button.setAttribute("aria-pressed", button.dataset.model === id);
    }
  }
}

// Returns the models that open without a network: their description and preview are stored.
export async function findKept(models) {
  const paths = mayKeep() ? await storedPaths() : new Set();
  const begins = new Set([...paths].map((path) => path.split("/", 5).join("/")));
  return models.filter(({ id, digest }) =>
    paths.has(`/api/models/${id}/model.json`) && begins.has(`/api/models/${id}/${digest}`));
}

export async function markKept(models) {
  const kept = await findKept(models);
  for (const model of models) {
    const mark = entryOf(model.id)?.querySelector(".kept");
    if (mark) {
      mark.hidden = !kept.includes(model);
    }
  }
}
