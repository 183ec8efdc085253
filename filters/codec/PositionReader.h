// SPDX-License-Identifier: BSD-3-Clause
// Reads the differences from which a predictor computes the positions of a piece's vertices.
#pragma once

#include "filters/codec/PieceContexts.h"
#include "filters/codec/PositionPredictor.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TriangleWalk.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace kdstream
{

// Returns false if it is not a mode, or not one of this predictor.
template <class Predictor>
bool ReadPositionMode(SymbolReader& symbols, PositionMode& mode)
{
  const std::uint64_t reach = symbols.Number(contexts::single);
  const std::uint64_t tables = symbols.Number(contexts::single);
  const auto last = Predictor::hasPlanes ? AxisTables::Plane : AxisTables::Each;
  if (reach > mostReach || tables > static_cast<std::uint64_t>(last))
  {
    return false;
  }
  mode = { static_cast<unsigned>(reach), static_cast<AxisTables>(tables) };
  return true;
}

// Reads the differences of all vertices before the first position is predicted, so that reading a
// vertex's symbols does not wait for another vertex's position. Returns false if a difference has
// too many bits.
template <class Predictor>
bool ReadDifferences(SymbolReader& symbols, const PositionMode& mode,
  std::span<const WalkVertex> vertices, typename Predictor::Differences* differences)
{
  std::array<const std::uint32_t*, 6> tables; // three if not guided, three if guided
  for (std::size_t i = 0; i < tables.size(); ++i)
  {
    tables[i] = symbols.TableFor(PositionContext(mode, i > 2, i % 3));
  }
  SymbolCursor cursor = symbols;
  std::uint64_t allBits = 0;
  for (const WalkVertex& vertex : vertices)
  {
    typename Predictor::Differences difference{};
    const std::uint32_t* const* table = tables.data() + 3 * vertex.guided;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::uint64_t number =
        Predictor::differenceBits > 48 ? cursor.NumberUnder(table[k]) : cursor.SmallUnder(table[k]);
      allBits |= number;
      difference[k] =
        static_cast<std::remove_reference_t<decltype(difference[k])>>(Unzigzag(number));
    }
    *differences++ = difference;
  }
  symbols.Continue(cursor);
  return Predictor::differenceBits == 64 || allBits >> (Predictor::differenceBits % 64) == 0;
}

}
