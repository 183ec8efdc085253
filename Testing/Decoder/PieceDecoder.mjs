// SPDX-License-Identifier: BSD-3-Clause
// A second decoder of pieces, tree pages and boxes, for tests. It is written only from doc/formats.md (sections 3 to
// 7): it shows that the document is sufficient, and that the C++ code follows it. It is not fast. Throws if a blob is
// damaged.

const floats = new DataView(new ArrayBuffer(8));
const sizes = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8];
const context = { seed: 0, group: 1, samePartition: 9, parent: 10, sibling: 12, steps: 20, seedVertex: 21, jump: 22,
  groupDifference: 23, partition: 24, index: 25, otherIndex: 26, position: 27, unguided: 30, ownPartition: 31, ownIndex: 32,
  ancestor: 33, childEnd: 34, childNode: 35, single: 36, attribute: 37 };
const pieceChoices = 20; // contexts with few symbols, whose frequencies add up to 256

export function need(holds, what) {
  if (!holds) throw new Error(what);
}

// The ordered bits of a float (size 4) or a double (8) as BigInt, and back.
export function ordered(value, size) {
  size === 4 ? floats.setFloat32(0, value) : floats.setFloat64(0, value);
  const bits = size === 4 ? BigInt(floats.getUint32(0)) : floats.getBigUint64(0);
  const sign = 1n << BigInt(8 * size - 1);
  return bits & sign ? ~bits & (2n * sign - 1n) : bits | sign;
}
export function unordered(bits, size) {
  const sign = 1n << BigInt(8 * size - 1);
  const raw = bits & sign ? bits ^ sign : ~bits & (2n * sign - 1n);
  size === 4 ? floats.setUint32(0, Number(raw)) : floats.setBigUint64(0, raw);
  return size === 4 ? floats.getFloat32(0) : floats.getFloat64(0);
}

class Bytes {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }
  byte() {
    need(this.at < this.bytes.length, "truncated");
    return this.bytes[this.at++];
  }
  varint() {
    let value = 0;
    for (let unit = 1; ; unit *= 128) {
      const byte = this.byte();
      value += (byte & 127) * unit;
      if (byte < 128) return value;
      need(unit < 2 ** 49, "number too long");
    }
  }
  take(count) {
    need(count <= this.bytes.length - this.at, "truncated");
    this.at += count;
    return this.bytes.subarray(this.at - count, this.at);
  }
}

