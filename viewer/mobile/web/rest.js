// SPDX-License-Identifier: BSD-3-Clause
// Loads what is needed only after the first picture: the rest of the viewer (parts.js) and the style sheet for everything that
// opens over the picture. Loading the rest is repeated until it succeeds, and code can wait for it.

import { make } from "./list.js";
import { isWhole, loadSecondPart } from "./parts.js";

const firstRetry = 1; // s
const longestRetry = 8;

/* global restBytes: of the WebAssembly's second part, by MakePage.cmake */

let style = null; // a promise

// Resolves when the style sheet is loaded, or cannot be loaded. In the latter case sheets open without style, and the next call
// tries again.
export function loadStyle() {
  return style ??= new Promise((resolve) => {
    const link = make("link", { rel: "stylesheet", href: new URL("later.css", import.meta.url).href, onload: resolve });
    link.onerror = () => {
      link.remove();
      style = null;
      resolve();
    };
    document.head.append(link);
  });
}

export class Rest {
  failed = false; // loading failed and is tried again
  outdated = false; // the server has another version of the part
  awaited = 0; // the number of callers that wait for the part

  #bytes = 0; // bytes of the part that have arrived
  #changed;
  #coming = null; // a promise
  #goOn = () => {};

  // changed: called when any of these has changed.
  constructor(changed) {
    this.#changed = changed;
  }

  // Resolves when the rest is loaded, however long that takes; at once if it is.
  async wait() {
    if (!isWhole()) {
      ++this.awaited;
      await this.fetch();
      --this.awaited;
    }
  }

  fetch() {
    return this.#coming ??= this.#fetch();
  }

  // The share of the rest that has arrived, 0-1.
  part() {
    return Math.min(this.#bytes / restBytes, 1);
  }

  // Repeats now what would be repeated later.
  retryNow() {
    this.#goOn();
  }

  async #fetch() {
    loadStyle();
    for (let retry = firstRetry; !isWhole(); retry = Math.min(2 * retry, longestRetry)) {
      try {
        await loadSecondPart((bytes) => {
          this.#bytes = bytes;
          this.#changed();
        });
      } catch (error) {
        this.failed = true;
        this.outdated = error.outdated ?? false;
        this.#changed();
        await this.#pause(retry);
      }
    }
    this.failed = this.outdated = false;
    this.#changed();
  }

  // The pause is random, so that not all pages return to a restarted server at the same time.
  #pause(seconds) {
    return new Promise((resolve) => {
      this.#goOn = resolve;
      setTimeout(resolve, 1000 * seconds * (1 + Math.random()));
    });
  }
}
