// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Weld.h"

#include "filters/core/BitCast.h"
#include "filters/core/SeededHash.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <bit>
#include <memory>
#include <numeric>
#include <utility>

namespace kdstream
{
namespace
{

// Coordinates that have equal bits if the places are equal.
Vec3 KeyOf(const Vec3& p, Coincidence coincidence)
{
  return coincidence == Coincidence::ValueEqual ? WithPositiveZeros(p) : p;
}

bool HaveEqualBits(const Vec3& p, const Vec3& q)
{
  return BitCast<std::array<std::uint64_t, 3>>(p) == BitCast<std::array<std::uint64_t, 3>>(q);
}

// The hash of an element, and its id. The upper bits of the hash select the block.
struct Hashed
{
  std::uint32_t hash;
  VertexId id;
};

// Elements sorted into blocks by their hashes, so that equal elements are in the same block, and a
// block fits in the cache. Ids ascend within a block. The result does not depend on the number of
// threads.
struct HashBlocks
{
  std::vector<std::size_t> begin; // one entry a block, and the end
  std::vector<Hashed> things;

  template <class HashOf>
  HashBlocks(std::size_t count, const HashOf& hashOf, const Execution& execution)
  {
    constexpr std::size_t chunk = std::size_t{ 1 } << 16, mostBlocks = 1 << 12;
    const std::size_t blocks = std::min(mostBlocks, std::bit_ceil(count >> 12 | 1));
    const auto shift = 32 - std::countr_zero(blocks);
    const auto blockOf = [&](std::uint32_t hash) { return blocks == 1 ? 0 : hash >> shift; };
    // Each chunk counts by itself; the place of its elements follows from the counts of earlier
    // chunks.
    const std::size_t chunks = (count + chunk - 1) / chunk;
    std::vector<std::uint32_t> counts(chunks * blocks, 0);
    const auto forEach = [&](const auto& visit)
    {
      execution.parallelFor(chunks, 1,
        [&](std::size_t chunkBegin, std::size_t chunkEnd)
        {
          for (std::size_t c = chunkBegin; c < chunkEnd; ++c)
          {
            for (std::size_t i = c * chunk; i < std::min(count, (c + 1) * chunk); ++i)
            {
              visit(static_cast<VertexId>(i), &counts[c * blocks]);
            }
          }
        });
    };
    const auto hashes = std::make_unique_for_overwrite<std::uint32_t[]>(count);
    forEach(
      [&](VertexId id, std::uint32_t* counters)
      {
        hashes[id] = static_cast<std::uint32_t>(hashOf(id));
        ++counters[blockOf(hashes[id])];
      });
    this->begin.assign(blocks + 1, 0);
    for (std::size_t b = 0; b < blocks; ++b)
    {
      std::size_t size = 0;
      for (std::size_t c = 0; c < chunks; ++c)
      {
        size += std::exchange(counts[c * blocks + b], static_cast<std::uint32_t>(size));
      }
      this->begin[b + 1] = this->begin[b] + size;
    }
    this->things.resize(count);
    forEach(
      [&](VertexId id, std::uint32_t* next)
      {
        const std::uint32_t block = blockOf(hashes[id]);
        this->things[this->begin[block] + next[block]++] = { hashes[id], id };
      });
  }
};

// Calls visit(block, id, lowest equal id) for each element, on any threads. Each block has a hash
// table with open addressing, half empty. Ids are inserted in ascending order, so that the first of
// equal elements has the lowest id.
template <class Equal, class Visit>
void ForEachEqual(
  const HashBlocks& blocks, const Equal& equal, const Visit& visit, const Execution& execution)
{
  execution.parallelFor(blocks.begin.size() - 1, 1,
    [&](std::size_t begin, std::size_t end)
    {
      constexpr std::uint32_t none = ~std::uint32_t{ 0 };
      std::vector<std::uint32_t> table; // places in the block
      for (std::size_t b = begin; b < end; ++b)
      {
        const std::span<const Hashed> things(
          blocks.things.data() + blocks.begin[b], blocks.begin[b + 1] - blocks.begin[b]);
        const std::size_t size = std::bit_ceil(things.size() * 2 + 1);
        table.assign(size, none);
        for (std::uint32_t i = 0; i < things.size(); ++i)
        {
          std::size_t slot = things[i].hash & (size - 1);
          while (table[slot] != none && (things[table[slot]].hash != things[i].hash ||
                                          !equal(things[table[slot]].id, things[i].id)))
          {
            slot = (slot + 1) & (size - 1);
          }
          if (table[slot] == none)
          {
            table[slot] = i;
          }
          visit(b, things[i].id, things[table[slot]].id);
        }
      }
    });
}

// For each of `count` elements the lowest element that equals it.
template <class HashOf, class Equal>
std::vector<VertexId> FirstEqual(
  std::size_t count, const HashOf& hashOf, const Equal& equal, const Execution& execution)
{
  const HashBlocks blocks(count, hashOf, execution);
  std::vector<VertexId> first(count);
  ForEachEqual(
    blocks, equal, [&](std::size_t, VertexId id, VertexId lowest) { first[id] = lowest; },
    execution);
  return first;
}

std::vector<const Attribute*> PointArrays(const Mesh& mesh)
{
  std::vector<const Attribute*> arrays;
  for (const Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      arrays.push_back(&array);
    }
  }
  return arrays;
}

std::span<const std::uint8_t> TupleOf(const Attribute& array, VertexId v)
{
  return { array.values.data() + v * array.TupleSize(), array.TupleSize() };
}

// Copies the point tuples of one vertex to a lower one.
void MoveTuples(Mesh& mesh, VertexId from, VertexId to)
{
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point && from != to)
    {
      const auto tuple = TupleOf(array, from);
      std::copy(tuple.begin(), tuple.end(), array.values.data() + to * array.TupleSize());
    }
  }
}

