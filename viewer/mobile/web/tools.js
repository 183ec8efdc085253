// SPDX-License-Identifier: BSD-3-Clause
// Tools for viewing: views from six sides, automatic turning, measuring, sections, light, links to views, pictures. Fetched when
// they are first used. WebAssembly decides what they do; this code has their buttons, and the lines over the picture.

import { download, group, makeButton, notice } from "./elements.js";
import { formatError, formatLength } from "./lengths.js";
import { make, pageOf } from "./list.js";
import { SectionAndLight, tool } from "./sectionAndLight.js";
import { composePicture } from "./picture.js";
import { mayHaveRoom, roomOf } from "./room.js";
import { t } from "./words.js";

const find = (id) => document.getElementById(id);

const slop = 8; // points: a shorter movement is a tap

export function describeMeasurement({ distance, height, horizontal, error, exact, waits, to }, unit) {
  if (!to) {
    return t("from here to …");
  }
  const length = (value) => formatLength(value, error, unit, distance);
  const about = formatError(error, unit, distance);
  const doubt = about && ` ± ${about}`;
  const remark = waits ? ` ${t("(the original is loading)")}` : exact ? "" : ` ${t("(of a coarser level)")}`;
  return t("{distance}, height {height}, across {across}",
    { distance: `${length(distance)}${doubt}${remark}`, height: length(Math.abs(height)), across: length(horizontal) });
}

// ---- copying and saving

async function copyText(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch { // the clipboard is not available without https
    const area = make("textarea", { value: text });
    document.body.append(area);
    area.select();
    const copied = document.execCommand("copy");
    area.remove();
    if (!copied) {
      prompt(t("Copy this:"), text);
    }
  }
}

// ---- the panel

// page: { canvas, viewer, exchange, wake, redraw, status(), model(), words(), key(), colours(), getNotes() }
export class Tools {
  #page;
  #panel = find("tools");
  #overlay = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  #list = make("ol", { id: "measurements" });
  #drawn = "";
  #room = make("a", { id: "room", className: "tool", hidden: true, textContent: t("In my room") });
  #roomFor = null; // the model that the link is for

