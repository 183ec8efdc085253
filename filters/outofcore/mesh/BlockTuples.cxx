// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/mesh/BlockTuples.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{
namespace
{

// Tuples with at most this number of bytes between them are read in one go, together with the bytes
// between.
constexpr std::uint64_t nearBytes = std::uint64_t{ 1 } << 14;

// Where a required tuple is in the file, and where it goes.
struct TuplePlace
{
  std::uint32_t source = 0, target = 0;
};

// The arrays of one association, whose tuples lie in one file.
class TupleLoader
{
public:
  TupleLoader(std::vector<Attribute>& attributes, AttributeAssociation association)
  {
    for (Attribute& attribute : attributes)
    {
      if (attribute.association == association)
      {
        this->Arrays.push_back(&attribute);
        this->TupleBytes += attribute.TupleSize();
      }
    }
  }

  // places: sources ascend; the targets are the numbers below places.size(), each once.
  Status Load(const SpillFile& file, std::span<const TuplePlace> places)
  {
    if (this->TupleBytes == 0)
    {
      return {};
    }
    for (Attribute* array : this->Arrays)
    {
      array->values.resize(places.size() * array->TupleSize());
    }
    std::vector<std::byte> bytes;
    while (!places.empty())
    {
      const std::span<const TuplePlace> run = places.first(this->RunLength(places));
      const std::uint64_t first = run.front().source;
      bytes.resize(static_cast<std::size_t>((run.back().source - first + 1) * this->TupleBytes));
      KDSTREAM_TRY(file.Read(first * this->TupleBytes, bytes));
      for (const TuplePlace& place : run)
      {
        this->Place(
          std::span<const std::byte>(bytes).subspan(
            static_cast<std::size_t>((place.source - first) * this->TupleBytes), this->TupleBytes),
          place.target);
      }
      places = places.subspan(run.size());
    }
    return {};
  }

private:
  // How many of the places are read in one go.
  std::size_t RunLength(std::span<const TuplePlace> places) const
  {
    std::size_t length = 1;
    while (length < places.size())
    {
      const std::uint64_t next = places[length].source;
      const std::uint64_t gap = (next - places[length - 1].source - 1) * this->TupleBytes;
      const std::uint64_t all = (next - places[0].source + 1) * this->TupleBytes;
      if (gap > nearBytes || all > spillBlockBytes)
      {
        break;
      }
      ++length;
    }
    return length;
  }

  void Place(std::span<const std::byte> tuple, std::size_t target)
  {
    for (Attribute* array : this->Arrays)
    {
      const auto part = tuple.first(array->TupleSize());
      std::copy(part.begin(), part.end(),
        std::as_writable_bytes(std::span(array->values)).begin() +
          std::ptrdiff_t(target * part.size()));
      tuple = tuple.subspan(part.size());
    }
  }

  std::vector<Attribute*> Arrays;
  std::size_t TupleBytes = 0;
};

std::vector<TuplePlace> PlacesOf(std::span<const std::uint32_t> sources)
{
  std::vector<TuplePlace> places(sources.size());
  for (std::uint32_t i = 0; i < places.size(); ++i)
  {
    places[i] = { sources[i], i };
  }
  return places;
}

}

Status LoadBlockTuples(std::span<const AttributeInfo> attributes, const SpillFile& pointTuples,
  const SpillFile& cellTuples, TreeBlock& block)
{
  std::vector<Attribute>& arrays = block.mesh.attributes;
  arrays.clear();
  for (const AttributeInfo& attribute : attributes)
  {
    arrays.push_back({ attribute, {} });
  }
  if (arrays.empty())
  {
    return {};
  }
  std::vector<TuplePlace> points = PlacesOf(block.ranks);
  std::sort(points.begin(), points.end(),
    [](const TuplePlace& a, const TuplePlace& b) { return a.source < b.source; });
  KDSTREAM_TRY(TupleLoader(arrays, AttributeAssociation::Point).Load(pointTuples, points));
  return TupleLoader(arrays, AttributeAssociation::Cell).Load(cellTuples, PlacesOf(block.numbers));
}

}
