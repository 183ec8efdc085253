// SPDX-License-Identifier: BSD-3-Clause
// Augmented reality: shows the model's preview in the room around the device. Android's Scene Viewer fetches the preview itself,
// so it must be a file that needs no token. Apple's Quick Look would need USDZ, for which Debian has no library.

import { addressOf, hasToken } from "./line.js";

export const mayHaveRoom = /\bAndroid\b/.test(navigator.userAgent);

// Links that open Scene Viewer, as promises by file; "" if the server has no preview for it. The server is asked once per model.
const rooms = new Map();

export function roomOf({ id, digest }, title) {
  const file = addressOf(`api/models/${id}/${digest}/preview.glb`).href;
  if (!rooms.has(file)) {
    rooms.set(file, hasToken() ? Promise.resolve("") : fetch(file, { method: "HEAD" }).then(({ ok }) => (ok ? intentOf(file, title) : ""), () => ""));
  }
  return rooms.get(file);
}

function intentOf(file, title) {
  const query = new URLSearchParams({ file, mode: "ar_preferred", title });
  const back = encodeURIComponent(location.href.replace(/#.*/, ""));
  return `intent://arvr.google.com/scene-viewer/1.2?${query}#Intent;scheme=https;package=com.google.android.googlequicksearchbox;`
    + `action=android.intent.action.VIEW;S.browser_fallback_url=${back};end;`;
}
