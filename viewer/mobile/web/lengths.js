// SPDX-License-Identifier: BSD-3-Clause
// Lengths for people: in the unit that is easiest to read, with as many digits as the error allows.

import { figure, language } from "./words.js";

const metres = { pm: 1e-12, nm: 1e-9, "µm": 1e-6, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3 };
const aliases = { "μm": "µm", um: "µm", micron: "µm", microns: "µm", millimetre: "mm", millimeter: "mm", centimetre: "cm",
  centimeter: "cm", metre: "m", meter: "m", metres: "m", meters: "m", kilometre: "km", kilometer: "km" };
const smallestFirst = Object.keys(metres);
const mostDigits = 5; // even of an exact length: nobody reads more

// Returns a unit in which `size` is from 1 to 1000, if there is one, and the factor for that unit. Unknown units stay as they
// are.
export function readableUnit(size, unit) {
  const known = aliases[unit.toLowerCase()] ?? unit;
  if (!Object.hasOwn(metres, known) || size === 0 || (size >= 1 && size < 1000)) {
    return { unit, factor: 1 };
  }
  const shown = smallestFirst.findLast((each) => size * metres[known] >= metres[each]) ?? smallestFirst[0];
  return { unit: shown, factor: metres[known] / metres[shown] };
}

const orderOf = (number) => Math.floor(Math.log10(number));

// Writes down to the digit that is worth 10 ** -places. isKnown: all of these digits are known, so zeros at the end are written,
// too.
function write(value, places, isKnown = true) {
  const size = Math.abs(value);
  if (size >= 1e9 || places > 9) {
    return Number(value.toPrecision(Math.max(Math.min(orderOf(size) + places + 1, mostDigits), 1))).toExponential();
  }
  const step = 10 ** -places;
  return (places < 0 ? Math.round(value / step) * step : value).toLocaleString(language,
    { minimumFractionDigits: isKnown ? Math.max(places, 0) : 0, maximumFractionDigits: Math.max(places, 0) });
}

// No digit is worth less than a tenth of the error, and no length has more than mostDigits digits. of: the length that determines
// the unit, if several lengths are shown together.
export function formatLength(value, error, unit, of = value) {
  const { unit: shown, factor } = readableUnit(Math.abs(of), unit);
  const size = Math.abs(value * factor);
  if (size === 0) {
    return shown ? figure("0", shown) : "0";
  }
  const longest = Math.max(Math.abs(of * factor), size);
  const byError = error > 0 ? -orderOf(error * factor) : Infinity;
  const places = Math.min(byError, mostDigits - 1 - orderOf(longest));
  const text = write(value * factor, places, error > 0);
  return shown ? figure(text, shown) : text;
}

// Returns the error with one digit; "" if no digit of the length is uncertain.
export function formatError(error, unit, of) {
  const { unit: shown, factor } = readableUnit(Math.abs(of), unit);
  const places = -orderOf(error * factor);
  if (!(error > 0) || places > mostDigits - 1 - orderOf(Math.max(Math.abs(of * factor), error * factor))) {
    return "";
  }
  const text = write(Math.ceil(error * factor * 10 ** places - 1e-6) / 10 ** places, places);
  return shown ? figure(text, shown) : text;
}

// Gives the longest side three digits, and the other sides as many decimal places.
export function describeLengths(sides, unit) {
  const longest = Math.max(...sides);
  if (!(longest > 0) || !Number.isFinite(longest)) {
    return "";
  }
  const { unit: shown, factor } = readableUnit(longest, unit);
  const digits = 2 - orderOf(longest * factor); // after the decimal point
  const plain = digits < 8 && digits > -7;
  const figures = sides.map((side) => {
    const value = side * factor;
    if (!plain) {
      return value.toLocaleString(language, { notation: "scientific", maximumSignificantDigits: 3 });
    }
    const step = 10 ** Math.max(-digits, 0);
    const rounded = digits < 0 ? Math.round(value / step) * step : value;
    return rounded.toLocaleString(language, { maximumFractionDigits: Math.max(digits, 0) });
  });
  return figure(figures.join(" × "), shown);
}
