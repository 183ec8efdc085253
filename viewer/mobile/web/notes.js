// SPDX-License-Identifier: BSD-3-Clause
// Notes on a model. Visitors step through them, each with its view. Authors write them, and save a file that belongs beside the
// store (format: filters/model/Notes.h). Fetched when a model with notes is shown in full screen, or when somebody wants to write
// notes. Texts are untrusted: they never become HTML.

import { download, makeButton } from "./elements.js";
import { getOrFind } from "./line.js";
import { make } from "./list.js";
import { language, t } from "./words.js";

const mostBytes = 256 << 10;
const mostNotes = 100;
const leastTime = 4000, timeOfLetter = 60, mostTime = 30000; // ms that a note is shown while the tour plays
const longest = { title: 200, text: 4000, link: 2048 };

// ---- the file

function readNote({ label, body, target } = {}) {
  const text = (value, most) => (typeof value === "string" ? value.slice(0, most) : "");
  const spoken = text(body?.language, 35);
  const titles = typeof label === "object" ? label?.[spoken] ?? Object.values(label ?? {})[0] : label;
  return {
    title: text(Array.isArray(titles) ? titles[0] : titles, longest.title),
    text: text(body?.value, longest.text),
    link: text(target?.selector?.value, longest.link).replace(/\p{Cc}/gu, ""), // setMarks takes one link per line
    language: spoken,
  };
}

function readNotes(bytes) {
  const { items } = JSON.parse(new TextDecoder().decode(bytes));
  return Array.isArray(items) ? items.slice(0, mostNotes).map((item) => readNote(item ?? undefined)).filter(({ title }) => title) : [];
}

const writeNotes = (notes) => `${JSON.stringify({
  "@context": "http://iiif.io/api/presentation/3/context.json",
  type: "AnnotationPage",
  items: notes.map(({ title, text, link, language: spoken }) => ({
    type: "Annotation",
    motivation: "commenting",
    label: { [spoken || "none"]: [title] },
    body: { type: "TextualBody", format: "text/plain", value: text, ...(spoken && { language: spoken }) },
    target: { type: "SpecificResource", source: "model.json", selector: { type: "FragmentSelector", value: link } },
  })),
}, null, 2)}\n`;

// Whatever model a note names, its view is applied to the model that is open.
const linkOf = (model, { link }) => [`model=${model}`, ...link.split("&").filter((part) => part && !part.startsWith("model="))].join("&");

// ---- the notes' box, and its content

// page: { canvas, viewer, follow(link), status(), hasNotes(), colours() }
export class Notes {
  #page;
  #model = null;
  #notes = [];
  #at = -1; // the note that is shown; -1: the list of notes
  #written = new Map(); // edited notes, by model
  #unsaved = new Set(); // models whose notes would be lost when the page is closed
  #drafts = new Map(); // the text in the fields, by model: { index, title, text }
  #author = null;