// The symbols of section 3.
export class Symbols {
  constructor(reader, contexts, choices = pieceChoices) {
    this.choices = choices;
    this.bits = reader.take(reader.varint());
    this.words = new Bytes(reader.take(reader.bytes.length - reader.at));
    this.bit = 0;
    this.tables = [];
    for (let c = 0; c < contexts; ++c) this.tables.push(this.raw(1) ? this.table(c < this.choices ? 256 : 1024) : null);
    this.bit = Math.ceil(this.bit / 8) * 8;
    this.a = this.word() + 65536 * this.word();
    this.b = this.word() + 65536 * this.word();
  }
  word() {
    return this.words.byte() + 256 * this.words.byte();
  }
  raw(count) {
    let value = 0n;
    for (let i = 0n; i < BigInt(count); ++i, ++this.bit) {
      need(this.bit < 8 * this.bits.length, "truncated bits");
      value |= BigInt((this.bits[this.bit >> 3] >> (this.bit & 7)) & 1) << i;
    }
    return count <= 32 ? Number(value) : value;
  }
  table(total) {
    const first = this.raw(7), last = this.raw(7), classes = [];
    for (let s = first; s <= last; ++s) classes[s] = this.raw(4);
    const weight = (c) => (c === 0 ? 0 : c % 2 ? 2 * 2 ** Math.floor(c / 2) : 3 * 2 ** (c / 2 - 1));
    let used = 0, sum = 0, heaviest = -1;
    classes.forEach((c, s) => {
      used += c > 0 ? 1 : 0;
      sum += weight(c);
      if (c > 0 && (heaviest < 0 || c > classes[heaviest])) heaviest = s;
    });
    need(used > 0, "an empty table");
    const frequencies = classes.map((c) => (c === 0 ? 0 : 1 + Math.floor((weight(c) * (total - used)) / sum)));
    frequencies[heaviest] += total - frequencies.reduce((x, y) => x + y, 0);
    const slots = [];
    frequencies.forEach((frequency, symbol) => {
      for (let slot = 0; slot < frequency; ++slot) slots.push({ symbol, frequency, slot });
    });
    return slots;
  }
  symbol(c) {
    const table = this.tables[c];
    const total = c < this.choices ? 256 : 1024, at = this.a % total;
    const { symbol, frequency, slot } = table ? table[at] : { symbol: 0, frequency: total, slot: at };
    let next = frequency * Math.floor(this.a / total) + slot;
    if (next < 65536) next = 65536 * next + this.word();
    this.a = this.b;
    this.b = next;
    return symbol;
  }
  big(c) {
    const s = this.symbol(c);
    if (s < 2) return BigInt(s);
    const k = (s >> 1) - 1;
    return (BigInt(2 + (s & 1)) << BigInt(k)) + BigInt(this.raw(k));
  }
  number(c) {
    return Number(this.big(c));
  }
  bigSigned(c) {
    const n = this.big(c);
    return n & 1n ? -((n + 1n) / 2n) : n / 2n;
  }
  signed(c) {
    return Number(this.bigSigned(c));
  }
  array(c, count) {
    let last = 0;
    return Array.from({ length: count }, () => (last += this.signed(c)));
  }
  finish() {
    for (; this.bit < 8 * this.bits.length; ) need(this.raw(1) === 0, "bits beyond the end");
    need(this.a === 65536 && this.b === 65536 && this.words.at === this.words.bytes.length, "words beyond the end");
  }
}

// "The walk": returns vertices { gate, second, own, guided } and triangles, both in the order of the walk.
function walk(symbols, own, ghosts, count, stepCount) {
  const steps = [];
  for (let i = 0; i < stepCount; i += 2) {
    const pair = symbols.symbol(context.steps);
    steps.push(pair >> 3, pair & 7);
  }
  need(stepCount % 2 === 0 || steps.pop() === 0, "a step too many");
  const left = [ghosts, own], vertices = [], triangles = [], stack = [];
  let taken = 0;
  const link = (u, v) => {
    u.next = v;
    v.previous = u;
  };
  const wait = (gate) => {
    gate.waits = true;
    stack.push(gate);
    vertices[gate.start].from = gate;
    return gate;
  };
  const find = (gate, isOwn, guided) => {
    need(left[isOwn]-- > 0, "too many vertices");
    return vertices.push({ gate, second: gate, own: isOwn === 1, guided, from: null }) - 1;
  };
  const name = (c) => {
    const ago = symbols.number(c);
    need(ago < vertices.length, "no such vertex");
    return vertices.length - 1 - ago;
  };
  const add = (triangle) => {
    need(triangles.length < count, "too many triangles");
    triangles.push(triangle);
  };
  // Takes the step at gate g. Returns whether the walk continues there.
  const cross = (g) => {
    const { start: a, end: b, apex: c, next: n, previous: p } = g;
    need(taken < stepCount, "too few steps");
    const step = steps[taken++];
    need(step <= 6, "no such step");
    if (step === 0) {
      link(p, n);
      return false;
    }
    const byNext = step === 2 || step === 4, byPrevious = step === 3 || step === 4;
    need((!byNext || n !== g) && (!byPrevious || p !== g), "a gate that is alone");
    need(step !== 4 || (n !== p && n.end === p.start), "gates that do not meet");
    const x = step === 1 ? find([a, b, c], 1, true) : step === 6 ? find([a, b, c], 0, true)
      : step === 5 ? name(context.jump) : byNext ? n.end : p.start;
    add([b, a, x]);
    if (byNext) {
      if (a > Math.max(b, x, n.apex)) vertices[a].second = [b, x, n.apex];
      n.waits = false;
    }
    if (byPrevious) p.waits = false;
    if (step === 4) {
      link(p.previous, n.next);
      return false;
    }
    if (step === 2) {
      link(g, n.next);
      [g.end, g.apex] = [x, b];
    } else if (step === 3) {
      link(p.previous, g);
      [g.start, g.apex] = [x, a];
    } else {
      const o = step === 5 ? vertices[x].from : null, meets = o !== null && o.waits;
      const l = wait({ start: a, end: x, apex: b });
      [g.start, g.apex] = [x, a];
      link(g.previous, l);
      link(l, g);
      if (meets) {
        const r = o.previous;
        link(l, o);
        link(r, g);
      }
    }
    return true;
  };
  while (triangles.length < count) {
    const triangle = [];
    for (let k = 0; k < 3; ++k) {
      const before = k > 0 ? triangle[k - 1] : Math.max(0, vertices.length - 1);
      const kind = symbols.symbol(context.seed);
      need(kind < 3, "no such corner");
      triangle.push(kind === 0 ? name(context.seedVertex) : find([before, before, before], kind === 1 ? 1 : 0, false));
    }
    add(triangle);
    if (new Set(triangle).size === 3) {
      const gates = triangle.map((start, k) => wait({ start, end: triangle[(k + 1) % 3], apex: triangle[(k + 2) % 3] }));
      gates.forEach((gate, k) => link(gate, gates[(k + 1) % 3]));
    }
    while (stack.length > 0) {
      const gate = stack.pop();
      if (!gate.waits) continue;
      gate.waits = false;
      while (cross(gate));
    }
  }
  need(taken === stepCount, "steps beyond the end");
  for (let isolated = left[0] + left[1], ownLeft = left[1]; isolated > 0; --isolated, --ownLeft) {
    const before = Math.max(0, vertices.length - 1), gate = [before, before, before];
    vertices.push({ gate, second: gate, own: ownLeft > 0, guided: false });
  }
  return { vertices, triangles };
}

