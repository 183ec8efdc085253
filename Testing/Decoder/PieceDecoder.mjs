// A second decoder of pieces, written from doc/formats.md (sections 3 to 5) alone: what is said
// there is enough, and what the C++ writes is what is said. For tests; it is not fast. Throws where a
// piece is damaged.

const floats = new DataView(new ArrayBuffer(8));
const sizes = [1, 1, 2, 2, 4, 4, 8, 8, 4, 8];
const context = { step: 0, new: 16, seed: 17, jump: 18, own: 19, group: 27, groupDifference: 35, samePartition: 36,
  partition: 37, index: 38, otherIndex: 39, position: 40, unguided: 43, deviation: 44, ownPartition: 45, ownIndex: 46,
  ancestorDepth: 47, ancestor: 48, reachEnd: 49, reachNode: 50, single: 51, attribute: 52 };

function need(holds, what) {
  if (!holds) throw new Error(what);
}

// Ordered bits as BigInt, of a float (4) or a double (8), and back.
function ordered(value, size) {
  size === 4 ? floats.setFloat32(0, value) : floats.setFloat64(0, value);
  const bits = size === 4 ? BigInt(floats.getUint32(0)) : floats.getBigUint64(0);
  const sign = 1n << BigInt(8 * size - 1);
  return bits & sign ? ~bits & (2n * sign - 1n) : bits | sign;
}
function unordered(bits, size) {
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

// Section 3.
class Symbols {
  constructor(reader, contexts) {
    this.bits = reader.take(reader.varint());
    this.words = new Bytes(reader.take(reader.bytes.length - reader.at));
    this.bit = 0;
    this.tables = [];
    for (let c = 0; c < contexts; ++c) this.tables.push(this.raw(1) ? this.table() : null);
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
  table() {
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
    const frequencies = classes.map((c) => (c === 0 ? 0 : 1 + Math.floor((weight(c) * (1024 - used)) / sum)));
    frequencies[heaviest] += 1024 - frequencies.reduce((x, y) => x + y, 0);
    const slots = [];
    frequencies.forEach((frequency, symbol) => {
      for (let slot = 0; slot < frequency; ++slot) slots.push({ symbol, frequency, slot });
    });
    return slots;
  }
  symbol(c) {
    const table = this.tables[c];
    const { symbol, frequency, slot } = table ? table[this.a % 1024] : { symbol: 0, frequency: 1024, slot: this.a % 1024 };
    let next = frequency * Math.floor(this.a / 1024) + slot;
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

// "The walk": vertices { gate, own, parallelograms } and triangles, both in its order.
function walk(symbols, own, ghosts, count) {
  const left = [ghosts, own], vertices = [], triangles = [], queue = [];
  const next = [], previous = [], state = []; // of half-edges: state 1 is open
  const start = (h) => triangles[h >> 2][h & 3], end = (h) => triangles[h >> 2][((h & 3) + 1) % 3];
  const apex = (h) => triangles[h >> 2][((h & 3) + 2) % 3];
  const link = (u, v) => {
    next[u] = v;
    previous[v] = u;
  };
  const open = (h) => {
    state[h] = 1;
    vertices[start(h)].open = h;
    queue.push(h);
  };
  const find = (gate) => {
    const known = (k) => (vertices.length && vertices[gate[k]].own ? 1 << k : 0);
    const isOwn = symbols.symbol(context.own + known(0) + known(1) + known(2));
    need(isOwn < 2 && left[isOwn]-- > 0, "too many vertices");
    return vertices.push({ gate, own: isOwn === 1, parallelograms: [], degree: 0, open: -1 }) - 1;
  };
  const name = (c) => {
    const ago = symbols.number(c);
    need(ago < vertices.length, "no such vertex");
    return vertices.length - 1 - ago;
  };
  const add = (triangle) => {
    need(triangles.length < count, "too many triangles");
    for (const v of triangle) vertices[v].degree = Math.min(255, vertices[v].degree + 1);
    return 4 * (triangles.push(triangle) - 1);
  };
  const parallelogram = (i, j, k, m) => {
    const later = vertices[Math.max(k, m)];
    if (k !== m && Math.max(k, m) > Math.max(i, j) && later.parallelograms.length < 3) {
      later.parallelograms.push([i, j, Math.min(k, m)]);
    }
  };
  const cross = (g) => {
    const a = start(g), b = end(g), c = apex(g), n = next[g], p = previous[g];
    const q = (state[n] === 1 ? 0 : 1) + (state[p] === 1 ? 0 : 2);
    const case_ = !vertices[a].own && !vertices[b].own ? q : q > 0 ? 3 + q : 7 + Math.min(8, vertices[b].degree);
    const step = symbols.symbol(context.step + case_);
    need(step <= 5, "no such step");
    state[g] = 0;
    if (step === 0) return;
    const byNext = step === 2 || step === 4, byPrevious = step === 3 || step === 4;
    need((!byNext || state[n] === 1) && (!byPrevious || state[p] === 1), "a gate that is not open");
    const x = step === 1 ? find([a, b, c]) : step === 5 ? name(context.jump) : byNext ? end(n) : start(p);
    const first = add([b, a, x]), l = first + 1, e = first + 2;
    parallelogram(a, b, c, x);
    if (byNext) parallelogram(b, x, apex(n), a);
    if (byPrevious) parallelogram(x, a, apex(p), b);
    if (byNext) state[n] = 0;
    if (byPrevious) state[p] = 0;
    if (step === 4) return link(previous[p], next[n]);
    if (step === 2) {
      link(p, l);
      link(l, next[n]);
      return open(l);
    }
    if (step === 3) {
      link(previous[p], e);
      link(e, n);
      return open(e);
    }
    link(p, l);
    const o = vertices[x].open;
    if (step === 5 && o >= 0 && state[o] === 1) {
      const r = previous[o];
      link(l, o);
      link(r, e);
    } else {
      link(l, e);
    }
    link(e, n);
    open(l);
    open(e);
  };
  for (let crossed = 0; triangles.length < count; ) {
    const triangle = [];
    for (let k = 0; k < 3; ++k) {
      const before = k > 0 ? triangle[k - 1] : Math.max(0, vertices.length - 1);
      triangle.push(symbols.symbol(context.new) ? find([before, before, before]) : name(context.seed));
    }
    const first = add(triangle);
    if (new Set(triangle).size === 3) {
      for (let k = 0; k < 3; ++k) {
        link(first + k, first + ((k + 1) % 3));
      }
      for (let k = 0; k < 3; ++k) open(first + k);
    }
    for (; crossed < queue.length; ++crossed) if (state[queue[crossed]] === 1) cross(queue[crossed]);
  }
  for (let isolated = left[0] + left[1], ownLeft = left[1]; isolated > 0; --isolated, --ownLeft) {
    const before = Math.max(0, vertices.length - 1);
    vertices.push({ gate: [before, before, before], own: ownLeft > 0, parallelograms: [] });
  }
  return { vertices, triangles };
}

// Grid coordinates, or the exact ones.
function readPositions(symbols, vertices, grid) {
  const m = symbols.number(context.single), apart = symbols.number(context.single) > 0;
  need(m <= 8, "no such mode");
  const most = 2 ** grid.bits - 1, size = grid.scalarType === 0 ? 4 : 8;
  const greatest = size === 4 ? 3.4028234663852886e38 : Number.MAX_VALUE;
  const positions = [];
  vertices.forEach((vertex, v) => {
    positions[v] = [0, 0, 0];
    for (let axis = 0; axis < 3; ++axis) {
      let foretold = v === 0 ? 0 : positions[vertex.gate[0]][axis];
      const guides = vertex.parallelograms;
      if (guides.length > 0) {
        foretold = 0;
        for (const [i, j, h] of guides) {
          foretold += (8 + m) * (positions[i][axis] + positions[j][axis]) - 2 * m * positions[h][axis];
        }
        foretold *= [0, 1 / 16, 1 / 32, 1 / 48][guides.length];
        if (grid.bits > 0) foretold = Math.min(most, Math.max(0, Math.floor(foretold + 0.5)));
        else if (!(Math.abs(foretold) <= greatest)) foretold = 0;
        else if (size === 4) foretold = Math.fround(foretold);
      }
      const c = guides.length === 0 ? context.unguided : context.position + (apart ? axis : 0);
      const difference = symbols.bigSigned(c);
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

// The number of each vertex, and the keys of the ghosts, which are as [partition, index].
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
    head.values = new Uint8Array(tuples * head.components * size);
    for (let t = 0; t < tuples; ++t) {
      const [i, j] = head.association === 0 ? vertices[t].gate : [Math.max(0, t - 1), Math.max(0, t - 1)];
      known[t] = new Array(head.components).fill(0n);
      for (let c = 0; c < head.components; ++c) {
        const foretold = (known[i][c] + known[j][c]) >> 1n;
        const value = BigInt.asUintN(width, foretold + symbols.bigSigned(context.attribute + which));
        known[t][c] = value;
        const isFloat = head.type >= 8, isSigned = !isFloat && head.type % 2 === 0;
        const raw = isFloat ? (value & sign ? value ^ sign : BigInt.asUintN(width, ~value)) : isSigned ? value ^ sign : value;
        const at = ((head.association === 0 ? numbers[t] : t) * head.components + c) * size;
        for (let b = 0; b < size; ++b) head.values[at + b] = Number((raw >> BigInt(8 * b)) & 255n);
      }
    }
  });
  return heads;
}

// blob: bytes, whose checksum the caller has checked. model: { partition, stitch } depths and grid {
// bits, scalarType, origin, step }; level: a depth, or null for the original; node. The piece:
// positions (doubles), keys ([partition, index]), deviations, ancestors (rows), reachEnds, reachNodes,
// triangles, attributes.
export function decodePiece(blob, model, level, node) {
  const reader = new Bytes(blob.subarray(0, blob.length - 8));
  need([0x4b, 0x44, 0x50, 3].every((byte) => reader.byte() === byte), "no piece of version 3");
  const below = level !== null && level < model.stitch;
  const primitive = reader.byte(), own = reader.varint(), ghosts = reader.varint(), count = reader.varint();
  const reach = below ? reader.varint() : 0;
  const heads = Array.from({ length: reader.varint() }, () => ({
    name: new TextDecoder().decode(reader.take(reader.varint())), type: reader.byte(), association: reader.byte(),
    components: reader.byte() }));
  need(heads.every((head) => head.type < 10 && head.association < 2), "unknown attribute type");
  const carriers = below ? 0 : level === model.stitch ? own + ghosts : ghosts;
  const size = heads.reduce((sum, head) => sum + (head.association === 0 ? own + ghosts : count) * head.components * sizes[head.type],
    32 * (own + ghosts) + 12 * count + 4 * reach + 4 * carriers * model.stitch);
  need(Math.floor(size / 128) <= reader.bytes.length - reader.at, "counts that the bytes cannot hold");

  const symbols = new Symbols(reader, context.attribute + heads.length);
  const { vertices, triangles } = walk(symbols, own, ghosts, count);
  const places = readPositions(symbols, vertices, model.grid);
  const { numbers, ghostKeys } = readNumbers(symbols, vertices, places, own);
  const positions = [];
  places.forEach((place, v) => {
    positions[numbers[v]] = model.grid.bits === 0 ? place : place.map((q, axis) => model.grid.origin[axis] + q * model.grid.step);
  });
  const rotated = triangles.map((t) => {
    const [a, b, c] = t.map((v) => numbers[v]);
    return [[a, b, c], [b, c, a], [c, a, b]].sort(compare)[0];
  });
  let ownKeys;
  if (below) {
    const first = symbols.number(context.single);
    ownKeys = Array.from({ length: own }, (_, i) => [0, first + i]);
  } else if (level === null) {
    ownKeys = Array.from({ length: own }, (_, i) => [node - 2 ** model.partition, i]);
  } else {
    const partitions = symbols.array(context.ownPartition, own), indices = symbols.array(context.ownIndex, own);
    ownKeys = partitions.map((partition, i) => [partition, indices[i]]);
  }
  let deviations = [];
  if (level !== null) {
    const shift = 2 ** symbols.number(context.single);
    deviations = symbols.array(context.deviation, own).map((bits) => unordered(BigInt(bits * shift), 4));
  }
  const ancestors = [];
  let row = new Array(model.stitch).fill(0);
  for (let i = 0; model.stitch > 0 && i < carriers; ++i) {
    const differ = symbols.number(context.ancestorDepth);
    need(differ <= model.stitch, "ranks out of range");
    row = row.slice();
    for (let d = model.stitch - differ; d < model.stitch; ++d) row[d] += symbols.signed(context.ancestor);
    ancestors.push(row);
  }
  const reachEnds = below ? symbols.array(context.reachEnd, own) : [];
  const reachNodes = below ? symbols.array(context.reachNode, reach) : [];
  const attributes = readAttributes(symbols, heads, vertices, numbers, count);
  symbols.finish();
  return { primitive, own, positions, keys: ownKeys.concat(ghostKeys), deviations, ancestors, reachEnds, reachNodes,
    triangles: rotated.sort(compare), attributes };
}

function compare(s, t) {
  return s[0] - t[0] || s[1] - t[1] || s[2] - t[2];
}
