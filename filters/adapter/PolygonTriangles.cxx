// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/PolygonTriangles.h"

#include <vtkIdList.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPolygon.h>

namespace kdstream
{
namespace
{

// Whether no corner turns against the polygon's normal (Newell's).
bool IsConvex(std::span<const Vec3> points)
{
  const std::size_t count = points.size();
  const auto turn = [&](std::size_t a, std::size_t b, std::size_t c)
  {
    double u[3], v[3];
    Vec3 cross;
    vtkMath::Subtract(points[b].data(), points[a].data(), u);
    vtkMath::Subtract(points[c].data(), points[b].data(), v);
    vtkMath::Cross(u, v, cross.data());
    return cross;
  };
  Vec3 normal{};
  for (std::size_t i = 2; i < count; ++i)
  {
    // Of the fan's triangle: (b - a) x (c - b) is twice its area vector.
    const Vec3 part = turn(0, i - 1, i);
    vtkMath::Add(normal.data(), part.data(), normal.data());
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    const Vec3 corner = turn(i, (i + 1) % count, (i + 2) % count);
    if (vtkMath::Dot(corner.data(), normal.data()) < 0)
    {
      return false;
    }
  }
  return true;
}

void AppendFan(std::span<const vtkIdType> polygon, std::vector<Triangle>& triangles)
{
  for (std::size_t i = 2; i < polygon.size(); ++i)
  {
    triangles.push_back({ static_cast<VertexId>(polygon[0]), static_cast<VertexId>(polygon[i - 1]),
      static_cast<VertexId>(polygon[i]) });
  }
}

// Whether ears could be cut until nothing was left.
bool AppendEars(std::span<const vtkIdType> polygon, std::span<const Vec3> points,
  std::vector<Triangle>& triangles)
{
  const vtkNew<vtkPolygon> cell;
  cell->GetPoints()->SetDataTypeToDouble();
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    cell->GetPoints()->InsertNextPoint(points[i].data());
    cell->GetPointIds()->InsertNextId(static_cast<vtkIdType>(i));
  }
  const vtkNew<vtkIdList> ears;
  if (cell->Triangulate(ears) == 0 ||
      ears->GetNumberOfIds() != 3 * (static_cast<vtkIdType>(points.size()) - 2))
  {
    return false;
  }
  for (vtkIdType i = 0; i < ears->GetNumberOfIds(); i += 3)
  {
    Triangle& triangle = triangles.emplace_back();
    for (vtkIdType k = 0; k < 3; ++k)
    {
      triangle[static_cast<std::size_t>(k)] =
        static_cast<VertexId>(polygon[static_cast<std::size_t>(ears->GetId(i + k))]);
    }
  }
  return true;
}

}

void AppendPolygon(
  std::span<const vtkIdType> polygon, vtkPoints& points, std::vector<Triangle>& triangles)
{
  if (polygon.size() <= 3)
  {
    AppendFan(polygon, triangles);
    return;
  }
  std::vector<Vec3> corners(polygon.size());
  for (std::size_t i = 0; i < polygon.size(); ++i)
  {
    points.GetPoint(polygon[i], corners[i].data());
  }
  if (IsConvex(corners) || !AppendEars(polygon, corners, triangles))
  {
    AppendFan(polygon, triangles);
  }
}

}