// "Positions", predicted by planes: returns the differences along x, y, z.
function offPlane(vertex, positions, coded) {
  const [i, j, h] = vertex.gate.map((w) => positions[w]);
  const u = j.map((value, axis) => value - i[axis]), v = h.map((value, axis) => value - i[axis]);
  const normal = [1, 2, 0].map((p, axis) => u[p] * v[(axis + 2) % 3] - u[(axis + 2) % 3] * v[p]);
  const sizes = normal.map(Math.abs), k = sizes.indexOf(Math.max(...sizes)), [p, q] = [(k + 1) % 3, (k + 2) % 3];
  const [s, t] = [Number(coded[0]), Number(coded[1])];
  const rise = normal[k] === 0 ? 0 : -((normal[p] * s + normal[q] * t) / normal[k]);
  const below = Math.floor(rise), nearest = rise - below > 0.5 || (rise - below === 0.5 && below % 2 !== 0) ? below + 1 : below;
  const differences = [];
  [differences[p], differences[q], differences[k]] = [coded[0], coded[1], coded[2] + BigInt(nearest)];
  return differences;
}

// Reads grid coordinates, or exact ones.
function readPositions(symbols, vertices, grid) {
  const m = symbols.number(context.single), mode = symbols.number(context.single);
  need(m <= 8 && mode <= (grid.bits > 0 ? 2 : 1), "no such mode");
  const most = Math.floor((2 ** grid.bits - 1 + Math.floor(grid.spacing / 2)) / grid.spacing), size = grid.scalarType === 0 ? 4 : 8;
  const greatest = size === 4 ? 3.4028234663852886e38 : Number.MAX_VALUE;
  const positions = [];
  vertices.forEach((vertex, v) => {
    positions[v] = [0, 0, 0];
    const contexts = !vertex.guided ? [0, 0, 0].fill(context.unguided) : [[0, 0, 0], [0, 1, 2], [0, 0, 1]][mode].map((c) => context.position + c);
    const coded = contexts.map((c) => symbols.bigSigned(c));
    const differences = mode === 2 && vertex.guided ? offPlane(vertex, positions, coded) : coded;
    for (let axis = 0; axis < 3; ++axis) {
      let foretold = v === 0 ? 0 : positions[vertex.gate[0]][axis];
      if (vertex.guided) {
        const [i, j, h] = vertex.gate.map((w) => positions[w][axis]), [k, l, g] = vertex.second.map((w) => positions[w][axis]);
        const edges = i + j + (k + l), apexes = h + g;
        foretold = (8 + m) * edges - 2 * m * apexes;
        if (grid.bits === 0) foretold /= 32;
        if (grid.bits > 0) foretold = Math.min(most, Math.floor(Math.max(0, foretold + 16) / 32));
        else if (!(Math.abs(foretold) <= greatest)) foretold = 0;
        else if (size === 4) foretold = Math.fround(foretold);
      }
      const difference = differences[axis];
      if (grid.bits > 0) {
        positions[v][axis] = foretold + Number(difference);
        need(positions[v][axis] >= 0 && positions[v][axis] <= most, "coordinate out of range");
      } else {
        positions[v][axis] = unordered(BigInt.asUintN(8 * size, ordered(foretold, size) + difference), size);
        need(Number.isFinite(positions[v][axis]), "coordinate out of range");
      }
    }
  });
  return positions;
}

