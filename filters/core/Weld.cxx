#include "filters/core/Weld.h"

#include "filters/core/BitCast.h"

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

}

std::vector<VertexId> FirstCoincident(std::span<const Vec3> points, Coincidence coincidence)
{
  // Open addressing; the table holds ids, half of it stays empty. Ids are inserted in ascending
  // order, so the one that is found is the lowest.
  const std::size_t size = std::bit_ceil(points.size() * 2 + 1);
  std::vector<VertexId> table(size, noVertex);
  std::vector<VertexId> first(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    const auto bits = Bits(points[i], coincidence);
    std::size_t slot = Hash(bits) & (size - 1);
    while (table[slot] != noVertex && Bits(points[table[slot]], coincidence) != bits)
    {
      slot = (slot + 1) & (size - 1);
    }
    if (table[slot] == noVertex)
    {
      table[slot] = static_cast<VertexId>(i);
    }
    first[i] = table[slot];
  }
  return first;
}

std::size_t WeldVertices(Mesh& mesh)
{
  std::vector<VertexId> renumbered = FirstCoincident(mesh.points, Coincidence::BitEqual);
  VertexId kept = 0;
  for (VertexId i = 0; i < renumbered.size(); ++i)
  {
    if (renumbered[i] == i)
    {
      mesh.points[kept] = mesh.points[i];
      renumbered[i] = kept++;
    }
    else
    {
      renumbered[i] = renumbered[renumbered[i]];
    }
  }
  const std::size_t welded = mesh.points.size() - kept;
  mesh.points.resize(kept);
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
