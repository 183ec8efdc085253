// SPDX-License-Identifier: BSD-3-Clause
// The page in the frame of a <kdstream-viewer> (embed.js) on another page: answers its messages, and reports what is visible.
//
// One finger scrolls the embedding page until a tap or two fingers have entered the viewer. Then it turns the model, until the
// user taps outside the frame, or scrolls the frame out of sight. A button shows the viewer in full screen, or in a tab of its
// own if the browser does not allow that for frames.
//
// Embedding pages must not get data that needs a token. So if there is a token, only pages of the same origin get answers.

import { hasToken } from "./line.js";

const commands = {
  home: ({ viewer }) => viewer.goHome(),
  side: ({ viewer }, side) => viewer.lookFromSide(String(side)),
  spin: ({ viewer }, spins) => viewer.setSpinning(Boolean(spins)),
  follow: ({ follow }, link) => follow(String(link).slice(0, 2048)),
  link: ({ viewer }) => viewer.link(),
  status: ({ status }) => status(),
  picture: ({ canvas, redraw }) => {
    redraw(); // a canvas keeps its picture only until the current task ends
    return new Promise((done) => {
      canvas.toBlob(done, "image/png");
    });
  },
};

const leastSeen = 0.5; // share of the frame: if less is visible, the user is busy elsewhere

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
    let isByPointer = true; // otherwise the viewer was entered without the pointer, and the focus stays where it is
    fingers.onEnter = () => {
      document.body.toggleAttribute("data-entered", fingers.entered);
      fingers.entered && isByPointer && canvas.focus({ preventScroll: true });
      wake();
    };
    const asked = new URLSearchParams(location.search);
    const isEntered = asked.get("embed") === "entered"; // for embedding pages that do not scroll with a finger on the frame
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

  // Pages of the same origin always get reports, others only if there is no token.
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

  // Call this after each change of what is shown.
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
        post("failed"); // without the reason; it only says that the poster must not hide the error
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
