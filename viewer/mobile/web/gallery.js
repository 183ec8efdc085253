// SPDX-License-Identifier: BSD-3-Clause
// The list's pictures, and its search. Fetched after the first picture of the page, or if there are many models.
//
// A picture of a model's preview is made when the model's entry is first visible. It is made by a second viewer of the same
// WebAssembly on a small hidden canvas; only one at a time, and only while the page itself is idle. Pictures are stored under the
// model's digest. List and view share the previews that they fetch (`previews` in line.js). If the browser saves data, only
// stored pictures are shown.

import { Line, isOffline, mayKeep } from "./line.js";
import { entryOf, nameOf } from "./list.js";
import { findBlob, storeBlobs } from "./storage.js";
import { anotherViewer } from "./viewer.js";
import { t } from "./words.js";

const side = 192; // pixels
const pause = 300; // ms between two checks of whether the page is idle
const longest = 20000; // ms, for one picture
const mostMade = 24; // pictures per viewer, because a viewer never frees memory
const theme = document.documentElement.dataset.theme ?? "";
const pathOf = (digest) => `picture/${digest}${theme}`;

// ---- making pictures

class Maker {
  #canvas = document.createElement("canvas");
  #viewer = anotherViewer();
  #line;
  #arrived = () => {};
  made = 0;

  constructor() {
    this.#canvas.width = this.#canvas.height = side;
    this.#line = new Line(this.#viewer, () => this.#arrived(), false);
    this.#viewer.setKeeps(true);
    this.#viewer.setMotion(false);
    this.works = this.#viewer.gainCanvas(this.#canvas);
    this.#viewer.resize(side, side, 1);
    theme && this.#viewer.setBackground(0xd9d6cf, 0xf4f2ee); // light.css
  }

  // Returns the picture as a data: URL, or "" if there is none.
  async make(model) {
    ++this.made;
    this.#viewer.setModels(new TextEncoder().encode(JSON.stringify({ models: [model] })));
    this.#viewer.select(model.id);
    this.#line.exchange();
    for (const end = performance.now() + longest; performance.now() < end;) {
      this.#viewer.frame();
      this.#line.tick();
      const { idle, shownLevel, error, drawingError } = this.#viewer.status();
      if (error || drawingError || this.#viewer.failure) {
        return "";
      }
      if (idle && shownLevel !== null) {
        return this.#picture();
      }
      await new Promise((resolve) => {
        this.#arrived = resolve;
        setTimeout(resolve, 50);
      });
    }
    return "";
  }

  #picture() {
    this.#viewer.resize(side, side, 1); // a canvas keeps its picture only until the current task ends
    this.#viewer.frame();
    return this.#canvas.toDataURL("image/webp", .8);
  }

  drop() {
    this.#viewer.drop();
    this.#canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

// ---- the list

// The text without accents, in lower case.
const plain = (text) => text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();

export class Gallery {
  #page;
  #models = new Map(); // by id
  #seen = new IntersectionObserver((entries) => this.#see(entries), { root: document.getElementById("browser"), rootMargin: "80px" });
  #wanted = new Map(); // by id
  #pictures = new Map(); // by digest; "" if none could be made
  #maker = null;
  #works = false;
  #search = document.getElementById("search");

  // page: { status(), savesData(), rest() }; rest: a promise of the viewer's second part, which Maker needs
  constructor(page) {
    this.#page = page;
    this.#search.addEventListener("input", () => this.#filter());
  }

  // Call this after the entries were made.
  show(models) {
    this.#models = new Map(models.map((model) => [model.id, model]));
    this.#seen.disconnect();
    this.#wanted.clear();
    models.forEach(({ id }) => this.#seen.observe(entryOf(id)));
    this.#filter();
  }

  async #see(entries) {
    for (const { target, isIntersecting } of entries) {
      const model = this.#models.get(target.dataset.model);
      if (isIntersecting && model && !this.#put(model)) {
        this.#wanted.set(model.id, model);
      } else {
        this.#wanted.delete(target.dataset.model); // it was scrolled out of sight
      }
    }
    await Promise.all([...this.#wanted.values()].map((model) => this.#lookUp(model)));
    this.#work();
  }

  // Shows a stored picture immediately, so that it need not wait for pictures that must be made first.
  async #lookUp(model) {
    const picture = this.#pictures.has(model.digest) ? "" : await this.#find(model);
    if (picture) {
      this.#pictures.set(model.digest, picture);
      this.#put(model);
      this.#wanted.delete(model.id);
    }
  }

  // Shows the picture if there is one. Returns whether nothing more needs to be done for this model.
  #put({ id, digest }) {
    const picture = this.#pictures.get(digest);
    const image = entryOf(id)?.querySelector("img");
    if (picture && image) {
      image.src = picture;
      image.hidden = false;
    }
    return picture !== undefined;
  }

  async #work() {
    if (this.#works) {
      return;
    }
    this.#works = true;
    for (let model; ([model] = this.#wanted.values()), model;) {
      if (!this.#pictures.has(model.digest)) {
        const picture = await this.#find(model) ?? (this.#page.savesData() ? "" : await this.#make(model));
        if (picture === null) {
          await new Promise((resolve) => setTimeout(resolve, pause));
          continue;
        }
        this.#pictures.set(model.digest, picture);
      }
      this.#wanted.delete(model.id);
      this.#put(model);
    }
    this.#maker?.drop();
    this.#maker = null;
    this.#works = false;
  }

  async #find({ digest }) {
    const kept = mayKeep() ? await findBlob(pathOf(digest)) : null;
    const text = kept && new TextDecoder().decode(kept);
    return text?.startsWith("data:image/") ? text : undefined;
  }

  // Returns null while the page is busy with something more important.
  async #make(model) {
    await this.#page.rest();
    const { mode = "no model", idle, shownLevel, error } = this.#page.status();
    const rests = mode === "no model" || (mode === "browsing" && idle && (shownLevel !== null || error));
    if (document.hidden || !rests || isOffline()) {
      return null;
    }
    if (this.#maker?.made >= mostMade) {
      this.#maker.drop();
      this.#maker = null;
    }
    this.#maker ??= new Maker();
    const picture = this.#maker.works ? await this.#maker.make(model) : "";
    if (picture && mayKeep()) {
      storeBlobs([{ path: pathOf(model.digest), bytes: new TextEncoder().encode(picture).buffer }]);
    }
    return picture;
  }

  // Shows only the entries that contain all words.
  #filter() {
    const words = plain(this.#search.hidden ? "" : this.#search.value).split(/\s+/).filter(Boolean);
    let left = 0;
    for (const model of this.#models.values()) {
      const text = plain(`${nameOf(model)} ${model.description}`);
      const fits = words.every((word) => text.includes(word));
      entryOf(model.id).parentElement.hidden = !fits;
      left += fits;
    }
    if (this.#models.size) {
      const found = document.getElementById("empty");
      found.hidden = words.length === 0;
      found.textContent = left ? t("{n} models found", { n: left }) : t("No model matches.");
    }
  }
}
