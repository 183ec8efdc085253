// SPDX-License-Identifier: BSD-3-Clause
// What has to be said, in #message: one thing at a time, the worst first.

import { inPlainWords, isRefusal } from "./refusal.js";
import { apart, t } from "./words.js";

const box = document.getElementById("message");
const words = document.getElementById("message-text");
const action = document.getElementById("message-action");
const dismiss = document.getElementById("dismiss");

let dismissed = ""; // the text that the person has put away

dismiss.addEventListener("click", () => {
  dismissed = words.textContent;
  box.hidden = true;
});

const reload = () => ({ label: t("Reload"), act: () => location.reload() });

// The session's message about a failed part, for users who do not know of parts.
function partSentence(error, name) {
  const [, part, why] = error.match(/^([a-z-]+\/\S+) of \S+ cannot be loaded: (.*)$/s) ?? [];
  return sentence(part && !isRefusal(why)
    ? t("a part of “{name}” is missing ({part}): {why}", { name, part, why: inPlainWords(why) })
    : inPlainWords(part ? why : error));
}

// Makes a sentence of a text without capital and full stop.
function sentence(text) {
  const begun = text.charAt(0).toUpperCase() + text.slice(1);
  return /[.!?…؟]$/.test(begun) ? begun : begun + ".";
}

// The message for the viewer's state, or null: { text; label and act of its button; good; stays: cannot be put away
// }.
//
// situation:
//   status       of the viewer
//   name         of the model
//   failed       why the viewer has stopped, or null
//   contextLost
//   listed       whether there is a list of models
//   listTrouble  why there is no new list
//   lacksToken   the server requires a token
//   contact      what it says to those who have none: who runs it, and how to get one
//   away         nothing comes from the server
//   wellAgain    it does again
//   offline      only what is kept can be shown
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
    const missing = status.error && !status.targetLevel; // not even its description
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

// Whether anything is said.
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
    words.textContent = message.text; // screen readers say it whenever it is set
  }
  action.hidden = !message.label;
  action.textContent = message.label ?? "";
  action.onclick = message.act ?? null;
  dismiss.hidden = message.stays ?? false;
  return true;
}

// A message after which the viewer cannot continue.
export function showEnd(text) {
  showMessage({ text, stays: true, ...reload() });
}
