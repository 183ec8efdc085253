// SPDX-License-Identifier: BSD-3-Clause
// Loads the rest of the viewer (parts.js): tries again and again, and lets code wait for it.

import { isWhole, loadSecondPart } from "./parts.js";

const firstRetry = 1; // s
const longestRetry = 8;

/* global restBytes: of the WebAssembly's second part, by MakePage.cmake */

export class Rest {
  failed = false; // it could not be had, and is tried again
  outdated = false; // the server has that of another version
  awaited = 0; // the number of callers that wait for it

  #bytes = 0; // of it, that have come
  #changed;
  #coming = null; // a promise
  #goOn = () => {};

  // changed: called when any of these has.
  constructor(changed) {
    this.#changed = changed;
  }

  // Once it is there; however long that takes. At once where it is.
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

  // How much of it has come, 0-1.
  part() {
    return Math.min(this.#bytes / restBytes, 1);
  }

  // Tries now what would be tried later.
  retryNow() {
    this.#goOn();
  }

  async #fetch() {
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

  // Not all at once when a server comes back.
  #pause(seconds) {
    return new Promise((resolve) => {
      this.#goOn = resolve;
      setTimeout(resolve, 1000 * seconds * (1 + Math.random()));
    });
  }
}