// Reads the number of each vertex, and the keys of the ghosts as [partition, index].
function readNumbers(symbols, vertices, positions, own) {
  const groups = vertices.map(() => -1), numbers = [], owned = [], ghosts = [];
  let last = 0;
  vertices.forEach((vertex, v) => {
    if (!vertex.own) return;
    const g = vertex.gate.map((near) => (near === v ? -1 : groups[near]));
    const which = symbols.symbol(context.group + (g[0] === g[1]) + 2 * (g[1] === g[2]) + 4 * (g[0] === g[2]));
    const known = g.find((group) => group >= 0);
    last = which < 3 ? g[which] : (known ?? last) + symbols.signed(context.groupDifference);
    need(last >= 0 && last < own, "group out of range");
    groups[v] = last;
    owned.push(v);
  });
  const place = (v, w) => positions[v][0] - positions[w][0] || positions[v][1] - positions[w][1] || positions[v][2] - positions[w][2];
  owned.sort((v, w) => groups[v] - groups[w] || place(v, w) || v - w).forEach((v, number) => (numbers[v] = number));
  let before = [0, 0];
  const keys = [];
  vertices.forEach((vertex, v) => {
    if (vertex.own) return;
    const near = vertex.gate.find((w) => w < v && !vertices[w].own);
    const reference = near === undefined ? before : keys[near];
    keys[v] = before = symbols.symbol(context.samePartition)
      ? [reference[0], reference[1] + symbols.signed(context.index)]
      : [reference[0] + symbols.signed(context.partition), symbols.number(context.otherIndex)];
    need(keys[v].every((part) => part >= 0 && part < 2 ** 32), "key out of range");
    ghosts.push(v);
  });
  ghosts.sort((v, w) => keys[v][0] - keys[w][0] || keys[v][1] - keys[w][1]);
  ghosts.forEach((v, i) => (numbers[v] = own + i));
  return { numbers, ghostKeys: ghosts.map((v) => keys[v]) };
}

