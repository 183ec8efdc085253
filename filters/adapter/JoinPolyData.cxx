// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Find the parts.
// 2. Read their points, and the cells that are not ghosts.
// 3. Find out which points are the same (MergePoints).
// 4. Find the arrays that all parts have.
// 5. Make one vtkPolyData.
#include "filters/adapter/JoinPolyData.h"

#include "filters/adapter/MergePoints.h"
#include "filters/adapter/ReadParts.h"
#include "filters/adapter/SharedArrays.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDataSetAttributes.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>

namespace kdstream
{
namespace
{

// Joins the points and cells of the parts.
class Joining
{
public:
  Joining(const std::vector<InputPart>& parts, PartsRead read)
    : Parts(parts)
    , Input(std::move(read))
  {
  }

  JoinedPolyData Join(bool weldByPlace)
  {
    JoinedPolyData joined;
    joined.mesh = vtkSmartPointer<vtkPolyData>::New();
    const auto pointArrays = FindSharedArrays(this->Input.pointData, "point", joined.leftOut);
    const auto cellArrays = FindSharedArrays(this->Input.cellData, "cell", joined.leftOut);
    this->FillPoints(pointArrays, weldByPlace, joined);
    this->FillCells(cellArrays, *joined.mesh);
    if (this->Parts.size() == 1)
    {
      joined.mesh->GetFieldData()->ShallowCopy(this->Parts[0].mesh->GetFieldData());
    }
    return joined;
  }

private:
  // The type of the points of all parts; double if types differ.
  int PointType() const
  {
    const auto typeOf = [](const InputPart& part) { return part.mesh->GetPoints()->GetDataType(); };
    const int type = typeOf(this->Parts[0]);
    const bool same = std::all_of(this->Parts.begin(), this->Parts.end(),
      [&](const InputPart& part) { return typeOf(part) == type; });
    return same ? type : VTK_DOUBLE;
  }

  void FillPoints(const std::vector<SharedArray>& arrays, bool weldByPlace, JoinedPolyData& joined)
  {
    vtkPolyData& output = *joined.mesh;
    PartPoints& all = this->Input.points;
    const SharedArray* const ids = FindGlobalIds(arrays);
    if (ids)
    {
      for (VertexId v = 0; v < all.places.size(); ++v)
      {
        all.ids.push_back(IdOf(*ids, this->Input.TupleOf(v)));
      }
    }
    all.hashOfArrays = [&](VertexId v) { return HashOfTuple(arrays, this->Input.TupleOf(v)); };
    MergedPoints merged = MergePoints(all, weldByPlace);
    vtkNew<vtkPoints> points;
    points->SetDataType(this->PointType());
    points->SetNumberOfPoints(static_cast<vtkIdType>(merged.kept.size()));
    std::vector<TupleOfPart> tuples;
    for (const VertexId v : merged.kept)
    {
      points->SetPoint(static_cast<vtkIdType>(tuples.size()), all.places[v].data());
      tuples.push_back(this->Input.TupleOf(v));
    }
    output.SetPoints(points);
    CopySharedArrays(arrays, tuples, *output.GetPointData());
    if (ids && !merged.byIds)
    {
      vtkDataArray* const array = output.GetPointData()->GetGlobalIds();
      const std::string name = array && array->GetName() ? array->GetName() : "";
      joined.leftOut.push_back(
        "global ids \"" + name + "\": points of one id lie in different places");
    }
    if (!merged.byIds)
    {
      output.GetPointData()->SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
    }
    this->NewPoint = std::move(merged.becomes);
  }