  constructor(page) {
    this.#page = page;
    const step = (id, name, arrow, by) => makeButton(arrow, () => {
      this.#play(false);
      this.#goTo(this.#at + by);
    }, { id, className: "tool", ariaLabel: t(name), title: t(name) });
    this.opener = makeButton("Notes", () => this.#open(), { id: "notes-open", className: "tool", hidden: true });
    this.list = make("ol", { id: "notes-list" });
    this.said = make("div", { id: "note", ariaLive: "polite", tabIndex: 0 });
    this.place = make("span", { id: "note-place" });
    this.previous = step("note-previous", "Previous note", "‹", -1); // arrows follow the direction of the text
    this.next = step("note-next", "Next note", "›", 1);
    this.all = makeButton("All notes", () => this.#showList(), { id: "notes-all", className: "tool" });
    this.box = make("section", { id: "notes", ariaLabel: t("Notes"), hidden: true }, this.list, this.said, make("div", { className: "row" },
      this.previous, this.place, this.next, this.all, makeButton("Close", () => this.#close(), { id: "notes-close", className: "tool" })));
    this.markers = make("div", { id: "note-marks" });
    this.play = makeButton("Play the tour", () => this.#play(!this.#isPlaying()), { id: "note-play", className: "tool" });
    this.all.after(this.play);
    for (const name of ["pointerdown", "wheel", "keydown"]) {
      page.canvas.addEventListener(name, () => this.#play(false), { passive: true });
    }
    page.canvas.after(this.markers, this.opener, this.box);
    document.addEventListener("keydown", (event) => {
      const another = document.querySelector(".sheet:not([hidden]), dialog[open]");
      if (event.key === "Escape" && !this.box.hidden && !another) {
        event.preventDefault(); // nothing else reacts to this Escape
        this.#close();
      }
    }, true);
    addEventListener("beforeunload", (event) => {
      this.#keepDraft();
      (this.#unsaved.size || this.#drafts.size) && event.preventDefault();
    });
    this.show();
  }

  // Call this after each frame.
  show() {
    const { mode, model } = this.#page.status();
    this.#showMarkers();
    if (mode !== "full screen") {
      this.#keepDraft();
      this.#play(false);
      this.box.hidden = this.opener.hidden = true;
      this.#model = null;
    } else if (model !== this.#model) {
      this.#load(model);
    }
  }

  async #load(model) {
    this.#keepDraft();
    this.#model = model;
    this.#showDraft();
    this.#use(this.#written.get(model) ?? []);
    if (this.#written.has(model) || !this.#page.hasNotes()) {
      return;
    }
    try {
      const { status, bytes } = await getOrFind(`/api/models/${model}/notes.json`, mostBytes);
      if (this.#model === model && status === 200) {
        this.#use(readNotes(bytes));
      }
    } catch {
      // then the model has no notes
    }
  }

  #use(notes) {
    this.#play(false);
    this.#notes = notes;
    this.#at = -1;
    this.box.hidden = true;
    this.#page.viewer.setMarks(notes.map((note) => linkOf(this.#model, note)));
    this.markers.replaceChildren(...notes.map(({ title }, i) => makeButton(String(i + 1), () => {
      this.#play(false);
      this.box.hidden = false;
      this.#goTo(i);
    }, { className: "note-mark", ariaLabel: `${i + 1}: ${title}`, hidden: true })));
    this.#showAll();
  }

  // Shows markers at visible notes; none while a tool is in use, because taps are then for the model.
  #showMarkers() {
    const { mode, tool } = this.#page.status();
    const focused = mode === "full screen" && this.markers.querySelector(":focus");
    this.markers.hidden = mode !== "full screen" || tool > 0 || !this.#notes.length;
    this.markers.hidden || this.#placeMarkers();
    focused && !focused.checkVisibility() && this.#focus();
  }

  #placeMarkers() {
    const ratio = this.#page.canvas.width / this.#page.canvas.clientWidth;
    this.#page.viewer.marks().forEach((mark, i) => {
      const marker = this.markers.children[i];
      if (!marker) {
        return;
      }
      marker.hidden = !mark?.[2];
      if (!marker.hidden) {
        marker.style.transform = `translate(${mark[0] / ratio}px, ${mark[1] / ratio}px) translate(-50%, -50%)`;
        marker.setAttribute("aria-current", i === this.#at);
      }
    });
  }

  // ---- the automatic tour

  #timer = 0;
  #isPlaying = () => this.#timer !== 0;

  #play(plays) {
    clearTimeout(this.#timer);
    this.#timer = 0;
    if (plays) {
      this.#goTo(this.#at + 1 < this.#notes.length ? this.#at + 1 : 0);
      this.#playOn();
    }
    this.play.textContent = t(plays ? "Pause" : "Play the tour");
  }

  // Shows the next note after the time that reading this one takes.
  #playOn() {
    const { title, text } = this.#notes[this.#at];
    const time = Math.min(leastTime + timeOfLetter * (title.length + text.length), mostTime);
    this.#timer = setTimeout(() => this.#play(this.#at + 1 < this.#notes.length), time);
  }

  // ---- stepping

  #open() {
    this.box.hidden = false;
    this.#showList();
  }

  #close() {
    this.#play(false);
    this.box.hidden = true;
    this.#showAll();
    (this.opener.hidden ? this.#page.canvas : this.opener).focus();
  }

  #showList() {
    this.#play(false);
    this.#at = -1;
    this.#showAll();
    this.list.querySelector("button")?.focus();
  }