function readAttributes(symbols, heads, vertices, numbers, triangleCount) {
  heads.forEach((head, which) => {
    const size = sizes[head.type], width = 8 * size, sign = 1n << BigInt(width - 1);
    const tuples = head.association === 0 ? vertices.length : triangleCount;
    const known = [];
    const bits = head.coarse ? 4 : width; // of coarse colours, whose steps are of 17
    head.values = new Uint8Array(tuples * head.components * size);
    for (let t = 0; t < tuples; ++t) {
      const [i, j] = head.association === 0 ? vertices[t].gate : [Math.max(0, t - 1), Math.max(0, t - 1)];
      known[t] = new Array(head.components).fill(0n);
      let red = 0n;
      for (let c = 0; c < head.components; ++c) {
        const difference = symbols.bigSigned(context.attribute + which);
        red = c === 0 ? difference : red;
        const foretold = ((known[i][c] + known[j][c]) >> 1n) + (head.coarse && (c === 1 || c === 2) ? red : 0n);
        const coded = BigInt.asUintN(bits, foretold + difference);
        known[t][c] = coded;
        const value = head.coarse ? 17n * coded : coded;
        const isFloat = head.type >= 8, isSigned = !isFloat && head.type % 2 === 0;
        const raw = isFloat ? (value & sign ? value ^ sign : BigInt.asUintN(width, ~value)) : isSigned ? value ^ sign : value;
        const at = ((head.association === 0 ? numbers[t] : t) * head.components + c) * size;
        for (let b = 0; b < size; ++b) head.values[at + b] = Number((raw >> BigInt(8 * b)) & 255n);
      }
    }
  });
  return heads;
}

// "Ancestors": returns a row of ranks, coarse to fine, for each vertex that has ancestors. triangles: those of the
// piece in order, if all its vertices have ancestors.
function readAncestors(symbols, vertices, levels, triangles) {
  const rows = Array.from({ length: vertices }, () => new Array(levels));
  let entries = rows.map((row) => [row]); // for each entry, the rows that contain it
  let edges = triangles.flatMap(([a, b, c]) => [[a, b], [b, c], [c, a]]).filter(([start, end]) => start < end);
  for (let level = levels - 1; level >= 0; --level) {
    edges.sort((x, y) => x[1] - y[1]);
    const before = entries.map(() => []);
    for (const [start, end] of edges) before[end].push(start);
    let last = [], next = 0;
    const byParent = new Map(), groupOf = [], ranks = [], finest = level === levels - 1;
    entries.forEach((entry, e) => {
      const around = [];
      for (const group of before[e].map((near) => groupOf[near])) {
        if (around.length < 15 && !around.includes(group)) around.push(group);
      }
      const single = around.filter((group) => group.entries === 1);
      const groups = single.concat(around.filter((group) => group.entries > 1));
      const choice = groups.length === 0 ? 0 : symbols.symbol(context.sibling + (finest ? 0 : 4) + Math.min(3, single.length));
      need(choice <= groups.length, "no such sibling");
      const group = choice > 0 ? groups[choice - 1] : { entries: 0, rank: 0 };
      if (choice === 0) {
        const symbol = symbols.symbol(context.parent + (finest ? 0 : 1));
        need(symbol <= 9 && (symbol >= 8 || symbol < last.length), "no such parent");
        group.rank = symbol === 9 ? (last[0] ?? 0) + symbols.signed(context.ancestor) : symbol === 8 ? next : last[symbol];
        need(group.rank >= 0 && group.rank < 2 ** 32 - 1, "ranks out of range");
        last = [group.rank, ...last.filter((other) => other !== group.rank)].slice(0, 8);
        next = Math.max(next, group.rank + 1);
      }
      ++group.entries;
      groupOf.push(group);
      const rank = group.rank;
      ranks.push(rank);
      for (const row of entry) row[level] = rank;
      byParent.set(rank, (byParent.get(rank) ?? []).concat(entry));
    });
    const parents = [...byParent.keys()].sort((x, y) => x - y), place = new Map(parents.map((rank, i) => [rank, i]));
    entries = parents.map((rank) => byParent.get(rank));
    edges = edges.map((edge) => edge.map((e) => place.get(ranks[e])).sort((x, y) => x - y)).filter(([start, end]) => start < end);
  }
  return rows;
}

