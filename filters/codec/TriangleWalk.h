// The order in which a piece's triangles and vertices are coded: a walk over the surface.
//
// The walk starts at a triangle and crosses its edges. An edge that waits to be crossed is a
// *gate*: a half-edge a -> b of a triangle that is done. Gates lie in closed loops, the boundary of
// what is done; they are crossed first come, first served. Crossing finds the triangle (b, a, x) on
// the other side and says by one symbol what x is: new, or the far end of the next or previous
// gate, or a vertex named by number; or that nothing is there. Where no gate is left a new walk
// starts.
//
// Edges are paired once and oppositely directed; whatever is not so (edges of three triangles, of
// two in one direction, degenerate and duplicate triangles) is a border to the walk, and the
// triangles behind it are starts of their own. So every list of triangles comes back, with any
// vertices; only their order and rotation are the walk's.
//
// After the cut-border machine (S. Gumhold, W. Strasser, "Real time compression of triangle mesh
// connectivity", SIGGRAPH 1998) and Edgebreaker (J. Rossignac, 1999); loops here are hints and need
// not be those of a manifold. Coders: SymbolCoder.h. O(triangles + vertices).
#pragma once

#include "filters/codec/PieceContexts.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

enum class WalkStep : std::uint8_t
{
  Border = 0,   // nothing is on the other side
  New = 1,      // x is a new vertex
  Next = 2,     // x is the end of the next gate, which is crossed too
  Previous = 3, // x is the start of the previous gate, which is crossed too
  Both = 4,     // both
  Jump = 5      // x is named
};

// A vertex of the walk, by its number in it.
struct WalkVertex
{
  // The gate's vertices a and b at which it was found, and the third of the gate's triangle. In a
  // first triangle three times the corner before, or the vertex before; of vertex 0, 0.
  std::array<std::uint32_t, 3> gate{};
  // Up to three parallelograms of vertices before it: a, b on an edge that faces it, c behind that
  // edge.
  std::array<std::array<std::uint32_t, 3>, 3> parallelograms{};
  std::uint8_t parallelogramCount = 0;
  bool own = false;
  // While the walk goes on: triangles so far (at most 255), and the gate from here opened last.
  std::uint8_t degree = 0;
  std::uint32_t openGate = noVertex;
};

// Both directions of the walk. Writing needs the piece's triangles; reading makes them.
template <class Coder>
class TriangleWalk
{
private:
  enum class State : std::uint32_t
  {
    Idle = 0,   // not a gate, or crossed
    Open = 1,   // waits
    Border = 2, // nothing was there
  };
  // A half-edge of triangle t is number 4 t + k.
  struct Gate
  {
    std::uint32_t start = 0, next = 0, previous = 0;
    State state = State::Idle;
  };
  // No vectors: less code in the page.
  std::unique_ptr<WalkVertex[]> VertexArray;
  std::unique_ptr<Gate[]> GateArray;

public:
  // own + ghosts: the most vertices that a reader makes.
  TriangleWalk(Coder& coder, std::size_t own, std::size_t ghosts, std::size_t triangles)
    : VertexArray(new WalkVertex[own + ghosts])
    , GateArray(new Gate[4 * triangles])
    , Vertices(VertexArray.get(), own + ghosts)
    , OwnLeft(own)
    , Coding(coder)
    , GhostsLeft(ghosts)
    , TriangleCount(triangles)
    , Gates(GateArray.get())
    , Queue(3 * triangles)
  {
  }

  // Writing: the triangles, of vertices 0 … own - 1 (own) and on (ghosts).
  void SetInput(std::span<const Triangle> triangles, std::size_t own, std::size_t ghosts);

  // False: what is read is no walk.
  bool Run();

