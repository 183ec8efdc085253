// SPDX-License-Identifier: BSD-3-Clause
// <kdstream-viewer src="https://SERVER" model="ID" view="…">: the viewer on anybody's page (doc/embedding.md).
//
// The viewer itself is the server's page in a frame, which shows one model and no list. The page and this element exchange
// messages (embedding.js answers there). This is a plain script, because modules of other origins need that server's permission.
(() => {
  const here = new URL(document.currentScript.src);
  const mostAwake = 4; // frames at a time: browsers give a page few contexts to draw with
  const awake = []; // that were seen last, the last one last
  const look = ":host{display:block;width:100%;aspect-ratio:4/3;min-height:160px;background:#1a1c20}"
    + ":host([hidden]){display:none}iframe{display:block;border:0;width:100%;height:100%}";

  class KdStreamViewer extends HTMLElement {
    static observedAttributes = ["src", "model", "view"];
    #frame = null;
    #link = ""; // of what was seen last
    #waiting = new Map(); // deeds that have no answer yet
    #commands = 0;
    #ready = false;
    #isSeen = false;
    #watch = new IntersectionObserver(([{ isIntersecting }]) => this.#see(isIntersecting), { rootMargin: "200px" });

    constructor() {
      super();
      const root = this.attachShadow({ mode: "open" });
      const sheet = new CSSStyleSheet(); // where no policy forbids it
      sheet.replaceSync(look);
      root.adoptedStyleSheets = [sheet];
    }

    connectedCallback() {
      addEventListener("message", this);
      addEventListener("pointerdown", this, true);
      this.#watch.observe(this);
    }

    disconnectedCallback() {
      removeEventListener("message", this);
      removeEventListener("pointerdown", this, true);
      this.#watch.disconnect();
      this.#isSeen = false;
      this.#sleep();
    }

    attributeChangedCallback(name, before, now) {
      if (before === now) {
        return;
      }
      this.#link = "";
      if (name !== "src" && this.#ready && this.model) {
        this.#do("follow", this.#wanted()).catch(() => {});
      } else { // another server, or nothing is shown yet
        this.#sleep();
        this.#see(this.#isSeen);
      }
    }

    get src() {
      return this.getAttribute("src") ?? here.origin;
    }
    set src(value) {
      this.setAttribute("src", value);
    }
    get model() {
      return this.getAttribute("model") ?? "";
    }
    set model(value) {
      this.setAttribute("model", value);
    }
    get view() {
      return this.getAttribute("view") ?? "";
    }
    set view(value) {
      this.setAttribute("view", value);
    }
    get asleep() {
      return this.#frame === null;
    }

    // ---- what a page may ask for; each is a promise

    home() {
      return this.#do("home");
    }
    lookFrom(side) {
      return this.#do("side", String(side));
    }
    spin(spins = true) {
      return this.#do("spin", Boolean(spins));
    }
    follow(link) {
      return this.#do("follow", String(link).replace(/^.*#/, ""));
    }
    link() {
      return this.#do("link");
    }
    status() {
      return this.#do("status");
    }
    picture() {
      return this.#do("picture");
    }

    // ---- to and from the frame

    #address() {
      return new URL(this.src, document.baseURI);
    }

    // "model=ID&view=…", or all of a link as `view`.
    #wanted() {
      const { view } = this;
      return this.#link || (view.includes("model=") ? view.replace(/^.*#/, "")
        : `model=${encodeURIComponent(this.model)}${view ? `&view=${encodeURIComponent(view)}` : ""}`);
    }

    #see(isSeen) {
      this.#isSeen = isSeen;
      if (!isSeen || !(this.model || this.view)) {
        return;
      }
      if (awake.includes(this)) {
        awake.push(...awake.splice(awake.indexOf(this), 1));
        return;
      }
      while (awake.length >= mostAwake) {
        const longest = awake.find((each) => !each.#isSeen);
        if (!longest) {
          break; // as many are looked at
        }
        longest.#sleep();
      }
      awake.push(this);
      const address = this.#address();
      address.searchParams.set("embed", "");
      address.hash = this.#wanted();
      this.#frame = Object.assign(document.createElement("iframe"),
        { src: address.href, title: this.title || "3D model", allow: "fullscreen; web-share; clipboard-write" });
      this.shadowRoot.append(this.#frame);
    }

    // The frame goes; the view stays known.
    #sleep() {
      if (this.#frame) {
        awake.splice(awake.indexOf(this), 1);
        this.#frame.remove();
        this.#frame = null;
        this.#ready = false;
        this.#waiting.forEach(({ reject }) => reject(new Error("The viewer is unloaded.")));
        this.#waiting.clear();
        this.#tell("sleep");
      }
    }

    #do(deed, value) {
      return new Promise((resolve, reject) => {
        if (!this.#ready) {
          reject(new Error("The viewer is not ready."));
          return;
        }
        const id = ++this.#commands;
        this.#waiting.set(id, { resolve, reject });
        this.#frame.contentWindow.postMessage({ kdstream: 1, id, deed, value }, this.#address().origin);
      });
    }

    handleEvent({ type, source, origin, data }) {
      if (type === "pointerdown") { // beside the frame
        this.#frame?.contentWindow.postMessage({ kdstream: 1, deed: "leave" }, this.#address().origin);
        return;
      }
      if (!this.#frame || source !== this.#frame.contentWindow || origin !== this.#address().origin || data?.kdstream !== 1) {
        return;
      }
      const { id, result, error, event, detail } = data;
      if (id) {
        const answer = this.#waiting.get(id);
        this.#waiting.delete(id);
        error ? answer?.reject(new Error(error)) : answer?.resolve(result);
        return;
      }
      this.#ready = true;
      if (event === "viewchange") {
        this.#link = String(detail);
      }
      this.#tell(event, detail);
    }

    #tell(event, detail) {
      this.dispatchEvent(new CustomEvent(event, { detail, bubbles: true, composed: true }));
    }
  }

  if (!customElements.get("kdstream-viewer")) {
    customElements.define("kdstream-viewer", KdStreamViewer);
  }
})();