  #goTo(index) {
    this.#at = Math.min(Math.max(index, 0), this.#notes.length - 1);
    const note = this.#notes[this.#at];
    this.#page.follow(linkOf(this.#model, note));
    this.#showAll();
    const wanted = document.activeElement; // a button that is disabled loses the focus
    if (!wanted || wanted.disabled || wanted === document.body || !wanted.checkVisibility()) {
      this.#focus();
    }
  }

  // Moves the focus to a button or the canvas, because the element that had it is gone.
  #focus() {
    const button = this.next.disabled ? this.all : this.next;
    (button.checkVisibility() ? button : this.#page.canvas).focus();
  }

  #showAll() {
    const note = this.#notes[this.#at];
    this.opener.hidden = !this.box.hidden || this.#notes.length === 0;
    this.list.hidden = Boolean(note);
    this.list.replaceChildren(...this.#notes.map(({ title, language: lang }, i) => make("li", {},
      make("button", { type: "button", className: "tool", textContent: title, dir: "auto", lang, onclick: () => this.#goTo(i) }))));
    for (const each of [this.previous, this.next, this.place, this.all]) {
      each.hidden = !note;
    }
    this.play.hidden = this.#notes.length < 2;
    this.previous.disabled = this.#at <= 0;
    this.next.disabled = this.#at + 1 >= this.#notes.length;
    this.place.textContent = note ? t("{n} of {all}", { n: this.#at + 1, all: this.#notes.length }) : "";
    this.said.replaceChildren(...(note ? [
      make("h3", { textContent: note.title, dir: "auto", lang: note.language }),
      make("p", { textContent: note.text, dir: "auto", lang: note.language })] : []));
    this.said.scrollTop = 0;
    this.said.hidden = !note;
    this.#showWritten();
    this.#showMarkers(); // because no frame may follow
  }

  // ---- writing

  // Opens the fields in the tools' sheet.
  write(place) {
    this.#play(false);
    if (!this.#author) {
      const input = (name, properties) => make(name, { maxLength: properties.most, ...properties });
      this.title = input("input", { id: "note-title", type: "text", most: longest.title });
      this.text = input("textarea", { id: "note-text", rows: 4, most: longest.text });
      const labelled = (text, element) => make("label", { className: "note-field" }, text, element);
      this.keep = makeButton("Keep this note", () => this.#keep(), { id: "note-keep", className: "tool" });
      this.editor = make("div", { hidden: true }, labelled(t("Title"), this.title), labelled(t("Text"), this.text), this.keep,
        makeButton("Cancel", () => this.#edit(null), { className: "tool" }));
      this.entries = make("ol", { id: "notes-written" });
      this.remark = make("p", { id: "notes-remark", role: "status" });
      this.save = makeButton("Save notes", () => this.#save(), { id: "notes-save", className: "tool" });
      this.#author = make("div", {}, makeButton("Add a note here", () => this.#edit(this.#notes.length), { id: "note-add", className: "tool" }),
        this.editor, this.entries, this.save, this.remark);
    }
    place.replaceWith(this.#author);
    this.#showWritten();
    this.#author.querySelector("button").focus();
  }

  // Shows a message in the sheet, and scrolls to it, because it may be out of sight.
  #say(text) {
    this.remark.textContent = text;
    text && this.remark.scrollIntoView({ block: "nearest" });
  }

  // Whether the fields have changes that would be lost.
  #isBegun() {
    const { title = "", text = "" } = this.#notes[this.edited] ?? {};
    return !this.editor.hidden && (this.title.value !== title || this.text.value !== text);
  }

  // Opens the fields for the note `index`; null closes them.
  #edit(index) {
    if (index !== null && this.#isBegun() && (this.edited === index || !this.#keep())) {
      this.title.focus(); // the fields stay as they were
      return;
    }
    this.#drafts.delete(this.#model);
    this.#fill(index, this.#notes[index]);
    if (index !== null) {
      this.title.focus();
      this.editor.scrollIntoView({ block: "nearest" }); // shows all of its fields
    }
  }

  #fill(index, { title = "", text = "" } = {}) {
    this.edited = index;
    this.editor.hidden = index === null;
    this.title.value = title;
    this.text.value = text;
  }

  // Keeps the draft for one model while other models are viewed.
  #keepDraft() {
    if (this.#author && this.#model && this.#isBegun()) {
      this.#drafts.set(this.#model, { index: this.edited, title: this.title.value, text: this.text.value });
    }
  }

  #showDraft() {
    const draft = this.#drafts.get(this.#model);
    this.#author && this.#fill(draft?.index ?? null, draft);
  }

  // Keeps the note in the fields; returns false if it is not valid.
  #keep() {
    const { title, text } = { title: this.title.value.trim(), text: this.text.value };
    if (!title) {
      this.#say(t("A note needs a title."));
      this.title.focus();
      return false;
    }
    const colours = this.#page.colours();
    const before = this.#notes[this.edited];
    const link = before?.link ?? `${this.#page.viewer.link()}${colours ? `&colours=${colours}` : ""}`;
    const isKept = this.#change((notes) =>
      notes.splice(this.edited, 1, { link, language: language.split("-")[0], ...before, title, text }));
    isKept && this.#edit(null);
    return isKept;
  }

  // Changes the notes; returns whether this was possible.
  #change(act) {
    const notes = [...this.#notes];
    act(notes);
    const most = notes.length > mostNotes ? t("A model can have at most {n} notes.", { n: mostNotes }) : "";
    this.#say(most);
    if (!most) {
      this.#written.set(this.#model, notes);
      this.#unsaved.add(this.#model);
      this.#use(notes);
    }
    return !most;
  }

  #move(from, to) {
    if (to >= 0 && to < this.#notes.length) {
      this.#change((notes) => notes.splice(to, 0, ...notes.splice(from, 1)));
      this.entries.children[to].querySelector("button").focus();
    }
  }

  #showWritten() {
    if (!this.#author) {
      return;
    }
    this.save.disabled = this.#notes.length === 0;
    this.entries.replaceChildren(...this.#notes.map(({ title, language: lang }, i) => make("li", {},
      make("span", { textContent: title, dir: "auto", lang }), make("div", {},
        makeButton("Up", () => this.#move(i, i - 1), { className: "tool" }),
        makeButton("Down", () => this.#move(i, i + 1), { className: "tool" }),
        makeButton("Edit", () => this.#edit(i), { className: "tool" }),
        makeButton("Remove", () => this.#change((notes) => notes.splice(i, 1)), { className: "tool" })))));
  }

  #save() {
    const file = new Blob([writeNotes(this.#notes)], { type: "application/json" });
    if (file.size > mostBytes) {
      this.#say(t("These notes are too long for the server: shorten them."));
      return;
    }
    download(file, `${this.#model}.notes.json`);
    this.#unsaved.delete(this.#model);
    this.#say(t("Copy {file} to the folder of {store} on the server: then everyone sees the notes.",
      { file: `${this.#model}.notes.json`, store: `${this.#model}.kds` }));
  }
}
