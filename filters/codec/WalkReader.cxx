// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/WalkReader.h"

#include "filters/codec/PieceContexts.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kdstream
{
namespace
{

// Reads all steps, and appends WalkStep::None. A symbol has two steps; if the number of steps is
// odd, 0 comes after the last one. Returns an empty list if it does not.
std::vector<WalkStep> ReadSteps(SymbolReader& symbols, std::size_t count)
{
  std::vector<WalkStep> steps(count + 2);
  SymbolCursor cursor = symbols;
  for (std::size_t i = 0; i < count; i += 2)
  {
    const unsigned pair = cursor.Pair(contexts::steps);
    steps[i] = static_cast<WalkStep>(pair / 8);
    steps[i + 1] = static_cast<WalkStep>(pair % 8);
  }
  symbols.Continue(cursor);
  if (count % 2 == 1 && steps[count] != WalkStep{})
  {
    return {};
  }
  steps[count] = WalkStep::None;
  return steps;
}

// The loop over the steps. Everything that changes in it is a member, and everything is inlined
// into WalkReader::Read: see WalkState.
class WalkFollower : public WalkState
{
public:
  WalkFollower(const WalkState& start, const SymbolCursor& symbols, const WalkStep* firstStep,
    std::span<Triangle> triangles)
    : WalkState(start)
    , Symbols(symbols)
    , Step(firstStep)
    , Done(triangles.data())
    , End(triangles.data() + triangles.size())
  {
  }

  // Returns false if this is not a walk.
  KDSTREAM_IN_LOOPS bool Follow()
  {
    while (this->Done != this->End)
    {
      if (!this->ReadStart())
      {
        return false;
      }
      while (this->TakeGate())
      {
        if (!this->CrossUntilEnd())
        {
          return false;
        }
      }
    }
    return *this->Step == WalkStep::None;
  }
  const SymbolCursor& Position() const { return this->Symbols; }

private:
  // Reads a first triangle, anywhere.
  KDSTREAM_IN_LOOPS bool ReadStart()
  {
    Corners corners{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const unsigned kind = this->Symbols.Choice(contexts::seed);
      if (kind == 0)
      {
        corners[k] = this->ReadKnownVertex(contexts::seedVertex);
        if (corners[k] == none)
        {
          return false;
        }
        continue;
      }
      const std::uint32_t before = k > 0 ? corners[k - 1] : std::max(this->vertexCount, 1U) - 1;
      corners[k] = this->vertexCount;
      if (kind > 2 || !this->AddVertex({ before, before, before }, kind == 1, false))
      {
        return false;
      }
    }
    *this->Done++ = corners;
    this->StartLoop(corners);
    return true;
  }

  // Reads a known vertex, given by the number of vertices found after it. Returns `none` if it does
  // not exist.
  KDSTREAM_IN_LOOPS std::uint32_t ReadKnownVertex(std::size_t context)
  {
    const std::uint64_t since = this->Symbols.Small(context);
    return since < this->vertexCount ? static_cast<std::uint32_t>(this->vertexCount - 1 - since)
                                     : none;
  }

  // Crosses the current gate, and goes on crossing gates until the walk cannot go on.
  KDSTREAM_IN_LOOPS bool CrossUntilEnd()
  {
    while (true)
    {
      const WalkStep step = *this->Step++;
      if (step == WalkStep::Border)
      {
        this->EndAtBorder();
        return true;
      }
      if (this->Done == this->End)
      {
        return false;
      }
      Triangle& triangle = *this->Done++;
      triangle[0] = this->b;
      triangle[1] = this->a;
      const std::uint32_t x = this->Cross(step);
      if (x == none)
      {
        return false;
      }
      triangle[2] = x;
      if (step == WalkStep::Both)
      {
        return true;
      }
    }
  }

  // Returns the new triangle's third corner, or `none` if the step is not possible.
  KDSTREAM_IN_LOOPS std::uint32_t Cross(WalkStep step)
  {
    switch (step)
    {
      case WalkStep::NewOwn:
        return this->CrossToNew(true);
      case WalkStep::NewGhost:
        return this->CrossToNew(false);
      case WalkStep::Next:
        return this->CrossToNext();
      case WalkStep::Previous:
        return this->CrossToPrevious();
      case WalkStep::Both:
        return this->CrossToBoth();
      case WalkStep::Jump:
      {
        const std::uint32_t x = this->ReadKnownVertex(contexts::jumpVertex);
        return x == none ? none : this->CrossToKnown(x);
      }
      default:
        return none;
    }
  }

  SymbolCursor Symbols;
  const WalkStep* Step; // the next one
  Triangle *Done, *End; // end of the triangles done so far, end of all
};

}

bool WalkReader::Read(SymbolReader& symbols, std::size_t stepCount)
{
  const std::vector<WalkStep> steps = ReadSteps(symbols, stepCount);
  if (steps.empty())
  {
    return false;
  }
  WalkFollower walk(WalkState(this->Arrays, this->Counts), symbols, steps.data(),
    { this->TriangleArray.get(), this->Counts.triangles });
  const bool good = walk.Follow();
  symbols.Continue(walk.Position());
  walk.AddIsolatedVertices();
  return good;
}

}
