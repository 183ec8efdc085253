// SPDX-License-Identifier: BSD-3-Clause
// The order in which a piece's triangles and vertices are coded: a walk over the surface.
//
// The walk starts at a triangle and crosses its edges. An edge that waits to be crossed is a
// *gate*. It runs from its start to its end along a coded triangle; the third corner of this
// triangle is the gate's *apex*. Gates form closed loops, the boundary of the coded part. Crossing
// a gate from a to b means finding the triangle (b, a, x) on its other side. One step of the walk
// (WalkStep) says what x is: a new vertex, the far end of the next or previous gate, or a vertex
// given by its number; or that there is no triangle. The walk goes on at an edge of the new
// triangle. When it cannot go on, it returns to the gate that began to wait last; if no gate waits,
// it starts again elsewhere. So it spirals, and mostly works on recently used data.
//
// Two edges are paired if they join the same two vertices in opposite directions. All other edges
// (of the third of three triangles, two in the same direction, of degenerate or duplicate
// triangles) are borders for the walk; it starts again at the triangles on their other side. So any
// list of triangles can be coded; only the order of the triangles, and which corner is first,
// change.
//
// The writer (WalkWriter.h) knows the triangles and finds the steps. The reader (WalkReader.h)
// follows the steps and finds the triangles. Both change the loops as described here.
//
// After the cut-border machine (S. Gumhold, W. Strasser, "Real time compression of triangle mesh
// connectivity", SIGGRAPH 1998) and Edgebreaker (J. Rossignac, 1999). Here loops only help to code:
// they need not be those of a manifold. O(triangles + vertices).
#pragma once

