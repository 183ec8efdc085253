// SPDX-License-Identifier: BSD-3-Clause
// The page in the frame of a <kdstream-viewer> (embed.js) on somebody's page: answers its messages, and reports what is visible.
//
// One finger scrolls that page, until a tap or two fingers have entered the viewer. Then it turns the model, until the user taps
// beside the frame, or scrolls it away. A button shows the viewer in full screen, or in a tab of its own if the browser does not
// allow frames to do that.
//
// Embedding pages are not trusted with what a token gives access to: if there is a token, only pages of the same origin are
// answered.

import { hasToken } from "./line.js";

const commands = {
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

const leastSeen = 0.5; // part of the frame: if less is visible, the fingers are elsewhere

async function fillScreen(viewer) {
  try {
    await (document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen());
  } catch {
    const address = new URL(location);
    address.searchParams.delete("embed");
    address.hash = viewer.link();
    window.open(address);
  }
}

// page: { canvas, viewer, fingers, exchange, wake, redraw, follow(link), status() }.
export class Embedding {
  #page;
  #reported = { ready: false, link: "", error: "" };
  #leave;

  constructor(page) {
    this.#page = page;
    addEventListener("message", (message) => this.#answer(message));
    const { canvas, viewer, fingers, wake } = page;
    const open = document.getElementById("open");
    open.addEventListener("click", () => fillScreen(viewer));
    let isByPointer = true; // else the frame has entered the viewer by itself, and the keyboard is elsewhere
    fingers.onEnter = () => {
      document.body.toggleAttribute("data-entered", fingers.entered);
      fingers.entered && isByPointer && canvas.focus({ preventScroll: true });
      wake();
    };
    const asked = new URLSearchParams(location.search);
    const isEntered = asked.get("embed") === "entered"; // the embedding page does not scroll over the frame
    const leave = () => {
      isByPointer = false;
      fingers.enter(isEntered || Boolean(document.fullscreenElement));
      isByPointer = true;
    };
    document.addEventListener("fullscreenchange", () => {
      open.setAttribute("aria-pressed", Boolean(document.fullscreenElement));
      leave();
    });
    addEventListener("blur", leave);
    new IntersectionObserver(([{ intersectionRatio }]) => intersectionRatio < leastSeen && leave(), { threshold: [0, leastSeen] })
      .observe(canvas);
    this.#leave = leave;
    leave();
  }

  // The page's own origin is answered in any case, others where nothing is guarded.
  #mayReport() {
    try {
      return !hasToken() || window.parent.location.origin === location.origin;
    } catch { // another origin
      return false;
    }
  }

  async #answer({ source, data }) {
    const command = Object.hasOwn(commands, data?.deed) ? commands[data.deed] : null;
    if (source !== window.parent || data?.kdstream !== 1) {
      return;
    }
    if (!data.id) {
      data.deed === "leave" && this.#leave();
      return;
    }
    const answer = (reply) => source.postMessage({ kdstream: 1, id: data.id, ...reply }, "*");
    if (!command) {
      answer({ error: "Unknown request." });
    } else if (!this.#mayReport()) {
      answer({ error: "No details are given about models that need a token." });
    } else {
      const result = await command(this.#page, data.value);
      this.#page.exchange();
      this.#page.wake();
      answer({ result });
    }
  }

  // After each change of what is shown.
  show() {
    const { idle, shownLevel, error, drawingError, trouble } = this.#page.status();
    const post = (event, detail) => window.parent.postMessage({ kdstream: 1, event, detail }, "*");
    if (!this.#reported.ready && shownLevel !== null) {
      this.#reported.ready = true;
      post("ready");
    }
    const mayReport = this.#mayReport();
    const wrong = error || drawingError || trouble || "";
    if (wrong !== this.#reported.error) {
      this.#reported.error = wrong;
      if (wrong && mayReport) {
        post("error", wrong);
      } else if (wrong && !this.#reported.ready) {
        post("failed"); // not why: only that the poster must not hide it
      }
    }
    if (mayReport && idle && this.#reported.ready) {
      const link = this.#page.viewer.link();
      if (link !== this.#reported.link) {
        this.#reported.link = link;
        post("viewchange", link);
      }
    }
  }
}
