// SPDX-License-Identifier: BSD-3-Clause
// Writes and reads the corners of a texture tile's triangles as symbols. TileCornerMemory is the
// state that writer and reader have in common. Layout: doc/formats.md, "Textures".
//
// Triangles come in the piece's order, so most corners are at a vertex of an earlier triangle. Then
// a choice selects one of the two coordinate pairs last stored at that vertex. A new pair is stored
// as the difference from a prediction: a parallelogram with a neighbour, or another corner.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

struct TileContext
{
  enum Choices : std::size_t
  {
    corner = 0,   // which of the vertex's pairs; a context for each corner number
    sameChart = 3 // of which triangle the chart is
  };
  enum Numbers : std::size_t
  {
    parallelogram = 4, // two: x and y
    near = 6,
    far = 8,
    chart = 10,
    table,
    chartSource,
    chartPlace
  };
  static constexpr SymbolContexts all{ 4, chartPlace + 1 };
};

// The stored pair of a corner: in steps of a texel, or, in an exact tile, the ordered bits of u and
// v.
using TileCorner = std::array<std::int64_t, 2>;

// The corners that were stored so far, in the same state for writer and reader.
class TileCornerMemory
{
public:
  static constexpr unsigned newPair = 2, newChart = 3;

  TileCornerMemory(std::span<const Triangle> triangles, bool exact)
    : Triangles(triangles)
    , Exact(exact)
    , Coded(triangles.size())
    , ChartOf(exact ? triangles.size() : 0)
  {
    VertexId vertices = 0;
    for (const Triangle& t : triangles)
    {
      vertices = std::max({ vertices, t[0] + 1, t[1] + 1, t[2] + 1 });
    }
    this->Recent.resize(vertices);
    this->LastAt.assign(vertices, noTriangle);
  }

  // Remembers triangle t, which has been stored, for later ones. If it has a vertex twice, keeps
  // the pair of the last corner there.
  void Remember(std::size_t t)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId vertex = this->Triangles[t][k];
      Pairs& recent = this->Recent[vertex];
      const TileCorner& corner = this->Coded[t][k];
      if (recent.count == 0 || recent.pairs[0] != corner)
      {
        recent.pairs[1] = recent.pairs[0];
        recent.pairs[0] = corner;
        recent.count = std::min(recent.count + 1, 2U);
      }
      this->LastAt[vertex] = static_cast<std::uint32_t>(t);
    }
    this->Last = this->Coded[t][2];
  }

protected:
  static constexpr std::uint32_t noTriangle = noVertex;

  struct Pairs
  {
    TileCorner pairs[2] = {}; // the newest first
    unsigned count = 0;
  };
  struct Prediction
  {
    TileContext::Numbers context;
    TileCorner value;
  };

  // The pair that a symbol stands for, or null.
  const TileCorner* PairOf(VertexId vertex, unsigned symbol) const
  {
    const Pairs& recent = this->Recent[vertex];
    return symbol < recent.count ? &recent.pairs[symbol] : nullptr;
  }
  unsigned SymbolOf(VertexId vertex, const TileCorner& corner) const
  {
    for (unsigned symbol = 0; symbol < newPair; ++symbol)
    {
      const TileCorner* const pair = this->PairOf(vertex, symbol);
      if (pair && *pair == corner)
      {
        return symbol;
      }
    }
    return newPair;
  }

  // Predicts the new pair of corner k. known: which corners of the triangle are already stored.
  Prediction Predict(std::size_t t, std::size_t k, const std::array<bool, 3>& known) const
  {
    const std::size_t next = (k + 1) % 3, previous = (k + 2) % 3;
    const std::array<TileCorner, 3>& here = this->Coded[t];
    if (known[next] && known[previous])
    {
      for (const std::size_t at : { next, previous })
      {
        const std::uint32_t other = this->LastAt[this->Triangles[t][at]];
        if (const TileCorner* opposite = this->Across(t, next, previous, other))
        {
          return { TileContext::parallelogram,
            { this->Close(here[next][0], here[previous][0], (*opposite)[0]),
              this->Close(here[next][1], here[previous][1], (*opposite)[1]) } };
        }
      }
    }
    if (known[next] || known[previous])
    {
      return { TileContext::near, here[known[previous] ? previous : next] };
    }
    return { TileContext::far, this->Last };
  }

  // The chart of the triangle that was stored last at the vertex of corner `symbol` of t; noVertex
  // if there is none.
  std::uint32_t ChartAt(std::size_t t, unsigned symbol) const
  {
    const std::uint32_t other = this->LastAt[this->Triangles[t][symbol]];
    return other == noTriangle ? noVertex : this->ChartOf[other];
  }

  // A sum modulo 2^64, because values from a malformed blob can be anything.
  static std::int64_t Sum(std::int64_t a, std::int64_t b)
  {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
  }
  static std::int64_t Difference(std::int64_t a, std::int64_t b)
  {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
  }

  std::span<const Triangle> Triangles;
  bool Exact;
  std::vector<std::array<TileCorner, 3>> Coded;
  std::vector<std::uint32_t> ChartOf;
  std::uint32_t LastChart = 0;