  // After Run. In the order of the walk; `input` (writing): the piece's number of each.
  std::span<WalkVertex> Vertices; // all that there may be
  std::uint32_t VertexCount = 0;  // that were found
  std::size_t OwnLeft;            // own vertices that were not found
  std::vector<VertexId> Input;
  // Writing: whether the walk found the piece's vertex.
  bool Has(VertexId input) const { return this->Found[input] != none; }
  // Triangle t has its corners at Gates[4 t + 0 … 2].
  std::array<std::uint32_t, 3> CornersOf(std::size_t triangle) const
  {
    return { this->Gates[4 * triangle].start, this->Gates[4 * triangle + 1].start,
      this->Gates[4 * triangle + 2].start };
  }

private:
  static constexpr std::uint32_t none = noVertex;

  static std::uint32_t Around(std::uint32_t halfEdge)
  {
    return (halfEdge & 3) == 2 ? halfEdge - 2 : halfEdge + 1;
  }
  std::uint32_t EndOf(std::uint32_t halfEdge) const { return this->Gates[Around(halfEdge)].start; }
  std::uint32_t ApexOf(std::uint32_t halfEdge) const
  {
    return this->Gates[Around(Around(halfEdge))].start;
  }
  void Link(std::uint32_t gate, std::uint32_t next)
  {
    this->Gates[gate].next = next;
    this->Gates[next].previous = gate;
  }
  void Open(std::uint32_t gate)
  {
    this->Gates[gate].state = State::Open;
    this->Vertices[this->Gates[gate].start].openGate = gate;
    this->Queue[this->Queued++] = gate;
  }
  // One triangle more at the vertex.
  void Count(std::uint32_t vertex)
  {
    std::uint8_t& degree = this->Vertices[vertex].degree;
    degree = static_cast<std::uint8_t>(degree + (degree < 255));
  }
  bool IsOpen(std::uint32_t gate) const { return this->Gates[gate].state == State::Open; }

  void PairEdges();
  bool Start();
  bool Cross(std::uint32_t gate);
  WalkStep StepAt(std::uint32_t gate) const;
  std::size_t ContextOf(std::uint32_t gate) const;
  bool AddVertex(VertexId input, const std::array<std::uint32_t, 3>& gate);
  std::uint32_t Name(std::size_t context, VertexId input);
  void AddParallelogram(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t x);
  void Glue(std::uint32_t gate, WalkStep step);

  Coder& Coding;
  std::size_t GhostsLeft, TriangleCount, Done = 0, Queued = 0, Crossed = 0;
  Gate* Gates;
  std::vector<std::uint32_t> Queue; // of gates, each once

  // Writing only. Half-edges of the input are numbered like those of the walk, 4 t + k.
  std::span<const Triangle> Triangles;
  std::size_t InputOwn = 0, NextStart = 0;
  std::vector<std::uint32_t> Opposite; // of each half-edge of the input, or none
  std::vector<std::uint32_t>
    InputEdge; // of each triangle of the walk: the input's half-edge of its first
  std::vector<std::uint8_t> TriangleDone; // of the input
  std::vector<std::uint32_t> Found;       // walk number of each vertex of the input, or none

  VertexId InputVertex(std::uint32_t halfEdge) const
  {
    return this->Triangles[halfEdge / 4][halfEdge & 3];
  }
  std::uint32_t InputOf(std::uint32_t halfEdge) const
  {
    const std::uint32_t first = this->InputEdge[halfEdge / 4];
    const std::uint32_t k = (first & 3) + (halfEdge & 3);
    return (first & ~3U) + (k > 2 ? k - 3 : k);
  }
};

