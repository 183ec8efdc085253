// SPDX-License-Identifier: BSD-3-Clause
// Two tools that change how a model looks: a section through it, and the light on it.

import { download, group, makeButton } from "./elements.js";
import { make } from "./list.js";
import { t } from "./words.js";

export const tool = { none: 0, measure: 1, section: 2, light: 3, secondLight: 4 };

// A slider for 0-100 % of `most`, which calls `act` at each move.
function makeSlider(id, text, most, act) {
  const range = make("input", { id, type: "range", min: 0, max: 100, step: 1 });
  range.addEventListener("input", () => act(range.value / 100 * most));
  const label = make("label", { className: "slide" }, make("span", { textContent: t(text) }), range);
  return { label, show: (value) => {
    label.hidden = value === undefined || value === null;
    if (document.activeElement !== range || label.hidden) {
      range.value = Math.round(100 * value / most);
    }
  }, value: () => range.value / 100 * most };
}

// page: as in Tools. act(command): calls command(viewer), and shows the result.
export class SectionAndLight {
  #page;
  #act;

  constructor(page, act) {
    this.#page = page;
    this.#act = act;
    const toggle = (id, text, which) => makeButton(text, () => this.#toggle(which), { id, className: "tool" });
    const along = (text, word) => makeButton(text, () => act((viewer) => viewer.setSectionAlong(word)),
      { className: "tool", id: `section-${word}` });
    this.moves = toggle("move-section", "Move it by finger", tool.section);
    this.depth = makeSlider("section-depth", "Cut away", 1, (depth) => act((viewer) => viewer.setSectionDepth(depth)));
    this.outline = makeButton("Save outline", () => this.#saveOutline(), { className: "tool", id: "save-outline" });
    const dim = () => act((viewer) => viewer.dim(this.light.value(), this.secondLight.value(), this.relief.value()));
    this.shines = toggle("light", "Light from the finger", tool.light);
    this.shinesToo = toggle("second-light", "A second light", tool.secondLight);
    this.light = makeSlider("lamp", "Bright", 2, dim);
    this.secondLight = makeSlider("second-lamp", "The second", 2, dim);
    this.relief = makeSlider("relief", "Relief", 1, dim);
    this.standard = makeButton("Standard light", () => act((viewer) => viewer.setStandardLight()),
      { className: "tool", id: "standard-light" });
    this.groups = [
      group("Section", make("div", { className: "grid" }, along("From the front", "front"), along("From the side", "side"),
        along("From above", "above"), along("Facing me", "view"), along("Other side", "flip"), along("None", "off")),
      this.depth.label, this.moves, this.outline),
      group("Light", this.shines, this.shinesToo, this.light.label, this.secondLight.label, this.relief.label, this.standard)];
  }

  #toggle(which) {
    const { depth, tool: active } = this.#page.status();
    this.#act((viewer) => {
      if (which === tool.section && depth === null) {
        viewer.setSectionAlong("view");
      }
      viewer.setTool(active === which ? tool.none : which);
    });
  }

  #saveOutline() {
    const outline = this.#page.viewer.sectionOutline();
    download(new Blob([outline], { type: "image/svg+xml" }), `${this.#page.status().model}-section.svg`);
  }

  show({ tool: active, depth, lamp: light, secondLamp: secondLight, relief }) {
    const press = (button, which) => button.setAttribute("aria-pressed", active === which);
    press(this.moves, tool.section);
    press(this.shines, tool.light);
    press(this.shinesToo, tool.secondLight);
    this.depth.show(depth);
    this.outline.hidden = depth === null;
    this.light.show(light);
    this.secondLight.show(secondLight);
    this.relief.show(relief);
    this.standard.hidden = light === undefined;
  }
}
