// SPDX-License-Identifier: BSD-3-Clause
// The page in the frame of a <kdstream-viewer> (embed.js) on somebody's page: answers what that asks for, and tells it what
// is seen.
//
// Whoever embeds the viewer is not trusted with what a token gives: where there is one, only pages of the same origin are
// answered.

import { hasToken } from "./page.js";

const deeds = {
  home: ({ viewer }) => viewer.goHome(),
  side: ({ viewer }, side) => viewer.lookFromSide(String(side)),
  spin: ({ viewer }, spins) => viewer.setSpinning(Boolean(spins)),
  follow: ({ follow }, link) => follow(String(link).slice(0, 2048)),
  link: ({ viewer }) => viewer.link(),
  status: ({ status }) => status(),
  picture: ({ canvas, redraw }) => {
    redraw(); // a canvas keeps its picture for as long as this turn lasts
    return new Promise((done) => {
      canvas.toBlob(done, "image/png");
    });
  },
};

// page: { canvas, viewer, exchange, wake, redraw, follow(link), status() }.
export class Embedding {
  #page;
  #told = { ready: false, link: "", error: "" };

  constructor(page) {
    this.#page = page;
    addEventListener("message", (message) => this.#answer(message));
  }

  // The page's own origin is answered in any case, others where nothing is guarded.
  #mayTell() {
    try {
      return !hasToken() || window.parent.location.origin === location.origin;
    } catch { // another origin
      return false;
    }
  }

  async #answer({ source, data }) {
    const deed = Object.hasOwn(deeds, data?.deed) ? deeds[data.deed] : null;
    if (source !== window.parent || data?.kdstream !== 1 || !data.id) {
      return;
    }
    const answer = (told) => source.postMessage({ kdstream: 1, id: data.id, ...told }, "*");
    if (!deed) {
      answer({ error: "The viewer does not know this." });
    } else if (!this.#mayTell()) {
      answer({ error: "Models that need a token are shown, but nothing is told of them." });
    } else {
      const result = await deed(this.#page, data.value);
      this.#page.exchange();
      this.#page.wake();
      answer({ result });
    }
  }

  // After each change of what is shown.
  show() {
    const { idle, shownLevel, error, drawingError, trouble } = this.#page.status();
    const tell = (event, detail) => window.parent.postMessage({ kdstream: 1, event, detail }, "*");
    if (!this.#told.ready && shownLevel !== null) {
      this.#told.ready = true;
      tell("ready");
    }
    if (!this.#mayTell()) {
      return;
    }
    const wrong = error || drawingError || trouble || "";
    if (wrong !== this.#told.error) {
      this.#told.error = wrong;
      wrong && tell("error", wrong);
    }
    if (idle && this.#told.ready) {
      const link = this.#page.viewer.link();
      if (link !== this.#told.link) {
        this.#told.link = link;
        tell("viewchange", link);
      }
    }
  }
}
