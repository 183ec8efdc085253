// SPDX-License-Identifier: BSD-3-Clause
// <kdstream-viewer src="https://SERVER" model="ID" view="…">: the viewer on anybody's page (doc/embedding.md).
//
// The viewer itself is the server's page in a frame, which shows one model and no list. The page and this element exchange
// messages; embedding.js answers them in the frame. This file works as a plain script and as a module, so it has no import.meta,
// which plain scripts do not allow.
(() => {
  const folderOf = (address) => address && new URL(".", address).href;
  const addresses = (selector) => Array.from(document.querySelectorAll(selector), ({ src }) => src);
  // For a module: the folder of its script tag, or of a script that another module imported. If there are several such folders,
  // it is not clear which one is this script's, and the page must set src.
  const folderOfModule = () => {
    const others = addresses("script:not([type=module])");
    const imported = performance.getEntriesByType("resource").map(({ name }) => name);
    const [folder, another] = new Set([...addresses("script[type=module]"), ...imported]
      .filter((address) => /\/embed\.js([?#]|$)/.test(address) && !others.includes(address)).map(folderOf));
    return another ? "" : folder;
  };
  const here = document.currentScript ? folderOf(document.currentScript.src) : folderOfModule();
  const mostAwake = 4; // frames at the same time: browsers give a page only a few contexts to draw with
  const awake = []; // viewers in the order in which they were last visible
  const look = ":host{display:block;position:relative;width:100%;aspect-ratio:4/3;min-height:160px;background:#1a1c20}"
    + ":host([theme=light]){background:#e9e7e2}:host([hidden]){display:none}iframe{display:block;border:0;width:100%;height:100%}"
    + "button{position:absolute;inset:0;width:100%;height:100%;padding:0;border:0;background:none;cursor:pointer}"
    + "button[aria-disabled=true]{pointer-events:none}button img{display:block;width:100%;height:100%;object-fit:cover}"
    + "[part=logo]{position:absolute;right:8px;bottom:92px;max-width:25%;max-height:15%;pointer-events:none}";
  const make = (name, part, properties) => {
    const element = Object.assign(document.createElement(name), properties);
    element.part = part;
    return element;
  };

  class KdStreamViewer extends HTMLElement {
    static observedAttributes = ["src", "model", "view", "turn", "theme", "scroll", "poster", "autoplay", "logo"];
    #frame = null;
    #link = ""; // to the last view
    #waiting = new Map(); // commands that have no answer yet
    #commands = 0;
    #ready = false;
    #isSeen = false;
    #isWanted = false; // the user has pressed the poster
    #poster = null;
    #logo = null;
    #watch = new IntersectionObserver(([{ isIntersecting }]) => this.#see(isIntersecting), { rootMargin: "200px" });

    constructor() {
      super();
      const root = this.attachShadow({ mode: "open" });
      const sheet = new CSSStyleSheet(); // because a content security policy may forbid style elements
      sheet.replaceSync(look);
      root.adoptedStyleSheets = [sheet];
    }

    connectedCallback() {
      this.src || console.error("kdstream-viewer: set src to the address of the server of the models");
      addEventListener("message", this);
      addEventListener("pointerdown", this, true);
      this.#showPictures(); // now also with the title, and whatever else a script has set since the poster was made
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
      if (name === "turn") {
        this.#ready && this.spin(this.hasAttribute("turn")).catch(() => {});
        return;
      }
      if (["poster", "autoplay", "logo"].includes(name)) {
        this.#showPictures();
        this.#see(this.#isSeen);
        return;
      }
      if (name === "theme" || name === "scroll") { // the view is kept
        this.#sleep();
        this.#see(this.#isSeen);
        return;
      }
      this.#link = "";
      if (name !== "src" && this.#ready && this.model) {
        this.#do("follow", this.#wanted()).catch(() => {});
      } else { // another server, or nothing has been shown yet
        this.#sleep();
        this.#see(this.#isSeen);
      }
    }

    get src() {
      return this.getAttribute("src") ?? here ?? "";
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

    // ---- commands for the page; each returns a promise

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

    // ---- messages to and from the frame

    #address() {
      return new URL(this.src, document.baseURI);
    }

    // The poster covers the frame until there is a picture. If the viewer does not start by itself, pressing the poster starts
    // it.
    #showPictures() {
      const hadFocus = this.#poster && this.shadowRoot.activeElement === this.#poster;
      this.#poster?.remove();
      this.#logo?.remove();
      this.#poster = this.#logo = null;
      const { poster, logo } = Object.fromEntries(["poster", "logo"].map((name) => [name, this.getAttribute(name)]));
      if (poster && !this.#ready) {
        const name = this.title || "3D model";
        const waits = this.#waits(); // if not, it is no button; aria-disabled, because a disabled element loses the focus
        this.#poster = make("button", "poster", { type: "button", ariaLabel: name, ariaDisabled: !waits, tabIndex: waits ? 0 : -1 });
        this.#poster.append(make("img", "poster-picture", { src: poster, alt: "" }));
        this.#poster.addEventListener("click", () => {
          this.#isWanted = true;
          this.#poster.ariaDisabled = true;
          this.#see(this.#isSeen);
        });
        this.shadowRoot.append(this.#poster);
      }
      if (logo) {
        this.#logo = make("img", "logo", { src: logo, alt: "" });
        this.shadowRoot.append(this.#logo);
      }
      hadFocus && (this.#poster ?? this.#frame)?.focus({ preventScroll: true });
    }

    #waits() {
      return this.getAttribute("autoplay") === "false" && this.hasAttribute("poster") && !this.#isWanted;
    }

    // Returns "model=ID&view=…", or the whole link if `view` is one.
    #wanted() {
      const { view } = this;
      return this.#link || (view.includes("model=") ? view.replace(/^.*#/, "")
        : `model=${encodeURIComponent(this.model)}${view ? `&view=${encodeURIComponent(view)}` : ""}`);
    }

    #see(isSeen) {
      this.#isSeen = isSeen;
      if (!isSeen || !this.src || this.#waits() || !(this.model || this.view)) {
        return;
      }
      if (awake.includes(this)) {
        awake.push(...awake.splice(awake.indexOf(this), 1));
        return;
      }
      while (awake.length >= mostAwake) {
        const longest = awake.find((each) => !each.#isSeen);
        if (!longest) {
          break; // all of them are visible, so the limit is exceeded
        }
        longest.#sleep();
      }
      awake.push(this);
      const address = this.#address();
      address.searchParams.set("embed", this.getAttribute("scroll") === "off" ? "entered" : "");
      this.getAttribute("theme") === "light" && address.searchParams.set("theme", "light");
      address.hash = this.#wanted();
      this.#frame = make("iframe", "frame",
        { src: address.href, title: this.title || "3D model", allow: "fullscreen; web-share; clipboard-write" });
      this.shadowRoot.prepend(this.#frame); // below poster and logo
    }

    // Removes the frame, but keeps the view.
    #sleep() {
      if (this.#frame) {
        awake.splice(awake.indexOf(this), 1);
        this.#frame.remove();
        this.#frame = null;
        this.#ready = false;
        this.#waiting.forEach(({ reject }) => reject(new Error("The viewer is unloaded.")));
        this.#waiting.clear();
        this.#showPictures();
        this.#tell("sleep");
      }
    }

    #do(command, value) {
      return new Promise((resolve, reject) => {
        if (!this.#ready) {
          reject(new Error("The viewer is not ready."));
          return;
        }
        const id = ++this.#commands;
        this.#waiting.set(id, { resolve, reject });
        this.#frame.contentWindow.postMessage({ kdstream: 1, id, deed: command, value }, this.#address().origin);
      });
    }

    handleEvent({ type, source, origin, data }) {
      if (type === "pointerdown") { // outside the frame
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
      if (!this.#ready) {
        this.#ready = true;
        this.#showPictures();
        this.hasAttribute("turn") && !matchMedia("(prefers-reduced-motion: reduce)").matches && this.spin().catch(() => {});
      }
      if (event === "viewchange") {
        this.#link = String(detail);
      }
      event === "failed" || this.#tell(event, detail); // the page in the frame shows more than this event would
    }

    #tell(event, detail) {
      this.dispatchEvent(new CustomEvent(event, { detail, bubbles: true, composed: true }));
    }
  }

  if (!customElements.get("kdstream-viewer")) {
    customElements.define("kdstream-viewer", KdStreamViewer);
  }
})();