  void FillCells(const std::vector<SharedArray>& arrays, vtkPolyData& output)
  {
    const SharedArray* const ids = FindGlobalIds(arrays);
    const bool areIds = ids && this->AreDistinct(*ids);
    std::vector<TupleOfPart> tuples;
    std::array<vtkNew<vtkCellArray>, 4> cells;
    for (std::size_t kind = 0; kind < this->Input.cells.size(); ++kind)
    {
      const KeptCells& kept = this->Input.cells[kind];
      cells[kind]->AllocateExact(
        static_cast<vtkIdType>(kept.from.size()), static_cast<vtkIdType>(kept.corners.size()));
      for (const std::size_t cell : OrderOf(kept, areIds ? ids : nullptr))
      {
        tuples.push_back(kept.from[cell]);
        cells[kind]->InsertNextCell(static_cast<int>(kept.begin[cell + 1] - kept.begin[cell]));
        for (std::size_t i = kept.begin[cell]; i < kept.begin[cell + 1]; ++i)
        {
          cells[kind]->InsertCellPoint(vtkIdType{ this->NewPoint[kept.corners[i]] });
        }
      }
    }
    output.SetVerts(cells[0]);
    output.SetLines(cells[1]);
    output.SetPolys(cells[2]);
    output.SetStrips(cells[3]);
    CopySharedArrays(arrays, tuples, *output.GetCellData());
    if (!areIds)
    {
      output.GetCellData()->SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
    }
  }

  // Whether no two cells of any kind have the same id.
  bool AreDistinct(const SharedArray& ids) const
  {
    std::vector<std::int64_t> all;
    for (const KeptCells& kept : this->Input.cells)
    {
      std::transform(kept.from.begin(), kept.from.end(), std::back_inserter(all),
        [&](TupleOfPart cell) { return IdOf(ids, cell); });
    }
    std::sort(all.begin(), all.end());
    return std::adjacent_find(all.begin(), all.end()) == all.end();
  }

  // The order of cells: by id, or as in the input if `ids` is null.
  static std::vector<std::size_t> OrderOf(const KeptCells& kept, const SharedArray* ids)
  {
    std::vector<std::size_t> order(kept.from.size());
    std::iota(order.begin(), order.end(), std::size_t{ 0 });
    if (!ids)
    {
      return order;
    }
    std::vector<std::int64_t> idOf;
    for (const TupleOfPart& cell : kept.from)
    {
      idOf.push_back(IdOf(*ids, cell));
    }
    std::sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return idOf[a] < idOf[b]; });
    return order;
  }

  const std::vector<InputPart>& Parts;
  PartsRead Input;
  std::vector<VertexId> NewPoint; // the new number of each point of each part
};

// Takes a single part without ghosts as it is, except arrays of a wrong length.
JoinedPolyData TakeWhole(vtkPolyData& mesh)
{
  JoinedPolyData whole{ vtkSmartPointer<vtkPolyData>::New(), {} };
  whole.mesh->ShallowCopy(&mesh);
  RemoveUnusableArrays(
    { whole.mesh->GetPointData(), mesh.GetNumberOfPoints() }, "point", whole.leftOut);
  RemoveUnusableArrays(
    { whole.mesh->GetCellData(), mesh.GetNumberOfCells() }, "cell", whole.leftOut);
  return whole;
}

}

vtkMTimeType TimeOf(vtkDataObject& input)
{
  vtkMTimeType latest = input.GetMTime();
  if (auto* const tree = vtkDataObjectTree::SafeDownCast(&input))
  {
    const auto each = vtk::TakeSmartPointer(tree->NewTreeIterator());
    each->VisitOnlyLeavesOff();
    for (each->InitTraversal(); !each->IsDoneWithTraversal(); each->GoToNextItem())
    {
      latest = std::max(latest, each->GetCurrentDataObject()->GetMTime());
    }
  }
  return latest;
}

Result<JoinedPolyData> JoinPolyData(
  vtkDataObject& input, bool weldByPlace, const Execution& execution)
{
  const Result<std::vector<InputPart>> parts = PartsOf(input);
  KDSTREAM_TRY(parts);
  if (parts->empty())
  {
    return JoinedPolyData{ vtkSmartPointer<vtkPolyData>::New(), {} };
  }
  vtkPolyData& first = *parts->front().mesh;
  if (parts->size() == 1 && !HasGhosts(first))
  {
    return TakeWhole(first);
  }
  Result<PartsRead> read = ReadParts(*parts, execution);
  KDSTREAM_TRY(read);
  return Joining(*parts, std::move(*read)).Join(weldByPlace);
}

}