private:
  // The third corner of the triangle that has the corners `next` and `previous` of t with the same
  // pairs; null if there is none.
  const TileCorner* Across(
    std::size_t t, std::size_t next, std::size_t previous, std::uint32_t other) const
  {
    if (other == noTriangle)
    {
      return nullptr;
    }
    const Triangle& mine = this->Triangles[t];
    const Triangle& theirs = this->Triangles[other];
    for (std::size_t k = 0; k < 3; ++k)
    {
      // The other triangle has the edge in the opposite direction, or in the same direction if the
      // surface is inconsistently oriented.
      for (const std::size_t turn : { std::size_t{ 1 }, std::size_t{ 2 } })
      {
        const std::size_t a = (k + turn) % 3, b = (k + 3 - turn) % 3;
        if (theirs[a] == mine[next] && theirs[b] == mine[previous] &&
            this->Coded[other][a] == this->Coded[t][next] &&
            this->Coded[other][b] == this->Coded[t][previous])
        {
          return &this->Coded[other][k];
        }
      }
    }
    return nullptr;
  }

  // a + b - c; for exact tiles computed with the numbers that the bits stand for.
  std::int64_t Close(std::int64_t a, std::int64_t b, std::int64_t c) const
  {
    if (!this->Exact)
    {
      return Sum(a, Difference(b, c));
    }
    const auto number = [](std::int64_t bits)
    { return double(FloatOfOrderedBits(static_cast<std::uint32_t>(bits))); };
    const double closed = number(a) + number(b) - number(c);
    // NaNs have different bits on different machines, and do not help to predict.
    return std::abs(closed) < 1e30 ? std::int64_t{ OrderedBits(static_cast<float>(closed)) } : a;
  }

  std::vector<Pairs> Recent;         // of each vertex
  std::vector<std::uint32_t> LastAt; // the triangle that was stored last
  TileCorner Last{ 0, 0 };
};

class TileCornerWriter : public TileCornerMemory
{
public:
  TileCornerWriter(SymbolWriter& symbols, std::span<const Triangle> triangles, bool exact)
    : TileCornerMemory(triangles, exact)
    , Symbols(symbols)
  {
  }

  // Only for exact tiles, before the triangle's corners; and for planar ones, which have no
  // corners: call Remember after it.
  void Chart(std::size_t t, std::uint32_t chart)
  {
    unsigned symbol = 0;
    while (symbol < newChart && this->ChartAt(t, symbol) != chart)
    {
      ++symbol;
    }
    this->Symbols.Choice(TileContext::sameChart, symbol);
    if (symbol == newChart)
    {
      this->Symbols.Signed(TileContext::chart, std::int64_t{ chart } - this->LastChart);
    }
    this->ChartOf[t] = this->LastChart = chart;
  }

  void Corners(std::size_t t, const std::array<TileCorner, 3>& corners)
  {
    std::array<bool, 3> known{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const unsigned symbol = this->SymbolOf(this->Triangles[t][k], corners[k]);
      this->Symbols.Choice(TileContext::corner + k, symbol);
      known[k] = symbol != newPair;
    }
    this->Coded[t] = corners;
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!known[k])
      {
        const Prediction predicted = this->Predict(t, k, known);
        this->Symbols.Signed(predicted.context, corners[k][0] - predicted.value[0]);
        this->Symbols.Signed(predicted.context + 1, corners[k][1] - predicted.value[1]);
        known[k] = true;
      }
    }
    this->Remember(t);
  }

private:
  SymbolWriter& Symbols;
};

// Values read past the end, or never written, are arbitrary: see SymbolReader.
class TileCornerReader : public TileCornerMemory
{
public:
  TileCornerReader(SymbolReader& symbols, std::span<const Triangle> triangles, bool exact)
    : TileCornerMemory(triangles, exact)
    , Symbols(symbols)
  {
  }

  // The result can be the number of a chart that does not exist.
  std::uint64_t Chart(std::size_t t)
  {
    const unsigned symbol = this->Symbols.Choice(TileContext::sameChart);
    const std::int64_t chart = symbol < newChart
                                 ? std::int64_t{ this->ChartAt(t, symbol) }
                                 : Sum(this->LastChart, this->Symbols.Signed(TileContext::chart));
    this->ChartOf[t] = this->LastChart = static_cast<std::uint32_t>(chart);
    return static_cast<std::uint64_t>(chart);
  }

  // A result need not be a valid corner.
  std::array<TileCorner, 3> Corners(std::size_t t)
  {
    std::array<bool, 3> known{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const TileCorner* const pair =
        this->PairOf(this->Triangles[t][k], this->Symbols.Choice(TileContext::corner + k));
      known[k] = pair != nullptr;
      this->Coded[t][k] = pair ? *pair : TileCorner{};
    }
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (!known[k])
      {
        const Prediction predicted = this->Predict(t, k, known);
        this->Coded[t][k] = { Sum(predicted.value[0], this->Symbols.Signed(predicted.context)),
          Sum(predicted.value[1], this->Symbols.Signed(predicted.context + 1)) };
        known[k] = true;
      }
    }
    this->Remember(t);
    return this->Coded[t];
  }

private:
  SymbolReader& Symbols;
};

}