  constructor(page) {
    this.#page = page;
    this.#overlay.id = "overlay";
    this.#overlay.setAttribute("aria-hidden", "true");
    page.canvas.after(this.#overlay);
    const side = (name) => makeButton(name, () => this.#do((viewer) => viewer.lookFromSide(name.toLowerCase())), { className: "tool" });
    const toggle = (id, text, act) => makeButton(text, act, { id, className: "tool" });
    this.spin = toggle("spin", "Turn automatically", () => this.#do((viewer) => viewer.setSpinning(!page.status().spinning)));
    this.measure = toggle("measure", "Measure", () => this.#do((viewer) => viewer.setTool(page.status().measuring ? tool.none : tool.measure)));
    this.sectionAndLight = new SectionAndLight(page, (act) => this.#do(act));
    const share = navigator.share ? [makeButton("Share…", () => this.#share(), { className: "tool" })] : [];
    const carry = make("div", { id: "carry" }, makeButton("Copy link", () => this.#copyLink(), { className: "tool", id: "copy-link" }), ...share,
      makeButton("Save picture", () => this.#savePicture(), { className: "tool", id: "save-picture" }), this.#room);
    this.groups = [
      group("Look from", make("div", { className: "grid" }, ...["Front", "Back", "Left", "Right", "Top", "Bottom"].map(side)), this.spin),
      group("Distances", this.measure, this.#list,
        makeButton("Copy as text", () => this.#copyMeasurements(), { className: "tool", id: "copy-measurements" })),
      ...this.sectionAndLight.groups,
      this.#notesGroup()];
    this.#panel.append(carry, make("div", { id: "tabs" }, ...this.groups.map((each) => this.#tab(each))), ...this.groups);
    page.canvas.addEventListener("pointerdown", (event) => this.#press(event), true);
    page.canvas.addEventListener("pointerup", (event) => this.#lift(event)); // after the viewer got the event
  }

  // Tells the user if a tap measured nothing, unless it is a tap of several fingers, or moves the picture (fingers.js).
  #press({ isPrimary, button, shiftKey, clientX, clientY }) {
    this.pressed = isPrimary && button === 0 && !shiftKey && this.#page.status().measuring && { clientX, clientY, ends: this.#ends() };
  }

  #lift({ clientX, clientY }) {
    const { pressed } = this;
    if (pressed && Math.hypot(clientX - pressed.clientX, clientY - pressed.clientY) < slop && pressed.ends === this.#ends()) {
      this.#note("There is nothing to measure: tap the surface.");
    }
  }

  #ends() {
    return this.#page.viewer.measurements().map(({ to }) => (to ? 2 : 1)).join();
  }

  // Makes a tab for a small screen, which opens or closes one group of tools.
  #tab(each) {
    each.classList.add("closed");
    const tab = make("button", { type: "button", className: "tool", textContent: each.querySelector("legend").textContent, ariaExpanded: false });
    tab.addEventListener("click", () => {
      const opens = each.classList.contains("closed");
      this.groups.forEach((other, i) => {
        const open = opens && other === each;
        other.classList.toggle("closed", !open);
        tab.parentElement.children[i].ariaExpanded = open;
      });
    });
    return tab;
  }

  // The code that writes notes is loaded together with the notes.
  #notesGroup() {
    const write = async () => (await this.#page.getNotes()).write(place);
    const place = make("div", {}, makeButton("Write notes", write, { className: "tool", id: "write-notes" }));
    return group("Notes", place);
  }

  #do(act) {
    act(this.#page.viewer);
    this.#page.exchange();
    this.#page.wake();
  }

  #note(text) {
    notice(t(text));
  }

  link() {
    const page = pageOf(this.#page.status().model) || location.origin + location.pathname;
    const colours = this.#page.colours();
    return `${page}#${this.#page.viewer.link()}${colours ? `&colours=${colours}` : ""}`;
  }

  async #copyLink() {
    await copyText(this.link());
    this.#note("Link copied.");
  }

  async #share() {
    try {
      await navigator.share({ title: document.title, url: this.link() });
    } catch {
      // then the user is not informed
    }
  }

  async #copyMeasurements() {
    const { unit } = this.#page.status();
    const lines = this.#page.viewer.measurements().map((each) => `${each.name}: ${describeMeasurement(each, unit)}`);
    await copyText(lines.join("\n"));
    this.#note("Distances copied.");
  }

  async #savePicture() {
    const key = await this.#page.key();
    this.#page.redraw(); // a canvas keeps its picture only until the current task ends
    const blob = await composePicture({ canvas: this.#page.canvas, overlay: (brush) => this.#drawOverlay(brush), key, words: this.#page.words() });
    download(blob, `${this.#page.status().model}.png`);
    this.#note("Picture saved.");
  }

  async #offerRoom(model) {
    this.#roomFor = model;
    this.#room.hidden = true;
    const address = await roomOf(model, document.title);
    if (this.#roomFor === model && address) {
      this.#room.href = address;
      this.#room.hidden = false;
    }
  }

  // ---- lines over the picture

  // Call this after each frame.
  show() {
    const { spinning, measuring, unit } = this.#page.status();
    this.sectionAndLight.show(this.#page.status());
    mayHaveRoom && !this.#panel.hidden && this.#roomFor !== this.#page.model() && this.#offerRoom(this.#page.model());
    this.spin.setAttribute("aria-pressed", Boolean(spinning));
    this.measure.setAttribute("aria-pressed", Boolean(measuring));
    const measurements = this.#page.viewer.measurements();
    const text = JSON.stringify([measurements, unit]);
    if (text === this.#drawn) {
      return;
    }
    this.#drawn = text;
    this.#showLines(measurements, unit);
    this.#showList(measurements, unit);
  }

  #showLines(measurements, unit) {
    const ratio = this.#page.canvas.width / this.#page.canvas.clientWidth;
    const shape = (name, properties) => {
      const element = document.createElementNS("http://www.w3.org/2000/svg", name);
      Object.entries(properties).forEach(([key, value]) => element.setAttribute(key, value));
      return element;
    };
    this.#overlay.replaceChildren(...measurements.flatMap((each) => {
      const [from, to] = [each.from, each.to].map((place) => place?.map((pixels) => pixels / ratio));
      const dots = [from, to].filter(Boolean).map(([x, y]) => shape("circle", { cx: x, cy: y, r: 4 }));
      if (!from || !to) {
        return dots;
      }
      const label = shape("text", { x: (from[0] + to[0]) / 2, y: (from[1] + to[1]) / 2 - 8 });
      label.textContent = formatLength(each.distance, each.error, unit);
      return [shape("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1] }), ...dots, label];
    }));
  }

  #showList(measurements, unit) {
    find("copy-measurements").hidden = measurements.length === 0;
    while (this.#list.children.length > measurements.length) {
      this.#list.lastElementChild.remove();
    }
    while (this.#list.children.length < measurements.length) {
      this.#list.append(this.#listEntry(this.#list.children.length));
    }
    measurements.forEach((each, i) => {
      const [name, figures] = this.#list.children[i].children;
      if (document.activeElement !== name) {
        name.value = each.name;
      }
      figures.textContent = describeMeasurement(each, unit);
    });
  }

  #listEntry(index) {
    const name = make("input", { type: "text", maxLength: 60, ariaLabel: t("Name of the distance") });
    name.addEventListener("change", () => this.#do((viewer) => viewer.nameMeasurement(index, name.value)));
    const remove = makeButton("×", () => this.#do((viewer) => viewer.removeMeasurement(index)), { className: "remove", ariaLabel: t("Remove") });
    return make("li", {}, name, make("span"), remove);
  }

  // Draws the same lines into a picture.
  #drawOverlay(brush) {
    const { unit } = this.#page.status();
    const ratio = this.#page.canvas.width / this.#page.canvas.clientWidth;
    brush.strokeStyle = brush.fillStyle = "#ffd166";
    brush.lineWidth = 2 * ratio;
    brush.font = `600 ${Math.round(14 * ratio)}px system-ui, sans-serif`;
    brush.textAlign = "center";
    for (const { from, to, distance, error } of this.#page.viewer.measurements()) {
      if (from && to) {
        brush.beginPath();
        brush.moveTo(...from);
        brush.lineTo(...to);
        brush.stroke();
        brush.fillText(formatLength(distance, error, unit), (from[0] + to[0]) / 2, (from[1] + to[1]) / 2 - 8 * ratio);
      }
    }
    brush.textAlign = "start";
  }
}
