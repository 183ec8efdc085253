// Steps: 1. points and triangles in core's types  2. weld, tree, levels down to Depth (core)  3.
// VTK arrays.
#include "vtkKdClusterSimplification.h"

#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/core/ClusterLevels.h"
#include "filters/core/KdTree.h"
#include "filters/core/Weld.h"

#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <cmath>
#include <string>

vtkStandardNewMacro(vtkKdClusterSimplification);

namespace
{

using namespace kdstream;

// The level at `depth`, or the finest where there is none. finest: set to the depth of the finest.
Result<ClusterLevel> BuildLevel(const Mesh& mesh, const KdTreeOptions& treeOptions,
  ClusterOptions options, int depth, const Execution& execution, int& finest)
{
  const Result<TreeDepths> depths = ComputeDepths(mesh.points.size(), treeOptions);
  if (!depths)
  {
    return depths.GetError();
  }
  finest = static_cast<int>(depths->finest);
  if (depth > finest)
  {
    return Error{ ErrorCode::InvalidArgument,
      "Depth " + std::to_string(depth) + " is below the finest level of this input, at depth " +
        std::to_string(finest) };
  }
  const Result<KdTree> tree = BuildKdTree(mesh.points, treeOptions, execution);
  if (!tree)
  {
    return tree.GetError();
  }
  const std::vector<std::uint32_t> partition = CellOfVertex(*tree, depths->partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << depths->partition, [&](VertexId v) { return partition[v]; });
  options.coarsestDepth = depth < 0 ? depths->finest : static_cast<unsigned>(depth);
  Result<ClusterLevels> levels =
    BuildClusterLevels(mesh.points, mesh.triangles, *tree, buckets, options, execution);
  if (!levels)
  {
    return levels.GetError();
  }
  return std::move(levels->levels[options.coarsestDepth]);
}

void FillOutput(const ClusterLevel& level, const Mesh& mesh, vtkPolyData& output)
{
  const auto count = static_cast<vtkIdType>(level.positions.size());
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.scalarType == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(count);
  vtkNew<vtkDoubleArray> deviations;
  deviations->SetName("Deviation");
  deviations->SetNumberOfValues(count);
  for (vtkIdType i = 0; i < count; ++i)
  {
    const auto cluster = static_cast<std::size_t>(i);
    points->SetPoint(i, level.positions[cluster].data());
    deviations->SetValue(i, level.deviations[cluster]);
  }
  output.SetPoints(points);
  output.GetPointData()->AddArray(deviations);

  vtkNew<vtkCellArray> cells;
  if (mesh.triangles.empty())
  {
    cells->AllocateExact(count, count);
    for (vtkIdType i = 0; i < count; ++i)
    {
      cells->InsertNextCell(1, &i);
    }
    output.SetVerts(cells);
    return;
  }
  const auto triangles = static_cast<vtkIdType>(level.triangles.size());
  cells->AllocateExact(triangles, 3 * triangles);
  for (const Triangle& t : level.triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  output.SetPolys(cells);
}

}

int vtkKdClusterSimplification::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* const input = vtkPolyData::GetData(inputVector[0]);
  vtkPolyData* const output = vtkPolyData::GetData(outputVector);
  this->FinestDepth = -1;
  if (input->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  KdTreeOptions tree;
  tree.verticesPerPartition = static_cast<std::uint32_t>(this->VerticesPerPartition);
  tree.cellVertices = static_cast<std::uint32_t>(this->CellVertices);
  ClusterOptions options;
  options.representative = this->Representative == Mean ? kdstream::Representative::Mean
                                                        : kdstream::Representative::Quadric;
  options.sheets = this->Sheets;
  const Execution execution =
    MakeAlgorithmExecution(*this, { { "tree", 0.05, 0.4 }, { "levels", 0.4, 1.0 } });

  Result<Mesh> mesh = ReadMesh(*input, execution);
  if (mesh && this->Weld)
  {
    WeldVertices(*mesh);
  }
  const Result<ClusterLevel> level =
    mesh ? BuildLevel(*mesh, tree, options, this->Depth, execution, this->FinestDepth)
         : Result<ClusterLevel>(mesh.GetError());
  if (level)
  {
    FillOutput(*level, *mesh, *output);
    return 1;
  }
  if (level.GetError().code == ErrorCode::Cancelled)
  {
    return 1;
  }
  vtkErrorMacro(<< level.GetError().message);
  return 0;
}

void vtkKdClusterSimplification::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Depth: " << this->Depth << "\n";
  os << indent << "Representative: " << (this->Representative == Mean ? "Mean" : "Quadric") << "\n";
  os << indent << "Sheets: " << (this->Sheets ? "on" : "off") << "\n";
  os << indent << "Weld: " << (this->Weld ? "on" : "off") << "\n";
  os << indent << "CellVertices: " << this->CellVertices << "\n";
  os << indent << "VerticesPerPartition: " << this->VerticesPerPartition << "\n";
  os << indent << "FinestDepth: " << this->FinestDepth << "\n";
}
