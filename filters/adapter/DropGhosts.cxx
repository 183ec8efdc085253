// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/DropGhosts.h"

#include <algorithm>
#include <cstddef>

namespace kdstream
{
namespace
{

void MovePoint(Mesh& mesh, VertexId from, VertexId to)
{
  if (from == to)
  {
    return;
  }
  mesh.points[to] = mesh.points[from];
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      const std::size_t size = array.TupleSize();
      std::copy_n(array.values.begin() + std::ptrdiff_t(from * size), size,
        array.values.begin() + std::ptrdiff_t(to * size));
    }
  }
}

}

void DropUnusedGhosts(Mesh& mesh, const std::vector<bool>& isGhost)
{
  std::vector<bool> isUsed(mesh.points.size(), false);
  for (const Triangle& t : mesh.triangles)
  {
    for (const VertexId v : t)
    {
      isUsed[v] = true;
    }
  }
  std::vector<VertexId> newId(mesh.points.size(), noVertex);
  VertexId kept = 0;
  for (VertexId v = 0; v < mesh.points.size(); ++v)
  {
    if (isUsed[v] || !isGhost[v])
    {
      MovePoint(mesh, v, kept);
      newId[v] = kept++;
    }
  }
  mesh.points.resize(kept);
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Point)
    {
      array.values.resize(kept * array.TupleSize());
    }
  }
  for (Triangle& t : mesh.triangles)
  {
    t = { newId[t[0]], newId[t[1]], newId[t[2]] };
  }
}

}
