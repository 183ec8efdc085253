// SPDX-License-Identifier: BSD-3-Clause
// Previews are beside the list or, if the user prefers, in a window over it that opens on request. In that case nothing is
// fetched and drawn before the request (paper, section 5.1). Style sheets do the rest, by two attributes of the body.

const key = "kdstream.previews";

export const previewsAreAsked = () => "asked" in document.body.dataset;
export const showsPreview = () => "preview" in document.body.dataset;
export const showPreview = (shown) => document.body.toggleAttribute("data-preview", shown);

export function askForPreviews(asked) {
  document.body.toggleAttribute("data-asked", asked);
  try {
    localStorage.setItem(key, asked ? "asked" : "beside");
  } catch {
    // then it only lasts for this visit
  }
}

// The user's last choice: "asked" or "beside". In another page's frame, which has no list, it is always "beside".
export function rememberedPreviews(isEmbedded) {
  let asked = false;
  try {
    asked = localStorage.getItem(key) === "asked" && !isEmbedded;
  } catch {
    // then they are beside the list
  }
  document.body.toggleAttribute("data-asked", asked);
  return asked ? "asked" : "beside";
}
