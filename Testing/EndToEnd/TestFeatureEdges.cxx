// SPDX-License-Identifier: BSD-3-Clause
// The drawn surface as VTK sees it: vtkFeatureEdges finds no boundary edge in 200 seeded cuts of
// each closed mesh.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/core/tree/Region.h"

#include <gtest/gtest.h>

#include <vtkCellArray.h>
#include <vtkFeatureEdges.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

vtkIdType BoundaryEdgesOf(const Surface& surface)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : surface.points)
  {
    points->InsertNextPoint(p.data());
  }
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& t : surface.triangles)
  {
    const vtkIdType ids[3] = { t[0], t[1], t[2] };
    triangles->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> mesh;
  mesh->SetPoints(points);
  mesh->SetPolys(triangles);
  vtkNew<vtkFeatureEdges> edges;
  edges->SetInputData(mesh);
  edges->BoundaryEdgesOn();
  edges->FeatureEdgesOff();
  edges->NonManifoldEdgesOff();
  edges->ManifoldEdgesOff();
  edges->Update();
  return edges->GetOutput()->GetNumberOfCells();
}

Cut RandomCut(std::mt19937& random, const Model& model)
{
  const TreeDepths& depths = model.tree.depths;
  const auto partitions = std::uint32_t{ 1 } << depths.partition;
  const auto draw = [&](std::uint32_t below)
  { return static_cast<std::uint32_t>(random() % below); };
  if (random() % 2 == 0) // with a region, in any level
  {
    const auto base = Resolution::Level(draw(depths.finest + 1));
    const auto region =
      *FindRegion(model.tree.boxes, depths, NodeOfPartition(draw(partitions), depths), draw(3));
    std::vector<PieceId> wanted;
    for (const std::uint32_t p : region)
    {
      wanted.push_back({ Resolution::Original(), NodeOfPartition(p, depths) });
    }
    return CutShowing(model, base, wanted);
  }
  std::set<PieceId> active;
  for (std::uint32_t p = 0; p < partitions; ++p)
  {
    const unsigned depth = depths.stitch + draw(depths.finest - depths.stitch + 2);
    active.insert(PieceOfPartition(
      depth > depths.finest ? Resolution::Original() : Resolution::Level(depth), p, depths));
  }
  active.erase(active.begin(), active.lower_bound({ Resolution::Level(depths.stitch + 1), 0 }));
  return { depths, Resolution::Level(depths.stitch), { active.begin(), active.end() } };
}

}

TEST(FeatureEdges, ClosedMeshesHaveNoneInAnyCut)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    const auto model = MakeModel(named.mesh, { 100, {}, 8 }, {}, {}, 3);
    std::mt19937 random(1234);
    for (unsigned draw = 0; draw < 200; ++draw)
    {
      const auto surface = DrawSurface(RandomCut(random, *model), model->Lookup());
      ASSERT_TRUE(surface);
      ASSERT_EQ(BoundaryEdgesOf(*surface), 0) << named.name << ", draw " << draw;
    }
  }
}

TEST(FeatureEdges, AreSeenWhereThereAreSome)
{
  const auto model = MakeModel(GridPlate(20), { 100, {}, 8 });
  const auto surface = DrawSurface({ model->tree.depths, Resolution::Original() }, model->Lookup());
  EXPECT_EQ(BoundaryEdgesOf(*surface), 80);
}
