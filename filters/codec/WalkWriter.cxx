// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/WalkWriter.h"

#include "filters/codec/EdgePairs.h"
#include "filters/codec/PieceContexts.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// Writes two steps in a symbol; if their number is odd, 0 comes after the last one.
void WriteSteps(SymbolWriter& symbols, const std::vector<WalkStep>& steps)
{
  for (std::size_t i = 0; i < steps.size(); i += 2)
  {
    const auto first = static_cast<unsigned>(steps[i]);
    const auto second = i + 1 < steps.size() ? static_cast<unsigned>(steps[i + 1]) : 0;
    symbols.Pair(contexts::steps, first * 8 + second);
  }
}

// Finds the steps. For each gate it keeps the half-edge on the gate's other side, which does not
// belong to the gate's triangle. Everything is inlined into WalkWriter::Write: see WalkState.
class StepFinder : public WalkState
{
public:
  StepFinder(const WalkState& start, SymbolWriter& symbols, std::span<const Triangle> triangles,
    const WalkCounts& counts)
    : WalkState(start)
    , Symbols(symbols)
    , Triangles(triangles)
    , Own(counts.own)
    , Pairs(PairEdges(triangles, counts.Vertices()))
    , TriangleDone(triangles.size(), 0)
    , NumberOf(counts.Vertices(), none)
    , Behind(triangles.size() + 2)
  {
  }

  KDSTREAM_IN_LOOPS void Walk()
  {
    for (std::uint32_t t = 0; t < this->Triangles.size(); ++t)
    {
      if (this->TriangleDone[t] == 0)
      {
        this->WriteStart(t);
        while (this->TakeGate())
        {
          this->BehindHere = this->Behind[this->here];
          this->CrossUntilEnd();
        }
      }
    }
    this->AddIsolatedVertices();
    for (VertexId v = 0; v < this->NumberOf.size(); ++v)
    {
      if (this->NumberOf[v] == none)
      {
        this->PieceNumbers.push_back(v);
      }
    }
  }