constexpr bool IsDegenerate(const std::array<std::uint32_t, 3>& t)
{
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

template <class Coder>
void TriangleWalk<Coder>::SetInput(
  std::span<const Triangle> triangles, std::size_t own, std::size_t ghosts)
{
  this->Triangles = triangles;
  this->InputOwn = own;
  this->TriangleDone.assign(triangles.size(), 0);
  this->InputEdge.assign(triangles.size(), 0);
  this->Found.assign(own + ghosts, none);
  this->PairEdges();
}

// Pairs each half-edge with the first unpaired one that runs the other way, by a hash table of
// those that wait.
template <class Coder>
void TriangleWalk<Coder>::PairEdges()
{
  const std::size_t halfEdges = 4 * this->Triangles.size();
  this->Opposite.assign(halfEdges, none);
  std::size_t size = 16;
  while (size < 2 * halfEdges)
  {
    size *= 2;
  }
  std::vector<std::uint32_t> first(size, none), waiting(halfEdges, none);
  const auto slotOf = [&](VertexId from, VertexId to)
  {
    std::size_t slot =
      ((from * 0x9E3779B97F4A7C15ULL + to) * 0xD6E8FEB86659FD93ULL >> 32) & (size - 1);
    // The head of a list stays in its slot for ever, so that a search may stop at an empty one.
    for (; first[slot] != none; slot = (slot + 1) & (size - 1))
    {
      const std::uint32_t head = first[slot];
      if (this->InputVertex(head) == from && this->InputVertex(Around(head)) == to)
      {
        break;
      }
    }
    return slot;
  };
  // waiting[head] is the list of half-edges like `head` that wait; the list runs in order of
  // number.
  std::vector<std::uint32_t> last(halfEdges, none), next(halfEdges, none);
  for (std::uint32_t edge = 0; edge < halfEdges; ++edge)
  {
    if ((edge & 3) == 3 || IsDegenerate(this->Triangles[edge / 4]))
    {
      continue;
    }
    const VertexId from = this->InputVertex(edge), to = this->InputVertex(Around(edge));
    const std::uint32_t reverse = first[slotOf(to, from)];
    if (reverse != none && waiting[reverse] != none)
    {
      const std::uint32_t other = waiting[reverse];
      waiting[reverse] = next[other];
      this->Opposite[edge] = other;
      this->Opposite[other] = edge;
      continue;
    }
    std::uint32_t& head = first[slotOf(from, to)];
    head = head == none ? edge : head;
    if (waiting[head] == none)
    {
      waiting[head] = edge;
    }
    else
    {
      next[last[head]] = edge;
    }
    last[head] = edge;
  }
}

template <class Coder>
bool TriangleWalk<Coder>::Run()
{
  while (this->Done < this->TriangleCount)
  {
    if (!this->Start())
    {
      return false;
    }
    while (this->Crossed < this->Queued)
    {
      const std::uint32_t gate = this->Queue[this->Crossed++];
      if (this->IsOpen(gate) && !this->Cross(gate))
      {
        return false;
      }
    }
  }
  return true;
}

template <class Coder>
bool TriangleWalk<Coder>::AddVertex(VertexId input, const std::array<std::uint32_t, 3>& gate)
{
  if (this->VertexCount == this->Vertices.size())
  {
    return false;
  }
  WalkVertex& vertex = this->Vertices[this->VertexCount];
  vertex.gate = gate;
  std::size_t context = contexts::isOwn;
  for (std::size_t k = 0; k < 3 && this->VertexCount > 0; ++k)
  {
    context += this->Vertices[gate[k]].own ? std::size_t{ 1 } << k : 0;
  }
  vertex.own = this->Coding.Symbol(context, Coder::reading ? 0 : input < this->InputOwn) != 0;
  std::size_t& left = vertex.own ? this->OwnLeft : this->GhostsLeft;
  if (left == 0)
  {
    return false;
  }
  --left;
  if constexpr (!Coder::reading)
  {
    this->Found[input] = this->VertexCount;
    this->Input.push_back(input);
  }
  ++this->VertexCount;
  return true;
}

// Names a vertex that the walk has found, by how long ago; none if there is no such.
template <class Coder>
std::uint32_t TriangleWalk<Coder>::Name(std::size_t context, VertexId input)
{
  const std::uint32_t count = this->VertexCount;
  std::uint64_t ago = 0;
  if constexpr (!Coder::reading)
  {
    ago = count - 1 - this->Found[input];
  }
  ago = this->Coding.Number(context, ago);
  return ago < count ? static_cast<std::uint32_t>(count - 1 - ago) : none;
}

template <class Coder>
bool TriangleWalk<Coder>::Start()
{
  if constexpr (!Coder::reading)
  {
    while (this->TriangleDone[this->NextStart] != 0)
    {
      ++this->NextStart;
    }
    this->TriangleDone[this->NextStart] = 1;
    this->InputEdge[this->Done] = static_cast<std::uint32_t>(4 * this->NextStart);
  }
  const auto first = static_cast<std::uint32_t>(4 * this->Done);
  for (std::uint32_t k = 0; k < 3; ++k)
  {
    VertexId input = 0;
    if constexpr (!Coder::reading)
    {
      input = this->Triangles[this->NextStart][k];
    }
    const std::uint32_t count = this->VertexCount;
    std::uint32_t& corner = this->Gates[first + k].start;
    bool isNew = false;
    if constexpr (!Coder::reading)
    {
      isNew = this->Found[input] == none;
    }
    if (this->Coding.Symbol(contexts::seedIsNew, isNew) != 0)
    {
      const std::uint32_t before =
        k > 0 ? this->Gates[first + k - 1].start : std::max(count, 1U) - 1;
      if (!this->AddVertex(input, { before, before, before }))
      {
        return false;
      }
      corner = count;
    }
    else
    {
      corner = this->Name(contexts::seedVertex, input);
    }
    if (corner == none)
    {
      return false;
    }
    this->Count(corner);
  }
  if (!IsDegenerate(this->CornersOf(this->Done++)))
  {
    for (std::uint32_t k = 0; k < 3; ++k)
    {
      this->Link(first + k, Around(first + k));
      this->Open(first + k);
    }
  }
  return true;
}

// Writing: what is on the other side of the gate.
template <class Coder>
WalkStep TriangleWalk<Coder>::StepAt(std::uint32_t gate) const
{
  const std::uint32_t opposite = this->Opposite[this->InputOf(gate)];
  if (opposite == none || this->TriangleDone[opposite / 4] != 0)
  {
    return WalkStep::Border;
  }
  const std::uint32_t leaving = Around(opposite), entering = Around(leaving); // a -> x, x -> b
  if (this->Found[this->InputVertex(entering)] == none)
  {
    return WalkStep::New;
  }
  const std::uint32_t next = this->Gates[gate].next, previous = this->Gates[gate].previous;
  const bool byNext = this->IsOpen(next) && this->Opposite[this->InputOf(next)] == entering;
  const bool byPrevious =
    this->IsOpen(previous) && this->Opposite[this->InputOf(previous)] == leaving;
  return byNext ? (byPrevious ? WalkStep::Both : WalkStep::Next)
                : (byPrevious ? WalkStep::Previous : WalkStep::Jump);
}

// By how much is known: gates between ghosts are borders nearly always; where a neighbour is a
// border that step is not possible; the more triangles the gate's end has, the likelier it closes.
template <class Coder>
std::size_t TriangleWalk<Coder>::ContextOf(std::uint32_t gate) const
{
  const Gate& g = this->Gates[gate];
  const std::uint32_t end = this->EndOf(gate);
  const std::size_t borders =
    (this->IsOpen(g.next) ? 0U : 1U) + (this->IsOpen(g.previous) ? 0U : 2U);
  if (!this->Vertices[g.start].own && !this->Vertices[end].own)
  {
    return contexts::step + borders;
  }
  return contexts::step +
         (borders != 0 ? 3 + borders : 7 + std::min<std::size_t>(this->Vertices[end].degree, 8));
}

template <class Coder>
bool TriangleWalk<Coder>::Cross(std::uint32_t gate)
{
  WalkStep step = WalkStep::Border;
  if constexpr (!Coder::reading)
  {
    step = this->StepAt(gate);
  }
  step =
    static_cast<WalkStep>(this->Coding.Symbol(this->ContextOf(gate), static_cast<unsigned>(step)));
  if (step == WalkStep::Border)
  {
    this->Gates[gate].state = State::Border;
    return true;
  }
  if (step > WalkStep::Jump || this->Done == this->TriangleCount)
  {
    return false;
  }
  const std::uint32_t a = this->Gates[gate].start, b = this->EndOf(gate);
  const std::uint32_t next = this->Gates[gate].next, previous = this->Gates[gate].previous;
  const bool byNext = step == WalkStep::Next || step == WalkStep::Both;
  const bool byPrevious = step == WalkStep::Previous || step == WalkStep::Both;
  if ((byNext && !this->IsOpen(next)) || (byPrevious && !this->IsOpen(previous)))
  {
    return false;
  }
  VertexId input = 0;
  if constexpr (!Coder::reading)
  {
    const std::uint32_t opposite = this->Opposite[this->InputOf(gate)];
    this->TriangleDone[opposite / 4] = 1;
    this->InputEdge[this->Done] = opposite;
    input = this->InputVertex(Around(Around(opposite)));
  }
  std::uint32_t x = byNext ? this->EndOf(next) : this->Gates[previous].start;
  if (step == WalkStep::Jump)
  {
    x = this->Name(contexts::jumpVertex, input);
  }
  else if (step == WalkStep::New)
  {
    x = this->VertexCount;
    if (!this->AddVertex(input, { a, b, this->ApexOf(gate) }))
    {
      return false;
    }
  }
  if (x == none)
  {
    return false;
  }
  const std::size_t triangle = this->Done++;
  const std::array<std::uint32_t, 3> corners{ b, a, x };
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->Gates[4 * triangle + k].start = corners[k];
    this->Count(corners[k]);
  }
  this->AddParallelogram(a, b, this->ApexOf(gate), x);
  if (byNext)
  {
    this->AddParallelogram(b, x, this->ApexOf(next), a);
  }
  if (byPrevious)
  {
    this->AddParallelogram(x, a, this->ApexOf(previous), b);
  }
  this->Glue(gate, step);
  return true;
}

