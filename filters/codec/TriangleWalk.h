// The order in which a piece's triangles and vertices are coded: a walk over the surface.
//
// The walk starts at a triangle and crosses its edges. An edge that waits to be crossed is a
// *gate*: a half-edge a -> b of a triangle that is done, which lies across from its *apex*. Gates
// lie in closed loops, the boundary of what is done. Crossing finds the triangle (b, a, x) on the
// other side and says by one symbol what x is: new, or the far end of the next or previous gate, or
// a vertex named by number; or that nothing is there. The walk goes on at one of the triangle's
// edges; where it ends, at the gate that waits for the shortest time; where none waits, a new walk
// starts. So it spirals, and what it works on is what it had in hand a moment ago.
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
#include "filters/codec/SymbolCoder.h"
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
  NewOwn = 1,   // x is a new vertex of the piece's own
  Next = 2,     // x is the end of the next gate, which is crossed too
  Previous = 3, // x is the start of the previous gate, which is crossed too
  Both = 4,     // both
  Jump = 5,     // x is named
  NewGhost = 6, // x is a new ghost
  None = 7      // behind the last step that was read
};

// A vertex of the walk, by its number in it.
struct WalkVertex
{
  // The gate's vertices a and b at which it was found, and the gate's apex. In a first triangle
  // three times the corner before, or the vertex before; of vertex 0, 0.
  std::array<std::uint32_t, 3> gate;
  // Another such triangle that faces the vertex, of vertices before it; or the same.
  std::array<std::uint32_t, 3> second;
  std::uint32_t own;    // 1, or 0: a ghost
  std::uint32_t guided; // 1: found at a gate, so that a parallelogram says where it should be; or 0

  void Start(const std::array<std::uint32_t, 3>& foundAt, bool isOwn, bool isGuided)
  {
    this->gate = foundAt;
    this->second = foundAt;
    this->own = isOwn;
    this->guided = isGuided;
  }
};

