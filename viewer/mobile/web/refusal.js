// SPDX-License-Identifier: BSD-3-Clause
// Explains to users why a server refused a request, from the status of its answer and the seconds after which it wants to be
// asked again (0: not given).

import { language, t, translated } from "./words.js";

function describeWhen(seconds) {
  if (seconds < 90) {
    return t("in {n} seconds", { n: Math.max(Math.ceil(seconds), 1) });
  }
  const far = seconds > 20 * 3600 ? { weekday: "long" } : {};
  const time = new Date(Date.now() + 1000 * seconds)
    .toLocaleTimeString(language, { hour: "numeric", minute: "2-digit", ...far });
  return t("at {time}", { time });
}

export function refusalOf(status, retryAfter = 0, hasToken = false) {
  const when = retryAfter > 0 ? describeWhen(retryAfter) : "";
  switch (status) {
    case 401:
      return hasToken
        ? t("the server requires a token: your link has expired, or is for another server")
        : t("the server requires a token: open the link that you were given");
    case 403:
      return when
        ? t("your quota for this model is used up; try again {when}", { when })
        : t("your link does not allow this");
    case 404:
      return t("the server does not have it");
    case 429:
      return when
        ? t("too many requests; the server answers again {when}", { when })
        : t("too many requests");
    case 502:
    case 503:
    case 504:
      return when ? t("the server is busy; it answers again {when}", { when }) : t("the server is busy");
    default:
      return t("the server says {status}", { status: String(status) });
  }
}

const quotaRefusal = (time) => refusalOf(403, Math.max((Date.parse(time) - Date.now()) / 1000, 1));

// Messages of the session and of servers, which are meant for developers.
const known = [
  [/^the connection to the server was lost: (.*)$/s, (why) => t("the connection to the server was lost: {why}", { why: inPlainWords(why) })],
  [/^(\S+) cannot be opened: (.*)$/s, (name, why) => t("{name} cannot be opened: {why}", { name, why: inPlainWords(why) })],
  [/^the server (?:says \d{3}|refused): (.*)$/s, (why) => inPlainWords(why)], // most users do not know HTTP status codes
  [/^the server says (\d{3})$/, (status) => refusalOf(Number(status))],
  [/^the quota of .* is used up: try again at (\S+)$/, quotaRefusal],
  [/^too many requests: try again in (\d+) s$/, (seconds) => refusalOf(429, Number(seconds))],
  [/^this server requires a token$/, () => refusalOf(401)],
  [/^the token only allows the preview of .*$/, () => t("your link only allows the preview")],
  [/^the token only allows the levels of .*, not its original$/, () => t("your link does not allow the original")],
  [/^the token is not for the model /, () => t("your link is not for this model")],
];

// Whether a message is about a deliberate refusal by the server, and not about a failure of the server or the connection.
export const isRefusal = (text) => known.slice(4).some(([pattern]) => pattern.test(text.replace(known[2][0], "$1")));

// Rewrites a message for users, in their language if its file has it.
export function inPlainWords(text) {
  for (const [pattern, say] of known) {
    const found = pattern.exec(text);
    if (found) {
      return say(...found.slice(1));
    }
  }
  return translated(text);
}
