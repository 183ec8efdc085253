// SPDX-License-Identifier: BSD-3-Clause
// Requests the list of models again: after a failure, while the list is empty, and while the server cannot be reached.

import { getList, isOffline } from "./line.js";

const firstRetry = 1; // s
const longestRetry = 8;
const offlineRetry = 8;
const emptyRetry = 5; // for a server that has no models yet

const spread = (seconds) => seconds * (1 + Math.random()); // so that not all pages ask at the same time when a server comes back

export class Refreshing {
  trouble = ""; // why the last list could not be loaded

  #timer = 0; // 0: no request is running or planned
  #retry = firstRetry; // s
  #take;
  #online;
  #ended;

  // take: called with the bytes of a list; returns the number of models in it, or throws if it is not a list. online: called when
  // the server can be reached again. ended: called after every attempt.
  constructor(take, online, ended) {
    this.#take = take;
    this.#online = online;
    this.#ended = ended;
  }

  async refresh() {
    clearTimeout(this.#timer);
    this.#timer = -1; // a request is running
    const wasOffline = isOffline();
    try {
      const count = this.#take(await getList());
      this.trouble = "";
      this.#retry = firstRetry;
      if (isOffline()) {
        this.#refreshIn(spread(offlineRetry));
      } else {
        count || this.#refreshIn(emptyRetry);
        wasOffline && this.#online();
      }
    } catch (error) {
      this.trouble = error.message;
      this.#refreshIn(spread(Math.max(this.#retry, error.retryAfter ?? 0)));
      this.#retry = Math.min(2 * this.#retry, longestRetry);
    }
    this.#timer = Math.max(this.#timer, 0);
    this.#ended();
  }

  #refreshIn(seconds) {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.refresh(), 1000 * seconds);
  }

  // Call this from time to time, because other requests may find that the server cannot be reached.
  watch() {
    if (isOffline() && this.#timer === 0) {
      this.#refreshIn(spread(offlineRetry));
    }
  }
}