  std::vector<WalkStep> Steps;
  std::vector<VertexId> PieceNumbers; // of each vertex of the walk

private:
  // Writes a first triangle. For each corner: 0 if it is known, and its number; 1 if it is a new
  // own vertex; 2 if it is a new ghost.
  KDSTREAM_IN_LOOPS void WriteStart(std::uint32_t triangle)
  {
    this->TriangleDone[triangle] = 1;
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId vertex = this->Triangles[triangle][k];
      corners[k] = this->NumberOf[vertex];
      if (corners[k] != none)
      {
        this->Symbols.Choice(contexts::seed, 0);
        this->WriteKnownVertex(contexts::seedVertex, corners[k]);
        continue;
      }
      const std::uint32_t before = k > 0 ? corners[k - 1] : std::max(this->vertexCount, 1U) - 1;
      const bool own = vertex < this->Own;
      this->Symbols.Choice(contexts::seed, own ? 1 : 2);
      corners[k] = this->NoteNewVertex(vertex);
      (void)this->AddVertex({ before, before, before }, own, false);
    }
    this->StartLoop(corners);
    for (std::uint32_t k = 0; k < 3; ++k)
    {
      this->Behind[k] = this->Pairs[4 * triangle + k];
    }
  }

  // Writes a known vertex, as the number of vertices found after it.
  KDSTREAM_IN_LOOPS void WriteKnownVertex(std::size_t context, std::uint32_t number)
  {
    this->Symbols.Number(context, this->vertexCount - 1 - number);
  }

  // Crosses the current gate, and goes on crossing gates until the walk cannot go on.
  KDSTREAM_IN_LOOPS void CrossUntilEnd()
  {
    while (true)
    {
      const WalkStep step = this->FindStep();
      this->Steps.push_back(step);
      if (step == WalkStep::Border)
      {
        this->EndAtBorder();
        return;
      }
      this->TriangleDone[this->BehindHere / 4] = 1;
      // The triangle's edges a -> x and x -> b, and the half-edges on their other sides.
      const std::uint32_t leaving = NextHalfEdge(this->BehindHere);
      const std::uint32_t entering = NextHalfEdge(leaving);
      this->Cross(step, StartOfHalfEdge(this->Triangles, entering));
      if (step == WalkStep::Both)
      {
        return;
      }
      // The edge that remains: for Next a -> x, for Previous x -> b. For other steps both remain,
      // and a -> x was put on the stack.
      this->BehindHere = this->Pairs[step == WalkStep::Next ? leaving : entering];
      if (step != WalkStep::Next && step != WalkStep::Previous)
      {
        this->Behind[this->stacked - 1] = this->Pairs[leaving];
      }
    }
  }

  // The step that describes the other side of the gate.
  KDSTREAM_IN_LOOPS WalkStep FindStep() const
  {
    if (this->BehindHere == none || this->TriangleDone[this->BehindHere / 4] != 0)
    {
      return WalkStep::Border;
    }
    const std::uint32_t leaving = NextHalfEdge(this->BehindHere);
    const std::uint32_t entering = NextHalfEdge(leaving);
    const VertexId x = StartOfHalfEdge(this->Triangles, entering);
    if (this->NumberOf[x] == none)
    {
      return x < this->Own ? WalkStep::NewOwn : WalkStep::NewGhost;
    }
    const bool byNext = this->next != this->here && this->Behind[this->next] == entering;
    const bool byPrevious = this->previous != this->here && this->Behind[this->previous] == leaving;
    return byNext ? (byPrevious ? WalkStep::Both : WalkStep::Next)
                  : (byPrevious ? WalkStep::Previous : WalkStep::Jump);
  }

  // Makes the step. vertex: the number in the piece of the new triangle's third corner. Cannot
  // fail, because FindStep found the step.
  KDSTREAM_IN_LOOPS void Cross(WalkStep step, VertexId vertex)
  {
    switch (step)
    {
      case WalkStep::NewOwn:
      case WalkStep::NewGhost:
        this->NoteNewVertex(vertex);
        (void)this->CrossToNew(step == WalkStep::NewOwn);
        break;
      case WalkStep::Next:
        (void)this->CrossToNext();
        break;
      case WalkStep::Previous:
        (void)this->CrossToPrevious();
        break;
      case WalkStep::Both:
        (void)this->CrossToBoth();
        break;
      default:
        this->WriteKnownVertex(contexts::jumpVertex, this->NumberOf[vertex]);
        (void)this->CrossToKnown(this->NumberOf[vertex]);
    }
  }

  // Gives a vertex of the piece the next number in the walk, and returns it.
  KDSTREAM_IN_LOOPS std::uint32_t NoteNewVertex(VertexId vertex)
  {
    this->PieceNumbers.push_back(vertex);
    return this->NumberOf[vertex] = this->vertexCount;
  }

  SymbolWriter& Symbols;
  std::span<const Triangle> Triangles;
  std::size_t Own;
  std::vector<std::uint32_t> Pairs;       // of each half-edge (EdgePairs.h)
  std::vector<std::uint8_t> TriangleDone; // of the piece
  std::vector<std::uint32_t> NumberOf;    // in the walk, of each vertex of the piece; or none
  std::vector<std::uint32_t> Behind; // of each stacked gate: half-edge on its other side, or none
  std::uint32_t BehindHere = none;   // the same for the current gate
};

}

void WalkWriter::Write(SymbolWriter& symbols)
{
  StepFinder walk(WalkState(this->Arrays, this->Counts), symbols, this->Triangles, this->Counts);
  walk.Walk();
  WriteSteps(symbols, walk.Steps);
  this->Steps = walk.Steps.size();
  this->PieceNumbers = std::move(walk.PieceNumbers);
}

}