#include "filters/codec/SymbolCoder.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace kdstream
{

enum class WalkStep : std::uint8_t
{
  Border = 0,   // there is no triangle on the other side
  NewOwn = 1,   // x is a new vertex of the piece's own
  Next = 2,     // x is the end of the next gate, which is crossed too
  Previous = 3, // x is the start of the previous gate, which is crossed too
  Both = 4,     // both
  Jump = 5,     // x is a known vertex, and its number follows
  NewGhost = 6, // x is a new ghost
  None = 7      // marks the end in the reader
};

// A vertex of the walk. `gate` and `second` name vertices by their numbers in the walk.
struct WalkVertex
{
  // Where the walk found it: start, end and apex of the gate. In the first triangle of a walk: the
  // previous corner, three times. For a first corner, and for a vertex without triangles: the
  // previous vertex, three times (0 for vertex 0).
  std::array<std::uint32_t, 3> gate;
  // Another triangle that faces the vertex across an edge, in the same order; its corners come
  // before the vertex. If there is none: the same as `gate`.
  std::array<std::uint32_t, 3> second;
  std::uint32_t own;    // 1: the piece's own, 0: a ghost
  std::uint32_t guided; // 1: found at a gate, so a parallelogram predicts its position; or 0

  void Start(const std::array<std::uint32_t, 3>& foundAt, bool isOwn, bool isGuided)
  {
    this->gate = foundAt;
    this->second = foundAt;
    this->own = isOwn;
    this->guided = isGuided;
  }
};

struct WalkCounts
{
  std::size_t own = 0, ghosts = 0, triangles = 0;

  std::size_t Vertices() const { return this->own + this->ghosts; }
};

struct WalkGate
{
  std::uint32_t start, end;
  std::uint32_t apex; // `none`: the gate no longer waits and is in no loop
  std::uint32_t next, previous;
};

// The memory of a walk. Not vectors, which would initialize memory that is written anyway, and make
// the web page larger.
struct WalkArrays
{
  explicit WalkArrays(const WalkCounts& counts)
    : vertices(new WalkVertex[counts.Vertices() + 1]) // one more: WalkState::spareVertex
    , gates(new WalkGate[counts.triangles + 2]) // three at a start, at most one more with each step
    , gateFrom(new std::uint32_t[counts.Vertices()])
  {
  }

  std::unique_ptr<WalkVertex[]> vertices;
  std::unique_ptr<WalkGate[]> gates;
  std::unique_ptr<std::uint32_t[]> gateFrom;
};

// The state of a walk: the vertices found, the gates that wait, and the current gate. Should be a
// local variable of a function into which everything is inlined, so that compilers keep it in
// registers.
class WalkState
{
public:
  static constexpr std::uint32_t none = noVertex;
  using Corners = std::array<std::uint32_t, 3>;

  WalkState(const WalkArrays& arrays, const WalkCounts& counts)
    : vertices(arrays.vertices.get())
    , gates(arrays.gates.get())
    , gateFrom(arrays.gateFrom.get())
    , left{ static_cast<std::uint32_t>(counts.ghosts), static_cast<std::uint32_t>(counts.own) }
    , spareVertex(static_cast<std::uint32_t>(counts.Vertices()))
  {
  }

  // Adds a vertex with the next number. Returns false if all vertices were already found.
  bool AddVertex(const Corners& foundAt, bool own, bool guided);
  // Makes the edges of a first triangle wait, in a loop.
  void StartLoop(const Corners& corners);
  // Takes the gate that began to wait last as the current gate. Returns false if none waits.
  bool TakeGate();
  // Step Border: the gate leaves its loop.
  void EndAtBorder();
  // The steps to a triangle, as described at WalkStep. Each returns x, or `none` if the step is not
  // possible here. After CrossToBoth the walk cannot go on; after the others it does.
  std::uint32_t CrossToNew(bool own);
  std::uint32_t CrossToNext();
  std::uint32_t CrossToPrevious();
  std::uint32_t CrossToBoth();
  std::uint32_t CrossToKnown(std::uint32_t x); // REQUIRES: x < vertexCount
  // Adds the remaining vertices, which have no triangles, after all others: first own ones, then
  // ghosts.
  void AddIsolatedVertices();

  WalkVertex* vertices;
  WalkGate* gates;           // a stack of waiting and other gates
  std::uint32_t* gateFrom;   // of each vertex, the gate that starts there and was stacked last
  std::uint32_t left[2];     // numbers of ghosts and own vertices not found yet
  std::uint32_t spareVertex; // after the last one; never read (GuideByNext)
  std::uint32_t vertexCount = 0, stacked = 0;
  // The current gate: its number, by which its neighbours refer to it, and its vertices. Each step
  // after which the walk goes on moves this gate to the next edge.
  std::uint32_t here = 0, a = 0, b = 0, apex = 0, next = 0, previous = 0;

private:
  void Link(std::uint32_t gate, std::uint32_t after)
  {
    this->gates[gate].next = after;
    this->gates[after].previous = gate;
  }
  void Stack(const WalkGate& gate)
  {
    this->gates[this->stacked] = gate;
    this->gateFrom[gate.start] = this->stacked++;
  }
  void StackLeaving(std::uint32_t x);
  void GuideByNext(const WalkGate& following);
};

KDSTREAM_IN_LOOPS bool WalkState::AddVertex(const Corners& foundAt, bool own, bool guided)
{
  if (this->left[own ? 1 : 0] == 0)
  {
    return false;
  }
  --this->left[own ? 1 : 0];
  this->gateFrom[this->vertexCount] = 0;
  this->vertices[this->vertexCount++].Start(foundAt, own, guided);
  return true;
}

KDSTREAM_IN_LOOPS void WalkState::StartLoop(const Corners& corners)
{
  for (std::uint32_t k = 0; k < 3 && !IsDegenerate(corners); ++k)
  {
    const std::uint32_t after = k == 2 ? 0 : k + 1, before = k == 0 ? 2 : k - 1;
    this->Stack({ corners[k], corners[after], corners[before], after, before });
  }
}

KDSTREAM_IN_LOOPS bool WalkState::TakeGate()
{
  while (this->stacked > 0)
  {
    WalkGate& gate = this->gates[this->stacked - 1];
    if (gate.apex != none)
    {
      this->here = this->stacked - 1; // it stays on the stack: its neighbours refer to it
      this->a = gate.start;
      this->b = gate.end;
      this->apex = gate.apex;
      this->next = gate.next;
      this->previous = gate.previous;
      gate.apex = none;
      return true;
    }
    --this->stacked;
  }
  return false;
}

KDSTREAM_IN_LOOPS void WalkState::EndAtBorder()
{
  this->Link(this->previous, this->next);
}

// The edge a -> x of the new triangle begins to wait. It is put before the current gate, which
// becomes x -> b.
KDSTREAM_IN_LOOPS void WalkState::StackLeaving(std::uint32_t x)
{
  const std::uint32_t leaving = this->stacked;
  this->Stack({ this->a, x, this->b, this->here, this->previous });
  this->gates[this->previous].next = leaving;
  // The gate was the only one in its loop.
  this->next = this->next == this->here ? leaving : this->next;
  this->previous = leaving;
  this->apex = this->a;
  this->a = x;
}

KDSTREAM_IN_LOOPS std::uint32_t WalkState::CrossToNew(bool own)
{
  const std::uint32_t x = this->vertexCount;
  if (!this->AddVertex({ this->a, this->b, this->apex }, own, true))
  {
    return none;
  }
  this->StackLeaving(x);
  return x;
}

// `following` is the next gate, b -> x. The triangle on the other side of b -> x faces a across
// this edge. It gives a second prediction of a, if a comes after all three corners of that
// triangle. If not, the prediction is written to the spare vertex: a branch would often be
// mispredicted, and cost more time.
KDSTREAM_IN_LOOPS void WalkState::GuideByNext(const WalkGate& following)
{
  const bool guides = this->a > std::max(std::max(this->b, following.end), following.apex);
  this->vertices[guides ? this->a : this->spareVertex].second = { this->b, following.end,
    following.apex };
}

// The crossed gate becomes a -> x, and takes the place of the next gate too.
KDSTREAM_IN_LOOPS std::uint32_t WalkState::CrossToNext()
{
  if (this->next == this->here)
  {
    return none;
  }
  WalkGate& following = this->gates[this->next];
  this->GuideByNext(following);
  following.apex = none;
  this->apex = this->b;
  this->b = following.end;
  this->next = following.next;
  this->gates[this->next].previous = this->here;
  // The gate is the only one in its loop.
  this->previous = this->next == this->here ? this->here : this->previous;
  return this->b;
}

// The mirror image: the gate becomes x -> b, and takes the place of the previous gate too.
KDSTREAM_IN_LOOPS std::uint32_t WalkState::CrossToPrevious()
{
  if (this->previous == this->here)
  {
    return none;
  }
  WalkGate& preceding = this->gates[this->previous];
  preceding.apex = none;
  this->apex = this->a;
  this->a = preceding.start;
  this->previous = preceding.previous;
  this->gates[this->previous].next = this->here;
  this->next = this->previous == this->here ? this->here : this->next;
  return this->a;
}

KDSTREAM_IN_LOOPS std::uint32_t WalkState::CrossToBoth()
{
  WalkGate &following = this->gates[this->next], &preceding = this->gates[this->previous];
  if (this->next == this->here || this->next == this->previous || following.end != preceding.start)
  {
    return none;
  }
  this->GuideByNext(following);
  following.apex = none;
  preceding.apex = none;
  this->Link(preceding.previous, following.next);
  return following.end;
}

KDSTREAM_IN_LOOPS std::uint32_t WalkState::CrossToKnown(std::uint32_t x)
{
  const std::uint32_t there = this->gateFrom[x];
  const bool waits = this->gates[there].apex != none && this->gates[there].start == x;
  this->StackLeaving(x);
  if (waits)
  {
    // Two loops meet at x, or a loop meets itself. Cut both passages through x, and join the ends
    // crosswise.
    const std::uint32_t before = this->gates[there].previous;
    this->Link(this->previous, there);
    this->gates[before].next = this->here;
    this->next = before == this->here ? this->here : this->next; // there was no gate between
    this->previous = before;
  }
  return x;
}

inline void WalkState::AddIsolatedVertices()
{
  while (this->left[0] + this->left[1] > 0)
  {
    const std::uint32_t before = std::max(this->vertexCount, 1U) - 1;
    (void)this->AddVertex({ before, before, before }, this->left[1] > 0, false);
  }
}

}
