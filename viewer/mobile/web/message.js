// SPDX-License-Identifier: BSD-3-Clause
// Messages, in #message: one at a time, the most important first.

import { inPlainWords, isRefusal } from "./refusal.js";
import { apart, t } from "./words.js";

const box = document.getElementById("message");
const words = document.getElementById("message-text");
const action = document.getElementById("message-action");
const dismiss = document.getElementById("dismiss");

let dismissed = ""; // the text that the user has closed

dismiss.addEventListener("click", () => {
  dismissed = words.textContent;
  box.hidden = true;
});

const reload = () => ({ label: t("Reload"), act: () => location.reload() });

// Rewrites the session's message about a missing part for users who do not know what a part is.
function partSentence(error, name) {
  const [, part, why] = error.match(/^([a-z-]+\/\S+) of \S+ cannot be loaded: (.*)$/s) ?? [];
  return sentence(part && !isRefusal(why)
    ? t("a part of “{name}” is missing ({part}): {why}", { name, part, why: inPlainWords(why) })
    : inPlainWords(part ? why : error));
}

// Makes a sentence of a text that lacks the capital and the full stop.
function sentence(text) {
  const begun = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?…؟]$/.test(begun) ? begun : begun + ".";
}

// Returns the message for the viewer's state, or null. A message is { text, label, act, good, stays }. label, act: of its button.
// good: it reports no problem. stays: the user cannot close it.
//
// situation:
//   status       of the viewer
//   name         of the model
//   failed       why the viewer has stopped, or null
//   contextLost  whether the canvas has lost its context
//   listed       whether there is a list of models
//   listTrouble  why there is no new list
//   lacksToken   whether the server requires a token
//   contact      the server's text for users without a token: who runs it, and how to get one
//   away         whether nothing arrives from the server
//   wellAgain    whether data arrives again
//   offline      whether only stored data can be shown
//   rest         of the viewer (rest.js)
//   update       a function, if there is a newer page
//   tryNow, askAgain, askForToken   functions
export function findMessage(situation) {
  const { status, name, listed, listTrouble } = situation;
  const again = { label: t("Try now"), act: situation.tryNow };
  const cure = situation.lacksToken ? { label: t("Enter it"), act: situation.askForToken } : again;
  const contact = situation.contact && apart(situation.contact);
  const trying = (text) => `${sentence(text)} ${situation.lacksToken ? contact : t("Trying again …")}`.trim();
  const noList = () => ({ text: trying(situation.lacksToken ? listTrouble
    : t("the list of models cannot be loaded: {why}", { why: listTrouble })), ...cure });
  if (situation.failed?.isPartMissing) {
    return { text: t("The viewer could not be loaded from the server."), stays: true, ...reload() };
  }
  if (situation.failed) {
    return { text: t("The viewer has stopped: this device does not have enough memory for this view."), stays: true, ...reload() };
  }
  if (situation.contextLost) {
    return { text: t("The device has stopped the 3D drawing. It continues as soon as the device allows it."), ...reload() };
  }
  if (!listed && listTrouble) {
    return noList();
  }
  if (situation.away) {
    return { text: trying(inPlainWords(status.trouble)), ...cure };
  }
  if (situation.offline) {
    const missing = status.error && !status.targetLevel; // not even its description is stored
    return { text: missing
      ? t("“{name}” is not stored on this device, and the server cannot be reached.", { name })
      : t("The server cannot be reached. Stored data is shown."), good: !missing, ...again };
  }
  if (situation.rest.outdated || /unknown codec/.test(status.error)) {
    return { text: t("There is a newer version of this viewer."), ...reload() };
  }
  if (situation.rest.failed) {
    return { text: trying(t("a part of the viewer cannot be loaded from the server")), ...again };
  }
  if (status.drawingError) {
    return { text: sentence(t("the picture cannot be drawn: {why}", { why: status.drawingError })), ...reload() };
  }
  if (status.error) {
    return { text: partSentence(status.error, name), label: t("Try again"), act: situation.askAgain };
  }
  if (listTrouble) {
    return noList();
  }
  if (status.stale === "removed") {
    return { text: t("“{name}” is no longer on the server. What is loaded can still be viewed.", { name }) };
  }
  if (status.stale === "replaced") {
    return { text: t("The server has a new version of “{name}”.", { name: status.title || status.model }), ...reload() };
  }
  if (situation.update) {
    return { text: t("There is a newer version of this viewer."), good: true, label: t("Reload"), act: situation.update };
  }
  return situation.wellAgain ? { text: t("Connected again."), good: true } : null;
}

// Shows the message, or hides the last one; returns whether a message is shown.
export function showMessage(message) {
  if (message?.text !== dismissed) {
    dismissed = "";
  }
  box.hidden = !message || dismissed !== "";
  if (box.hidden) {
    return false;
  }
  box.className = message.good ? "good" : "";
  if (words.textContent !== message.text) {
    words.textContent = message.text; // only if it differs: screen readers announce it whenever it is set
  }
  action.hidden = !message.label;
  action.textContent = message.label ?? "";
  action.onclick = message.act ?? null;
  dismiss.hidden = message.stays ?? false;
  return true;
}

// Shows a message after which the viewer cannot continue.
export function showEnd(text) {
  showMessage({ text, stays: true, ...reload() });
}