// Puts the last triangle's open edges into the gate's loop.
template <class Coder>
void TriangleWalk<Coder>::Glue(std::uint32_t gate, WalkStep step)
{
  const auto leaving = static_cast<std::uint32_t>(4 * (this->Done - 1) + 1), entering = leaving + 1;
  const std::uint32_t next = this->Gates[gate].next, previous = this->Gates[gate].previous;
  this->Gates[gate].state = State::Idle;
  if (step == WalkStep::Both)
  {
    this->Gates[next].state = this->Gates[previous].state = State::Idle;
    this->Link(this->Gates[previous].previous, this->Gates[next].next);
    return;
  }
  if (step == WalkStep::Next)
  {
    this->Gates[next].state = State::Idle;
    this->Link(previous, leaving);
    this->Link(leaving, this->Gates[next].next);
    this->Open(leaving);
    return;
  }
  if (step == WalkStep::Previous)
  {
    this->Gates[previous].state = State::Idle;
    this->Link(this->Gates[previous].previous, entering);
    this->Link(entering, next);
    this->Open(entering);
    return;
  }
  const std::uint32_t x = this->Gates[entering].start;
  const std::uint32_t there = this->Vertices[x].openGate;
  this->Link(previous, leaving);
  if (step == WalkStep::Jump && there != none && this->IsOpen(there))
  {
    // Both loops are open at x: cut them there and join the ends the other way round.
    const std::uint32_t before = this->Gates[there].previous;
    this->Link(leaving, there);
    this->Link(before, entering);
  }
  else
  {
    this->Link(leaving, entering);
  }
  this->Link(entering, next);
  this->Open(leaving);
  this->Open(entering);
}

// Across the edge a b lie c and x: the later of the two is foretold from the other if it is later
// than the edge as well.
template <class Coder>
void TriangleWalk<Coder>::AddParallelogram(
  std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t x)
{
  const std::uint32_t later = std::max(c, x);
  WalkVertex& vertex = this->Vertices[later];
  if (c != x && later > std::max(a, b) && vertex.parallelogramCount < vertex.parallelograms.size())
  {
    vertex.parallelograms[vertex.parallelogramCount++] = { a, b, std::min(c, x) };
  }
}

}