// Decodes a piece. blob: its bytes; the caller has checked the checksum. model: { partition, stitch, preview }, which
// are depths, and grid { bits, scalarType, origin, step, spacing (the level's; 1 for the original) }. level: a depth,
// or null for the original. node: the piece's node. Returns positions (doubles), keys ([partition, index]), ancestors
// (rows), childEnds, childNodes, triangles, attributes.
export function decodePiece(blob, model, level, node) {
  const reader = new Bytes(blob.subarray(0, blob.length - 8));
  need([0x4b, 0x44, 0x50, 8].every((byte) => reader.byte() === byte), "no piece of version 8");
  const below = level !== null && level < model.stitch;
  const hasChildren = below && level >= model.preview;
  const primitive = reader.byte(), own = reader.varint(), ghosts = reader.varint(), count = reader.varint(), steps = reader.varint();
  const children = hasChildren ? reader.varint() : 0;
  const heads = Array.from({ length: reader.varint() }, () => ({
    name: new TextDecoder().decode(reader.take(reader.varint())), type: reader.byte(), association: reader.byte(),
    components: reader.byte() }));
  for (const head of heads) {
    head.coarse = (head.type & 64) !== 0;
    head.type &= ~64;
    need(!head.coarse || (["RGB", "RGBA"].includes(head.name) && head.type === 1 && head.association === 0 &&
      head.components === head.name.length), "coarse, but not colours");
  }
  need(heads.every((head) => head.type < 10 && head.association < 2), "unknown attribute type");
  const coarse = level !== null && level <= model.stitch; // own vertices have ancestors, too
  const levels = Math.max(0, (coarse ? level : model.stitch) - model.preview);
  const carriers = levels === 0 ? 0 : coarse ? own + ghosts : ghosts;
  const size = heads.reduce((sum, head) => sum + (head.association === 0 ? own + ghosts : count) * head.components * sizes[head.type],
    32 * (own + ghosts) + 12 * count + 4 * children + 4 * carriers * levels);
  need(Math.floor(size / 128) <= reader.bytes.length - reader.at, "counts are too large for the bytes");

  const symbols = new Symbols(reader, context.attribute + heads.length);
  const { vertices, triangles } = walk(symbols, own, ghosts, count, steps);
  const places = readPositions(symbols, vertices, model.grid);
  const { numbers, ghostKeys } = readNumbers(symbols, vertices, places, own);
  const positions = [];
  places.forEach((place, v) => {
    const { bits, origin, spacing, step } = model.grid;
    positions[numbers[v]] = bits === 0 ? place : place.map((q, axis) => origin[axis] + q * spacing * step);
  });
  const rotated = triangles.map((t) => {
    const [a, b, c] = t.map((v) => numbers[v]);
    return [[a, b, c], [b, c, a], [c, a, b]].sort(compare)[0];
  }).sort(compare);
  let ownKeys;
  if (below) {
    const first = symbols.number(context.single);
    ownKeys = Array.from({ length: own }, (_, i) => [0, first + i]);
  } else if (level === null) {
    ownKeys = Array.from({ length: own }, (_, i) => [node - 2 ** model.partition, i]);
  } else {
    let partition = 0, index = -1;
    ownKeys = Array.from({ length: own }, () => {
      const further = symbols.number(context.ownPartition), between = symbols.number(context.ownIndex);
      partition += further;
      index = (further > 0 ? -1 : index) + 1 + between;
      return [partition, index];
    });
  }
  const ancestors = readAncestors(symbols, carriers, levels, coarse ? rotated : []);
  const childEnds = hasChildren ? symbols.array(context.childEnd, own) : [];
  const childNodes = hasChildren ? symbols.array(context.childNode, children) : [];
  const attributes = readAttributes(symbols, heads, vertices, numbers, count);
  symbols.finish();
  return { primitive, own, positions, keys: ownKeys.concat(ghostKeys), ancestors, childEnds, childNodes,
    triangles: rotated, attributes };
}

function compare(s, t) {
  return s[0] - t[0] || s[1] - t[1] || s[2] - t[2];
}

export function content(blob, magic) {
  const reader = new Bytes(blob.subarray(0, blob.length - 8));
  need([...Buffer.from(magic), 8].every((byte) => reader.byte() === byte), `no ${magic} of version 8`);
  return reader;
}

