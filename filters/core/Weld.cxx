#include "filters/core/Weld.h"

#include "filters/core/BitCast.h"

#include <algorithm>
#include <bit>

namespace kdstream
{
namespace
{

std::array<std::uint64_t, 3> Bits(const Vec3& p, Coincidence coincidence)
{
  std::array<std::uint64_t, 3> bits;
  for (std::size_t k = 0; k < 3; ++k)
  {
    bits[k] = BitCast<std::uint64_t>(coincidence == Coincidence::ValueEqual ? p[k] + 0.0 : p[k]);
  }
  return bits;
}

std::uint64_t Hash(const std::array<std::uint64_t, 3>& bits)
{
  std::uint64_t hash = 0x9E3779B97F4A7C15U;
  for (const std::uint64_t word : bits)
  {
    hash = (hash ^ word) * 0xFF51AFD7ED558CCDU;
    hash ^= hash >> 32;
  }
  return hash;
}

// For each of `count` things the lowest that equals it. Open addressing; the table holds ids, half
// of it stays empty. Ids are inserted in ascending order, so the one that is found is the lowest.
template <class HashOf, class Equal>
std::vector<VertexId> FirstEqual(std::size_t count, const HashOf& hashOf, const Equal& equal)
{
  const std::size_t size = std::bit_ceil(count * 2 + 1);
  std::vector<VertexId> table(size, noVertex);
  std::vector<VertexId> first(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    const auto id = static_cast<VertexId>(i);
    std::size_t slot = hashOf(id) & (size - 1);
    while (table[slot] != noVertex && !equal(table[slot], id))
    {
      slot = (slot + 1) & (size - 1);
    }
    if (table[slot] == noVertex)
    {
      table[slot] = id;
    }
    first[i] = table[slot];
  }
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
std::vector<VertexId> FirstEqualVertex(const Mesh& mesh)
{
  const std::vector<const Attribute*> arrays = PointArrays(mesh);
  const auto hashOf = [&](VertexId v)
  {
    std::uint64_t hash = Hash(Bits(mesh.points[v], Coincidence::BitEqual));
    for (const Attribute* array : arrays)
    {
      for (const std::uint8_t byte : TupleOf(*array, v))
      {
        hash = (hash ^ byte) * 0x100000001B3U;
      }
      hash ^= hash >> 32;
    }
    return hash;
  };
  const auto equal = [&](VertexId a, VertexId b)
  {
    return Bits(mesh.points[a], Coincidence::BitEqual) ==
             Bits(mesh.points[b], Coincidence::BitEqual) &&
           std::all_of(arrays.begin(), arrays.end(),
             [a, b](const Attribute* array)
             {
               const auto x = TupleOf(*array, a), y = TupleOf(*array, b);
               return std::equal(x.begin(), x.end(), y.begin());
             });
  };
  return FirstEqual(mesh.points.size(), hashOf, equal);
}

}

std::vector<VertexId> FirstCoincident(std::span<const Vec3> points, Coincidence coincidence)
{
  return FirstEqual(
    points.size(), [&](VertexId v) { return Hash(Bits(points[v], coincidence)); },
    [&](VertexId a, VertexId b)
    { return Bits(points[a], coincidence) == Bits(points[b], coincidence); });
}

std::size_t WeldVertices(Mesh& mesh)
{
  std::vector<VertexId> renumbered = FirstEqualVertex(mesh);
  VertexId kept = 0;
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
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      array.values.resize(kept * array.TupleSize());
    }
  }
  if (welded > 0)
  {
    for (Triangle& triangle : mesh.triangles)
    {
      triangle = { renumbered[triangle[0]], renumbered[triangle[1]], renumbered[triangle[2]] };
    }
  }
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
