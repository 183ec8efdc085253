// SPDX-License-Identifier: BSD-3-Clause
// How to move a model: the help, and a finger that shows it once. Fetched when one of them is needed.

import { makeButton } from "./elements.js";
import { make } from "./list.js";
import { t } from "./words.js";

// [what the user does, what it does]
const byFingers = () => [
  [t("One finger"), t("turns the model")],
  [t("Two fingers"), t("move it, and bring it nearer")],
  [t("Double tap on the surface"), t("shows the original there")],
  [t("Double tap beside the model"), t("returns to the first view")],
];
const byMouse = () => [
  [t("Drag"), t("turns the model")],
  [t("Right button, or Shift"), t("moves it")],
  [t("Wheel"), t("brings it nearer")],
  [t("Double click on the surface"), t("shows the original there")],
  [t("Double click beside the model"), t("returns to the first view")],
];
const byKeys = () => [
  [t("Arrow keys"), t("turn the model; with Shift they move it")],
  ["+ −", t("bring it nearer, or farther away")],
  ["H", t("returns to the first view")],
  ["U", t("undoes the last jump")],
  ["?", t("shows this help")],
  [t("Escape"), t("closes the open panel, then returns to the list")],
];

// Returns the content of the sheet. hasOriginal: whether the original can be shown.
export function describeHelp(coarse, hasOriginal, close) {
  const rows = (coarse ? byFingers() : [...byMouse(), ...byKeys()]).filter(([, what]) => hasOriginal || what !== t("shows the original there"));
  return [
    make("h2", { textContent: t("Help") }),
    make("dl", {}, ...rows.flatMap(([by, what]) => [make("dt", { textContent: by }), make("dd", { textContent: what })])),
    makeButton("Close", close, { className: "plain" }),
  ];
}

const key = "kdstream.finger";

// Shows a moving finger over the picture for some seconds, or until the user acts.
export function showFinger(canvas) {
  try {
    if (localStorage.getItem(key)) {
      return;
    }
    localStorage.setItem(key, "shown");
  } catch {
    // then the finger appears each time
  }
  const space = "http://www.w3.org/2000/svg";
  const finger = document.createElementNS(space, "svg");
  const path = document.createElementNS(space, "path");
  Object.assign(finger.style, { position: "absolute", left: "calc(50% - 36px)", top: "55%", width: "72px", height: "72px",
    fill: "#1d1c19", stroke: "#f1eee8", strokeWidth: 1.2, pointerEvents: "none" });
  finger.id = "finger";
  finger.setAttribute("viewBox", "0 0 24 24");
  finger.setAttribute("aria-hidden", "true");
  path.setAttribute("d", "M9 11V4.5a1.5 1.5 0 0 1 3 0V10l5.6 1.4a2 2 0 0 1 1.5 2.2l-.6 4.6A3 3 0 0 1 15.5 21H11a3 3 0 0 1-2.3-1L4.5 15a1.4 1.4 0 0 1 2-2L9 15z");
  finger.append(path);
  canvas.after(finger);
  const end = () => finger.remove();
  const at = (x, opacity) => ({ transform: `translateX(${x}px)`, opacity });
  finger.animate([at(-70, 0), at(-70, 1), at(70, 1), at(70, 0)], { duration: 1800, iterations: 2, easing: "ease-in-out" }).onfinish = end;
  canvas.addEventListener("pointerdown", end, { once: true });
  document.addEventListener("keydown", end, { once: true });
}
