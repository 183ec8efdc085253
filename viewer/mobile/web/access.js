// SPDX-License-Identifier: BSD-3-Clause
// Tokens: a dialog to enter one, and the options that remember or forget it. Fetched when needed.

import { makeButton } from "./elements.js";
import { keepToken, rememberedKey, token, tokenInLink, unlessDenied } from "./line.js";
import { make } from "./list.js";
import { t } from "./words.js";

const tokenAlone = /^[\w.-]{1,4096}$/;

const remembersToken = () => unlessDenied(() => localStorage.getItem(rememberedKey)) === token && token !== "";

// Returns whether the browser did what was requested.
function rememberToken(remembers) {
  unlessDenied(() => (remembers ? localStorage.setItem(rememberedKey, token) : localStorage.removeItem(rememberedKey)));
  return remembersToken() === remembers;
}

function forgetToken() {
  keepToken("");
  unlessDenied(() => sessionStorage.removeItem("token"));
  unlessDenied(() => localStorage.removeItem(rememberedKey));
}

// Takes an entered token, or a link that contains one. Returns false if it is neither.
function enterToken(given) {
  const text = given.trim();
  const found = text.match(tokenInLink)?.[2] ?? text.match(tokenAlone)?.[0];
  if (found) {
    keepToken(found);
  }
  return Boolean(found);
}

const remembers = (checked) => {
  const box = make("input", { type: "checkbox", checked });
  return [box, make("label", { className: "check" }, box, t("Remember it in this browser"))];
};

// Resolves to true once a token has been entered, or to false if the user cancels.
export function askForToken() {
  const field = make("input", { type: "text", id: "token", autocomplete: "off", spellcheck: false, required: true });
  const [box, label] = remembers(false);
  const wrong = make("p", { id: "token-wrong", role: "alert" });
  field.setAttribute("aria-describedby", "token-wrong");
  const cancel = makeButton("Cancel", () => dialog.close(), { className: "plain" });
  const form = make("form", { method: "dialog" },
    make("label", { htmlFor: "token", textContent: t("Your token, or the link that contains it") }), field, label, wrong,
    make("div", { className: "row" }, cancel, make("button", { className: "plain", textContent: t("Enter") })));
  const dialog = make("dialog", { id: "access-dialog", ariaLabel: t("A token") }, form);
  document.body.append(dialog);
  return new Promise((resolve) => {
    let entered = false;
    form.addEventListener("submit", (event) => {
      entered = enterToken(field.value);
      if (!entered) {
        event.preventDefault();
        wrong.textContent = t("This is not a token. Enter the token, or a link that contains #token=.");
        return;
      }
      rememberToken(box.checked);
    });
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(entered);
    });
    dialog.showModal();
  });
}

// Puts the options into the fieldset `place`. forgotten: called once the token is gone.
export function openAccessOptions(place, forgotten) {
  const [box, label] = remembers(remembersToken());
  box.addEventListener("change", () => {
    if (!rememberToken(box.checked)) {
      box.checked = false; // the browser does not store anything for this page
    }
  });
  const forget = makeButton("Forget it now", () => {
    forgetToken();
    forgotten();
  }, { className: "plain" });
  place.replaceChildren(make("legend", { textContent: t("Your token") }), label, forget);
  place.hidden = false;
}
