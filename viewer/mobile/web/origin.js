// SPDX-License-Identifier: BSD-3-Clause
// Who made a model and how it may be used, in one line below the model's title. Texts are untrusted: they never become HTML, and
// only http links are made.

import { make } from "./list.js";

const commons = /^\/(?:licenses\/([a-z-]+)|publicdomain\/(zero|mark))\/(\d+\.\d+)/;

// The text as a web address, or null if it is not one.
export function addressIn(text) {
  try {
    const address = new URL(text);
    return /^https?:$/.test(address.protocol) ? address : null;
  } catch {
    return null;
  }
}

// The licence's usual name, such as "CC BY 4.0"; for an unknown address, its host. It is short enough to be shown whole.
function nameOfLicence({ hostname, pathname }) {
  const host = hostname.replace(/^www\./, "");
  const [, kind, domain, version] = (host === "creativecommons.org" && commons.exec(pathname)) || [];
  if (!version) {
    return host;
  }
  return kind ? `CC ${kind.toUpperCase()} ${version}` : domain === "zero" ? `CC0 ${version}` : `Public Domain Mark ${version}`;
}

// If there is no room for both, as over a preview, the credit is cut off, not the licence. The model's sheet has both in full
// (about.js).
export function showOrigin(element, credit, licence) {
  if (element.dataset.shown === `${credit}\n${licence}`) {
    return;
  }
  element.dataset.shown = `${credit}\n${licence}`;
  const address = addressIn(licence);
  element.replaceChildren(
    ...(credit ? [make("span", { dir: "auto", textContent: credit })] : []),
    ...(credit && licence ? [make("span", { textContent: "·" })] : []),
    ...(address
      ? [make("a", { href: address.href, title: licence, target: "_blank", rel: "noopener noreferrer nofollow license",
        textContent: nameOfLicence(address) })]
      : licence ? [make("span", { dir: "auto", textContent: licence })] : []));
}
