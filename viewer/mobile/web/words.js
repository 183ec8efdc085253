// SPDX-License-Identifier: BSD-3-Clause
// Numbers in words: what the page says of models and of what comes.

const count = (number) => number.toLocaleString("en");

function kilobytes(bytes) {
  return bytes < 1e6 ? `${count(Math.ceil(bytes / 1000))}\u00a0kB` : `${(bytes / 1e6).toFixed(1)}\u00a0MB`;
}

function counted(number, thing) {
  return `${count(number)}\u00a0${thing}${number === 1 ? "" : "s"}`;
}

export function describeSize(triangles, vertices) {
  return triangles ? `${counted(triangles, "triangle")} · ${count(vertices)} vertices` : counted(vertices, "point");
}

export function describeSurface({ shownLevel, finestLevel, triangles, vertices, region, original }) {
  if (shownLevel === null) {
    return "";
  }
  const detail = region?.shown || original ? `Level ${shownLevel} and original` : `Level ${shownLevel} of ${finestLevel}`;
  return `${detail} · ${triangles ? counted(triangles, "triangle") : counted(vertices, "point")}`;
}

export function describeProgress({ blobsLoaded, blobsWanted, bytesLoaded }) {
  return blobsWanted ? `${blobsLoaded} of ${blobsWanted} parts, ${kilobytes(bytesLoaded)}` : "";
}
