// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/UnusedVertices.h"

#include <algorithm>
#include <cstddef>

namespace kdstream
{
namespace
{

// Moves the unused elements of `all` to the end of `unused`, and closes the gaps in `all`. size:
// the number of values in an element.
template <class Value>
void PartElements(const std::vector<bool>& isUsed, std::size_t unusedCount, std::size_t size,
  std::vector<Value>& all, std::vector<Value>& unused)
{
  unused.reserve(unusedCount * size);
  auto kept = all.begin();
  for (std::size_t v = 0; v < isUsed.size(); ++v)
  {
    const auto begin = all.begin() + std::ptrdiff_t(v * size);
    const auto end = begin + std::ptrdiff_t(size);
    if (!isUsed[v])
    {
      unused.insert(unused.end(), begin, end);
    }
    else
    {
      kept = kept == begin ? end : std::copy(begin, end, kept);
    }
  }
  all.erase(kept, all.end());
  all.shrink_to_fit();
}

}

std::vector<bool> FindUsedVertices(const Mesh& mesh)
{
  std::vector<bool> isUsed(mesh.points.size(), mesh.triangles.empty());
  for (const Triangle& triangle : mesh.triangles)
  {
    for (const VertexId corner : triangle)
    {
      isUsed[corner] = true;
    }
  }
  return isUsed;
}

Mesh TakeUnusedVertices(Mesh& mesh, const std::vector<bool>& isUsed)
{
  const auto count = static_cast<std::size_t>(std::count(isUsed.begin(), isUsed.end(), false));
  Mesh unused{ {}, {}, mesh.scalarType, {} };
  PartElements(isUsed, count, 1, mesh.points, unused.points);
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      Attribute& parted = unused.attributes.emplace_back(Attribute{ array.Info(), {} });
      PartElements(isUsed, count, array.TupleSize(), array.values, parted.values);
    }
  }
  std::vector<VertexId> numbers(isUsed.size());
  VertexId next = 0;
  for (std::size_t v = 0; v < isUsed.size(); ++v)
  {
    numbers[v] = next;
    next += isUsed[v] ? 1 : 0;
  }
  for (Triangle& triangle : mesh.triangles)
  {
    triangle = { numbers[triangle[0]], numbers[triangle[1]], numbers[triangle[2]] };
  }
  return unused;
}

}