// For each vertex the lowest with bit-equal coordinates and tuples.
std::vector<VertexId> FirstEqualVertex(const Mesh& mesh, const Execution& execution)
{
  const std::vector<const Attribute*> arrays = PointArrays(mesh);
  const std::uint64_t seed = RandomSeed();
  const auto hashOf = [&](VertexId v)
  {
    std::uint64_t hash = HashOfPlace(mesh.points[v], seed);
    for (const Attribute* array : arrays)
    {
      hash = HashOfBytes(std::as_bytes(TupleOf(*array, v)), hash);
    }
    return hash;
  };
  const auto equal = [&](VertexId a, VertexId b)
  {
    return HaveEqualBits(mesh.points[a], mesh.points[b]) &&
           std::all_of(arrays.begin(), arrays.end(),
             [a, b](const Attribute* array)
             {
               const auto x = TupleOf(*array, a), y = TupleOf(*array, b);
               return std::equal(x.begin(), x.end(), y.begin());
             });
  };
  return FirstEqual(mesh.points.size(), hashOf, equal, execution);
}

}

std::vector<VertexId> FirstCoincident(
  std::span<const Vec3> points, Coincidence coincidence, const Execution& execution)
{
  const auto keyOf = [&](VertexId v) { return KeyOf(points[v], coincidence); };
  return FirstEqual(
    points.size(), [&, seed = RandomSeed()](VertexId v) { return HashOfPlace(keyOf(v), seed); },
    [&](VertexId a, VertexId b) { return HaveEqualBits(keyOf(a), keyOf(b)); }, execution);
}

std::size_t CountPlaces(
  std::size_t count, const std::function<Vec3(VertexId)>& placeOf, const Execution& execution)
{
  const auto keyOf = [&](VertexId v) { return KeyOf(placeOf(v), Coincidence::ValueEqual); };
  const HashBlocks blocks(
    count, [&, seed = RandomSeed()](VertexId v) { return HashOfPlace(keyOf(v), seed); }, execution);
  std::vector<std::size_t> places(blocks.begin.size(), 0);
  ForEachEqual(
    blocks, [&](VertexId a, VertexId b) { return HaveEqualBits(keyOf(a), keyOf(b)); },
    [&](std::size_t block, VertexId id, VertexId lowest) { places[block] += id == lowest; },
    execution);
  return std::accumulate(places.begin(), places.end(), std::size_t{ 0 });
}

std::size_t WeldVertices(Mesh& mesh, const Execution& execution, std::vector<VertexId>* newIds)
{
  std::vector<VertexId> own;
  std::vector<VertexId>& renumbered = newIds ? *newIds : own;
  renumbered = FirstEqualVertex(mesh, execution);
  VertexId kept = 0;
  while (kept < renumbered.size() && renumbered[kept] == kept)
  {
    ++kept;
  }
  if (kept == renumbered.size())
  {
    return 0;
  }
  kept = 0;
  for (VertexId i = 0; i < renumbered.size(); ++i)
  {
    if (renumbered[i] == i)
    {
      mesh.points[kept] = mesh.points[i];
      MoveTuples(mesh, i, kept);
      renumbered[i] = kept++;
    }
    else
    {
      renumbered[i] = renumbered[renumbered[i]];
    }
  }
  const std::size_t welded = mesh.points.size() - kept;
  mesh.points.resize(kept);
  mesh.points.shrink_to_fit(); // welding an STL file removes five sixths
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      array.values.resize(kept * array.TupleSize());
      array.values.shrink_to_fit();
    }
  }
  execution.parallelFor(mesh.triangles.size(), 1 << 16,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t t = begin; t < end; ++t)
      {
        for (VertexId& v : mesh.triangles[t])
        {
          v = renumbered[v];
        }
      }
    });
  return welded;
}

Box BoxOfPoints(std::span<const Vec3> points)
{
  Box box;
  for (const Vec3& p : points)
  {
    box.Add(p);
  }
  return box;
}

}