const depthOf = (node) => Math.floor(Math.log2(node));
const isEmpty = (box) => box.lo[0] > box.hi[0];
const empty = () => ({ lo: [Infinity, Infinity, Infinity], hi: [-Infinity, -Infinity, -Infinity] });

function depthsOfPage(page, partition) {
  return page > 1 ? 5 : partition < 10 ? partition : 5 + (partition % 5);
}

function readBox(symbols, parent, second) {
  const side = [0, 1, 2].map((k) => parent.hi[k] - parent.lo[k]);
  const split = side.indexOf(Math.max(...side));
  const plane = (k, step) => step === 0 ? parent.lo[k] : step === 16 ? parent.hi[k] : parent.lo[k] + side[k] * (step / 16);
  const box = { lo: [], hi: [] };
  for (let k = 0; k < 3; ++k) {
    for (const upper of [false, true]) {
      const away = k === split && upper !== second ? symbols.signed(1) + 8 : symbols.number(2);
      need(away >= 0 && away <= 16, "a box is not inside its parent's box");
      (upper ? box.hi : box.lo)[k] = plane(k, upper ? 16 - away : away);
    }
    need(box.lo[k] <= box.hi[k], "a box is not inside its parent's box");
  }
  return box;
}

// Section 6. model: { partition, finest, onePiece: 11, levels: whether it has any }. around: the box of the page's
// node. Returns boxes by heap number relative to the page, from 2 on, and facts { most99, most, bytes } in the order of
// the page.
export function decodeTreePage(blob, model, page, around) {
  const symbols = new Symbols(content(blob, "KDT"), 6, 1);
  const top = depthOf(page), most = top + depthsOfPage(page, model.partition);
  const boxes = [empty(), around];
  for (let i = 2; i < 2 ** (most - top + 1); ++i) {
    const parent = boxes[i >> 1];
    boxes.push(isEmpty(parent) || symbols.symbol(0) !== 0 ? empty() : readBox(symbols, parent, i % 2 === 1));
  }
  const depths = [];
  for (let level = 0; model.levels && level <= model.finest; ++level) {
    depths.push(Math.min(model.partition, Math.max(0, level - model.onePiece)));
  }
  const pieces = [...depths, model.partition].filter((depth) => (depth > top || page === 1) && depth <= most)
    .reduce((sum, depth) => sum + 2 ** (depth - top), 0);
  const bound = (code) => new Float32Array(new Uint32Array([code << 19]).buffer)[0];
  let nearly = 0, bytes = 0;
  const facts = Array.from({ length: pieces }, () => {
    nearly += symbols.signed(3);
    const all = nearly + symbols.number(4);
    bytes += symbols.signed(5);
    need(nearly >= 0 && all <= 0xfef && bytes >= 0 && bytes <= 192, "bounds or bytes out of range");
    return { most99: bound(nearly), most: bound(all),
      bytes: bytes < 16 ? bytes : (8 + (bytes % 8)) * 2 ** (Math.floor(bytes / 8) - 1) };
  });
  symbols.finish();
  return { boxes, facts };
}

// Section 7: returns the boxes of the partitions below `node`.
export function decodePartitionBoxes(blob, model, node) {
  const reader = content(blob, "KDB");
  const width = reader.byte();
  need(width === 4 || width === 8, "unknown width");
  const symbols = new Symbols(reader, 6, 0);
  const boxes = Array.from({ length: 2 ** (model.partition - depthOf(node)) }, empty);
  for (let side = 0; side < 6; ++side) {
    let bits = 0n;
    for (const box of boxes) {
      bits = BigInt.asUintN(64, bits + symbols.bigSigned(side));
      need(width === 8 || bits < 2n ** 32n, "a coordinate out of range");
      (side < 3 ? box.lo : box.hi)[side % 3] = unordered(bits, width);
    }
  }
  symbols.finish();
  return boxes;
}