constexpr bool IsDegenerate(const std::array<std::uint32_t, 3>& t)
{
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// Pairs each half-edge, in the order of their numbers, with the first unpaired one that runs the
// other way: that one's number for each, or noVertex. A half-edge of triangle t is number 4 t + k.
// Degenerate triangles have no pairs. O(size).
std::vector<std::uint32_t> PairEdges(std::span<const Triangle> triangles, std::size_t vertices);

// Both directions of the walk. Writing needs the piece's triangles; reading makes them.
template <class Coder>
class TriangleWalk
{
private:
  using Corners = std::array<std::uint32_t, 3>;
  // A gate that waits, by its number. Where the apex is none it waits no more, and is in no loop.
  struct Gate
  {
    std::uint32_t start, end, apex, next, previous;
    std::uint32_t across; // writing: the input's half-edge on the other side, or none
  };
  // What changes at every step: a copy of its own in the loop, which compilers keep at hand.
  struct Progress
  {
    typename Coder::Cursor coder;
    Gate* gates; // a stack; below `waiting` are those that may wait
    WalkVertex* vertices;
    Triangle* triangles;       // reading: those that are done
    std::uint32_t* gateFrom;   // of each vertex: the gate that starts there and was stacked last
    std::uint32_t left[2];     // ghosts and own vertices that were not found
    std::uint32_t noVertexAt;  // behind the last that may be
    const std::uint8_t* steps; // reading: those that are left
    std::size_t triangleCount;
    std::size_t done = 0;
    std::uint32_t vertexCount = 0, waiting = 0;
    // The gate that is crossed: its number, which its neighbours know it by, and what it holds.
    std::uint32_t here = 0, a = 0, b = 0, apex = 0, next = 0, previous = 0, across = 0;
  };
  // No vectors: less code in the page, and nothing is set that will be.
  std::unique_ptr<WalkVertex[]> VertexArray;
  std::unique_ptr<Gate[]> GateArray;
  std::unique_ptr<std::uint32_t[]> GateFromArray;
  std::unique_ptr<Triangle[]> TriangleArray;

public:
  // own + ghosts: the most vertices that a reader makes. steps: reading, how many there are.
  TriangleWalk(
    Coder& coder, std::size_t own, std::size_t ghosts, std::size_t triangles, std::size_t steps)
    : VertexArray(new WalkVertex[own + ghosts + 1])
    , GateArray(new Gate[triangles + 2]) // three at a start, one more at a triangle behind it
    , GateFromArray(new std::uint32_t[own + ghosts])
    , TriangleArray(new Triangle[Coder::reading ? triangles : 0])
    , Steps(steps)
    , Vertices(VertexArray.get(), own + ghosts)
    , OwnLeft(own)
    , Coding(coder)
    , TriangleCount(triangles)
  {
  }

  // Writing: the triangles, of vertices 0 … own - 1 (own) and on (ghosts).
  void SetInput(std::span<const Triangle> triangles, std::size_t own, std::size_t ghosts)
  {
    this->Triangles = triangles;
    this->InputOwn = own;
    this->TriangleDone.assign(triangles.size(), 0);
    this->Found.assign(own + ghosts, none);
    this->Opposite = PairEdges(triangles, own + ghosts);
  }

  // False: what is read is no walk.
  bool Run();

  // Reading, before Run; writing, after it: all steps at once. False: as Run.
  bool CodeSteps(Coder& coder);
  std::vector<std::uint8_t> Steps; // a reader has None behind them

  // After Run. In the order of the walk; `input` (writing): the piece's number of each.
  std::span<WalkVertex> Vertices; // all that there may be
  std::uint32_t VertexCount = 0;  // that were found
  std::size_t OwnLeft;            // own vertices that were not found
  std::vector<VertexId> Input;
  // Writing: whether the walk found the piece's vertex.
  bool Has(VertexId input) const { return this->Found[input] != none; }
  // Reading: triangle t, in the walk's numbers.
  const Triangle& CornersOf(std::size_t triangle) const { return this->TriangleArray[triangle]; }

private:
  static constexpr std::uint32_t none = noVertex;

  static std::uint32_t Around(std::uint32_t halfEdge)
  {
    return (halfEdge & 3) == 2 ? halfEdge - 2 : halfEdge + 1;
  }
  static void Link(Progress& now, std::uint32_t gate, std::uint32_t next)
  {
    now.gates[gate].next = next;
    now.gates[next].previous = gate;
  }
  // Its number.
  static std::uint32_t Stack(Progress& now, const Gate& gate)
  {
    const std::uint32_t number = now.waiting++;
    now.gates[number] = gate;
    now.gateFrom[gate.start] = number;
    return number;
  }
  static bool Take(Progress& now);
  static void AddTriangle(Progress& now, const Corners& corners)
  {
    if constexpr (Coder::reading)
    {
      now.triangles[now.done] = corners;
    }
    ++now.done;
  }
  static bool AddVertex(Progress& now, const Corners& gate, bool own, bool guided);
  static std::uint32_t Insert(Progress& now, std::uint32_t x);
  static bool CrossToNew(Progress& now, bool own);
  static bool CrossToNext(Progress& now);
  static bool CrossToPrevious(Progress& now);
  static bool CrossToBoth(Progress& now);
  bool CrossToNamed(Progress& now, VertexId input) const;
  static void GuideByNext(Progress& now, const Gate& next);

  bool Start(Progress& now);
  bool Cross(Progress& now);
  std::uint32_t Name(Progress& now, std::size_t context, VertexId input) const;

  // Writing: what is on the other side of the gate; and that the walk has found a vertex, a
  // triangle.
  WalkStep StepAt(const Progress& now) const;
  void NoteVertex(VertexId input);
  VertexId NoteStep(const Progress& now, WalkStep step);
  // Writing: behind the half-edge that follows by so many the one across the gate.
  std::uint32_t AcrossFrom(const Progress& now, unsigned edges) const
  {
    if constexpr (Coder::reading)
    {
      return none;
    }
    else
    {
      const std::uint32_t first = Around(now.across);
      return this->Opposite[edges == 1 ? first : Around(first)];
    }
  }

  Coder& Coding;
  std::size_t TriangleCount;

  // Writing only. Half-edges of the input are numbered 4 t + k.
  std::span<const Triangle> Triangles;
  std::size_t InputOwn = 0, NextStart = 0;
  std::vector<std::uint32_t> Opposite;    // of each half-edge of the input, or none
  std::vector<std::uint8_t> TriangleDone; // of the input
  std::vector<std::uint32_t> Found;       // walk number of each vertex of the input, or none

  VertexId InputVertex(std::uint32_t halfEdge) const
  {
    return this->Triangles[halfEdge / 4][halfEdge & 3];
  }
};

template <class Coder>
bool TriangleWalk<Coder>::Run()
{
  Progress now{ this->Coding, this->GateArray.get(), this->VertexArray.get(),
    this->TriangleArray.get(), this->GateFromArray.get(),
    { static_cast<std::uint32_t>(this->Vertices.size() - this->OwnLeft),
      static_cast<std::uint32_t>(this->OwnLeft) },
    static_cast<std::uint32_t>(this->Vertices.size()), this->Steps.data(), this->TriangleCount };
  bool good = true;
  while (good && now.done < now.triangleCount)
  {
    good = this->Start(now);
    while (good && Take(now))
    {
      good = this->Cross(now);
    }
  }
  this->Coding.Continue(now.coder);
  this->VertexCount = now.vertexCount;
  this->OwnLeft = now.left[1];
  return good && (!Coder::reading || static_cast<WalkStep>(*now.steps) == WalkStep::None);
}

// Two to a symbol; behind an odd one comes 0.
template <class Coder>
bool TriangleWalk<Coder>::CodeSteps(Coder& coder)
{
  const std::size_t count = this->Steps.size();
  this->Steps.resize(count + 2);
  std::uint8_t* steps = this->Steps.data();
  typename Coder::Cursor cursor = coder;
  for (std::size_t i = 0; i < count; i += 2)
  {
    const unsigned pair = cursor.Pair(contexts::steps, steps[i] * 8U + steps[i + 1]);
    if constexpr (Coder::reading)
    {
      steps[i] = static_cast<std::uint8_t>(pair / 8);
      steps[i + 1] = pair % 8;
    }
  }
  coder.Continue(cursor);
  const bool good = count % 2 == 0 || steps[count] == 0;
  if constexpr (Coder::reading)
  {
    steps[count] = static_cast<std::uint8_t>(WalkStep::None);
  }
  else
  {
    this->Steps.resize(count);
  }
  return good;
}

// The gate that was stacked last of those that wait, as the one to cross. False: none waits.
template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::Take(Progress& now)
{
  while (now.waiting > 0)
  {
    Gate& gate = now.gates[now.waiting - 1];
    if (gate.apex != none)
    {
      now.here = now.waiting - 1; // which stays: its neighbours name it
      now.a = gate.start;
      now.b = gate.end;
      now.apex = gate.apex;
      now.next = gate.next;
      now.previous = gate.previous;
      now.across = gate.across;
      gate.apex = none;
      return true;
    }
    --now.waiting;
  }
  return false;
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::AddVertex(
  Progress& now, const Corners& gate, bool own, bool guided)
{
  if (now.left[own ? 1 : 0] == 0)
  {
    return false;
  }
  --now.left[own ? 1 : 0];
  now.gateFrom[now.vertexCount] = 0;
  now.vertices[now.vertexCount++].Start(gate, own, guided);
  return true;
}

template <class Coder>
void TriangleWalk<Coder>::NoteVertex(VertexId input)
{
  this->Found[input] = static_cast<std::uint32_t>(this->Input.size());
  this->Input.push_back(input);
}

template <class Coder>
VertexId TriangleWalk<Coder>::NoteStep(const Progress& now, WalkStep step)
{
  const VertexId x = this->InputVertex(Around(Around(now.across)));
  this->TriangleDone[now.across / 4] = 1;
  if (step == WalkStep::NewOwn || step == WalkStep::NewGhost)
  {
    this->NoteVertex(x);
  }
  return x;
}

// Names a vertex that the walk has found, by how long ago; none if there is no such.
template <class Coder>
KDSTREAM_IN_LOOPS std::uint32_t TriangleWalk<Coder>::Name(
  Progress& now, std::size_t context, VertexId input) const
{
  const std::uint32_t count = now.vertexCount;
  std::uint64_t ago = 0;
  if constexpr (!Coder::reading)
  {
    ago = count - 1 - this->Found[input];
  }
  ago = now.coder.Small(context, ago);
  return ago < count ? static_cast<std::uint32_t>(count - 1 - ago) : none;
}

// The corners of a first triangle: 0, known; 1, new and own; 2, a new ghost.
template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::Start(Progress& now)
{
  if constexpr (!Coder::reading)
  {
    while (this->TriangleDone[this->NextStart] != 0)
    {
      ++this->NextStart;
    }
    this->TriangleDone[this->NextStart] = 1;
  }
  Corners corners{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    VertexId input = 0;
    unsigned kind = 0;
    if constexpr (!Coder::reading)
    {
      input = this->Triangles[this->NextStart][k];
      kind = this->Found[input] != none ? 0 : (input < this->InputOwn ? 1 : 2);
    }
    kind = now.coder.Choice(contexts::seed, kind);
    if (kind == 0)
    {
      corners[k] = this->Name(now, contexts::seedVertex, input);
      if (corners[k] == none)
      {
        return false;
      }
      continue;
    }
    const std::uint32_t before = k > 0 ? corners[k - 1] : std::max(now.vertexCount, 1U) - 1;
    corners[k] = now.vertexCount;
    if (kind > 2 || !AddVertex(now, { before, before, before }, kind == 1, false))
    {
      return false;
    }
    if constexpr (!Coder::reading)
    {
      this->NoteVertex(input);
    }
  }
  AddTriangle(now, corners);
  for (std::uint32_t k = 0; k < 3 && !IsDegenerate(corners); ++k)
  {
    std::uint32_t across = none;
    if constexpr (!Coder::reading)
    {
      across = this->Opposite[4 * this->NextStart + k];
    }
    const std::uint32_t after = k == 2 ? 0 : k + 1, before = k == 0 ? 2 : k - 1;
    Stack(now, { corners[k], corners[after], corners[before], after, before, across });
  }
  return true;
}

// Writing: what is on the other side of the gate.
template <class Coder>
WalkStep TriangleWalk<Coder>::StepAt(const Progress& now) const
{
  const std::uint32_t opposite = now.across;
  if (opposite == none || this->TriangleDone[opposite / 4] != 0)
  {
    return WalkStep::Border;
  }
  const std::uint32_t leaving = Around(opposite), entering = Around(leaving); // a -> x, x -> b
  const VertexId x = this->InputVertex(entering);
  if (this->Found[x] == none)
  {
    return x < this->InputOwn ? WalkStep::NewOwn : WalkStep::NewGhost;
  }
  const bool byNext = now.next != now.here && now.gates[now.next].across == entering;
  const bool byPrevious = now.previous != now.here && now.gates[now.previous].across == leaving;
  return byNext ? (byPrevious ? WalkStep::Both : WalkStep::Next)
                : (byPrevious ? WalkStep::Previous : WalkStep::Jump);
}

// Crosses the gate, and those where the walk goes on, until it ends.
template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::Cross(Progress& now)
{
  bool good = true;
  while (good)
  {
    WalkStep step = WalkStep::Border;
    VertexId input = 0;
    if constexpr (Coder::reading)
    {
      step = static_cast<WalkStep>(*now.steps++);
    }
    else
    {
      step = this->StepAt(now);
      this->Steps.push_back(static_cast<std::uint8_t>(step));
      input = step == WalkStep::Border ? 0 : this->NoteStep(now, step);
    }
    if (step == WalkStep::Border)
    {
      Link(now, now.previous, now.next);
      return true;
    }
    if (now.done == now.triangleCount)
    {
      return false;
    }
    const std::uint32_t leaving = Coder::reading ? none : this->AcrossFrom(now, 1);
    const std::uint32_t entering = Coder::reading ? none : this->AcrossFrom(now, 2);
    switch (step)
    {
      case WalkStep::NewOwn:
        good = CrossToNew(now, true);
        break;
      case WalkStep::Next:
        good = CrossToNext(now);
        break;
      case WalkStep::Previous:
        good = CrossToPrevious(now);
        break;
      case WalkStep::Both:
        return CrossToBoth(now);
      case WalkStep::Jump:
        good = this->CrossToNamed(now, input);
        break;
      case WalkStep::NewGhost:
        good = CrossToNew(now, false);
        break;
      default:
        return false;
    }
    if constexpr (!Coder::reading)
    {
      now.across = step == WalkStep::Next ? leaving : entering;
      if (step != WalkStep::Next && step != WalkStep::Previous)
      {
        now.gates[now.waiting - 1].across = leaving;
      }
    }
  }
  return false;
}

// The triangle's edge a -> x waits; the gate that is crossed is x -> b from now on, behind it.
template <class Coder>
KDSTREAM_IN_LOOPS std::uint32_t TriangleWalk<Coder>::Insert(Progress& now, std::uint32_t x)
{
  const std::uint32_t leaving = Stack(now, { now.a, x, now.b, now.here, now.previous, none });
  now.gates[now.previous].next = leaving;
  now.next = now.next == now.here ? leaving : now.next; // the gate was alone in its loop
  now.previous = leaving;
  now.apex = now.a;
  now.a = x;
  return leaving;
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::CrossToNew(Progress& now, bool own)
{
  const std::uint32_t x = now.vertexCount;
  if (!AddVertex(now, { now.a, now.b, now.apex }, own, true))
  {
    return false;
  }
  AddTriangle(now, { now.b, now.a, x });
  (void)Insert(now, x);
  return true;
}

// Behind the next gate, b -> x, lies its apex: that foretells a, if a is the last of the four. What
// is not to be is written to a vertex that is none: that is faster than a branch that is hard to
// foretell.
template <class Coder>
KDSTREAM_IN_LOOPS void TriangleWalk<Coder>::GuideByNext(Progress& now, const Gate& next)
{
  const bool guides = now.a > std::max(std::max(now.b, next.end), next.apex);
  now.vertices[guides ? now.a : now.noVertexAt].second = { now.b, next.end, next.apex };
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::CrossToNext(Progress& now)
{
  if (now.next == now.here)
  {
    return false;
  }
  Gate& next = now.gates[now.next];
  AddTriangle(now, { now.b, now.a, next.end });
  GuideByNext(now, next);
  next.apex = none;
  now.apex = now.b;
  now.b = next.end;
  now.next = next.next;
  now.gates[now.next].previous = now.here;
  now.previous = now.next == now.here ? now.here : now.previous;
  return true;
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::CrossToPrevious(Progress& now)
{
  if (now.previous == now.here)
  {
    return false;
  }
  Gate& previous = now.gates[now.previous];
  AddTriangle(now, { now.b, now.a, previous.start });
  previous.apex = none;
  now.apex = now.a;
  now.a = previous.start;
  now.previous = previous.previous;
  now.gates[now.previous].next = now.here;
  now.next = now.previous == now.here ? now.here : now.next;
  return true;
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::CrossToBoth(Progress& now)
{
  Gate &next = now.gates[now.next], &previous = now.gates[now.previous];
  if (now.next == now.here || now.next == now.previous || next.end != previous.start)
  {
    return false;
  }
  AddTriangle(now, { now.b, now.a, next.end });
  GuideByNext(now, next);
  next.apex = none;
  previous.apex = none;
  Link(now, previous.previous, next.next);
  return true;
}

template <class Coder>
KDSTREAM_IN_LOOPS bool TriangleWalk<Coder>::CrossToNamed(Progress& now, VertexId input) const
{
  const std::uint32_t x = this->Name(now, contexts::jumpVertex, input);
  if (x == none)
  {
    return false;
  }
  AddTriangle(now, { now.b, now.a, x });
  const std::uint32_t there = now.gateFrom[x];
  const bool waits = now.gates[there].apex != none && now.gates[there].start == x;
  const std::uint32_t leaving = Insert(now, x);
  if (waits)
  {
    // Both loops are at x: cut them there and join the ends the other way round.
    const std::uint32_t before = now.gates[there].previous;
    Link(now, leaving, there);
    now.gates[before].next = now.here;
    now.next = before == now.here ? now.here : now.next; // nothing was between
    now.previous = before;
  }
  return true;
}

}
