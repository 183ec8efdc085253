// SPDX-License-Identifier: BSD-3-Clause
// What is shown before there is a picture: what is being loaded, and how much of it has arrived.

import { showMessage } from "./message.js";
import { t } from "./words.js";

const stallTimeout = 20000; // ms

const box = document.getElementById("loading");
const words = document.getElementById("loading-text");
const bar = box.querySelector("progress");

// text: what is loaded; part: the loaded share, 0-1, or null if unknown.
export function showLoading(text, part) {
  box.hidden = false;
  const shown = part === null ? `${text} …` : `${text}: ${Math.floor(100 * part)}\u00a0%`;
  if (words.textContent !== shown) {
    words.textContent = shown;
  }
  if (part === null) {
    bar.removeAttribute("value");
  } else {
    bar.value = part;
  }
}

export function hideLoading() {
  box.hidden = true;
}

// Shows a message if nothing arrives for long, until something does. Returns a function: call it whenever something has arrived,
// and at the end with `true`.
export function watchStall() {
  let timer = 0;
  let isReported = false;
  const silent = () => {
    isReported = true;
    showMessage({
      text: t("The server has sent nothing for a while. Still waiting …"),
      label: t("Reload"),
      act: () => location.reload(),
    });
  };
  const heard = (ended = false) => {
    clearTimeout(timer);
    if (isReported) {
      isReported = false;
      showMessage(null);
    }
    timer = ended ? 0 : setTimeout(silent, stallTimeout);
  };
  heard();
  return heard;
}
