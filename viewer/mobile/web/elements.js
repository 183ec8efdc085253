// SPDX-License-Identifier: BSD-3-Clause
// Functions by which tools and sheets make their elements.

import { make } from "./list.js";
import { t } from "./words.js";

export function makeButton(text, act, properties = {}) {
  const button = make("button", { type: "button", textContent: t(text), ...properties });
  button.addEventListener("click", act);
  return button;
}

export function group(title, ...children) {
  return make("fieldset", {}, make("legend", { textContent: t(title) }), ...children);
}

// Shows a text for some seconds, over everything that is open.
export function notice(text) {
  let box = document.getElementById("notice");
  if (!box) {
    box = make("p", { id: "notice", role: "status" });
    document.body.append(box);
  }
  clearTimeout(box.timer);
  box.timer = setTimeout(() => (box.textContent = ""), 6000);
  requestAnimationFrame(() => (box.textContent = text)); // a change is announced; the text of a new element is not
}

export function download(blob, name) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
