// SPDX-License-Identifier: BSD-3-Clause
// Which model is shown, and how: the list, links to views, colours; and repeating requests that have failed.

import { isOffline } from "./line.js";
import { entryOf, findKept, markKept, readList, showEntries, showSite } from "./list.js";
import { previewsAreAsked, showPreview, showsPreview } from "./previews.js";
import { Refreshing } from "./refreshing.js";
import { t } from "./words.js";
import { lastStatus, rest, wake } from "./frames.js";
import { find, isEmbedded, line, say, viewer } from "./shared.js";

export let models = null; // the list of models, once it has arrived
export let linked = ""; // a link to a view that waits for the list, or for the rest of the viewer
export let linkTrouble = ""; // why the last link opened nothing
export let site = { title: "", text: "" };
export let update = null; // switches to a newer version of the page
let gallery = null; // the list's pictures and search, once their code is loaded
let keptPage = false; // whether the page's files were requested to be stored
export const refreshing = new Refreshing(takeList, askAgain, wake); // repeats requests that have failed

export function selectedModel() {
  const id = lastStatus.model ?? "";
  return models?.find((model) => model.id === id) ?? { id, title: lastStatus.title };
}

// ---- the list of models

// Takes the list as the server sent it, and returns the number of models in it. Throws if it is not a list.
function takeList(bytes) {
  const trouble = viewer.setModels(bytes);
  if (trouble) {
    throw new Error(trouble);
  }
  showModels(readList(bytes));
  return models.length;
}

function showModels(list) {
  site = list.site;
  showSite(site);
  if (JSON.stringify(list.models) !== JSON.stringify(models)) {
    models = list.models;
    showEntries(models, choose);
    gallery?.show(models);
  }
  markKept(models);
  const none = find("empty");
  none.hidden = models.length > 0;
  say(none, t("This server has no models yet. New models appear here."));
  if (models.length && viewer.status().mode === "no model") {
    selectFirst();
  }
  if (!find("search").hidden) {
    openGallery();
  }
}

// Loads the list's pictures and its search.
export async function openGallery() {
  const { Gallery } = await import("./gallery.js");
  if (!gallery) {
    gallery = new Gallery({ status: () => lastStatus, savesData: () => find("menu").elements.ahead.value === "0", rest: () => rest.fetch() });
    gallery.show(models);
  }
}

// Starts work that can wait until there is a picture.
export async function goOnOnce() {
  if (keptPage) {
    return;
  }
  keptPage = true;
  await rest.fetch();
  if (!isEmbedded) {
    openGallery().catch(() => {}); // then the list is without pictures
  }
  const { keepPage } = await import("./offline.js");
  keepPage((change) => {
    update = change;
    wake();
  });
}

// Selects a link's model or, after a reload in full screen, the model of that time; otherwise the first. Offline, only a stored
// model.
async function selectFirst() {
  if (linked) {
    followLink(linked);
    return;
  }
  const earlier = models.find(({ id }) => id === history.state?.model);
  if (!earlier && previewsAreAsked()) {
    goOnOnce(); // it may take long until there is a picture
    return;
  }
  const first = earlier ?? (isOffline() ? await findKept(models) : models)[0];
  if (!first) {
    goOnOnce();
  } else if (viewer.status().mode === "no model") {
    viewer.select(first.id);
    earlier && viewer.enterFullScreen();
    line.exchange();
    wake();
  }
}

// The first click on a model shows its preview, the second opens it in full screen.
function choose(model) {
  linked = linkTrouble = coloursOfLink = "";
  if (!previewsAreAsked() || showsPreview() || model !== lastStatus.model) {
    viewer.select(model);
  }
  showPreview(true);
  line.exchange();
  wake();
}

export const canClosePreview = () => lastStatus.mode !== "full screen" && previewsAreAsked() && showsPreview();

export function closePreview() {
  showPreview(false);
  entryOf(lastStatus.model)?.focus({ preventScroll: true });
}

// ---- links

// Returns the view after the # of the URL, or the model whose page this is (m/ID); "" if there is none.
export function linkInAddress() {
  const view = location.hash.slice(1);
  const page = location.pathname.match(/\/m\/([^/]+)\/?$/);
  return (/(^|&)model=/.test(view) ? view : page ? `model=${page[1]}&${view}` : "").slice(0, mostOfLink);
}

const mostOfLink = 1e4; // characters; more than in any valid link

// Follows the link in the URL, or keeps it until there is a list.
export function takeLink() {
  models?.length ? followLink(linkInAddress()) : (linked = linkInAddress());
}

let hasDistances = false; // the last link has distances that have not been shown yet

// Returns whether the last link had distances; false until there is another such link.
export const takeDistances = () => hasDistances && !(hasDistances = false);

export let colouring = "own"; // in the form that links have
let coloursOfLink = ""; // kept until another model is chosen

export function colourBy(colors) {
  colouring = colors;
  viewer.setColors(colors);
  find("menu").elements.coloring.forEach((radio) => (radio.checked = radio.value === colors));
}

// Call this if the model does not have the array that it should be coloured by.
export function missColours() {
  if (colouring === coloursOfLink) {
    coloursOfLink = "";
    linkTrouble = "this link to a view has an invalid value for colours";
    wake();
  }
}

// If several links are followed before the rest of the viewer is there, only the last one counts.
export async function followLink(link) {
  linked = link;
  await rest.wait();
  if (linked !== link) {
    return;
  }
  linked = "";
  const parameters = new URLSearchParams(link);
  hasDistances = parameters.has("distances");
  const menu = find("menu").elements;
  menu.detail.value = parameters.get("detail") === "level" ? "1" : "0";
  menu.turning.value = parameters.get("turning") === "free" ? "1" : "0";
  colourBy(coloursOfLink = link.match(/colours=([^&]*)/)?.[1] ?? "own"); // not decoded, as links have it
  viewer.follow(link);
  const { mode, error } = viewer.status();
  linkTrouble = mode === "no model" ? error : ""; // the link does not name a model of the list
  if (linkTrouble && !isEmbedded) {
    selectFirst();
  }
  line.exchange();
  wake();
}

// ---- trying again

// Requests again what has failed.
export function askAgain() {
  linkTrouble = "";
  line.distrustCache();
  viewer.select(lastStatus.model);
  if (lastStatus.mode !== "full screen") {
    viewer.leaveFullScreen();
  }
  line.exchange();
  wake();
}

export function tryNow() {
  line.retryNow();
  rest.retryNow();
  refreshing.refresh();
  wake();
}
