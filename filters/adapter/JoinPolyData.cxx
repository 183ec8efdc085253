// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. the parts  2. their points and the cells that are no ghosts  3. which points are the
// same (MergePoints)  4. the arrays that all have  5. one vtkPolyData.
#include "filters/adapter/JoinPolyData.h"

#include "filters/adapter/MergePoints.h"
#include "filters/adapter/PolyDataCells.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/SharedArrays.h"

#include <vtkCellData.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVariant.h>

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

constexpr unsigned char copiedPoint = vtkDataSetAttributes::DUPLICATEPOINT;
constexpr unsigned char notOwnPoint = copiedPoint | vtkDataSetAttributes::HIDDENPOINT;
constexpr unsigned char notOwnCell = vtkDataSetAttributes::DUPLICATECELL |
                                     vtkDataSetAttributes::HIDDENCELL |
                                     vtkDataSetAttributes::REFINEDCELL;

// The marks of vtkGhostType, where there are any.
class Marks
{
public:
  explicit Marks(const PartData& part)
    : Array(FindGhosts(part))
  {
  }

  bool Exist() const { return this->Array != nullptr; }
  bool Has(vtkIdType i, unsigned char mask) const
  {
    return this->Array && (this->Array->GetValue(i) & mask) != 0;
  }
  bool HasAny(unsigned char mask) const
  {
    return this->Array && std::any_of(this->Array->GetPointer(0),
                            this->Array->GetPointer(0) + this->Array->GetNumberOfValues(),
                            [mask](unsigned char mark) { return (mark & mask) != 0; });
  }

private:
  vtkUnsignedCharArray* Array;
};

Marks PointMarks(vtkPolyData& mesh)
{
  return Marks({ mesh.GetPointData(), mesh.GetNumberOfPoints() });
}

Marks CellMarks(vtkPolyData& mesh)
{
  return Marks({ mesh.GetCellData(), mesh.GetNumberOfCells() });
}

bool IsEmpty(vtkDataObject& block)
{
  const auto* const data = vtkDataSet::SafeDownCast(&block);
  return data && const_cast<vtkDataSet*>(data)->GetNumberOfPoints() == 0;
}

// What stays of the cells of one kind.
struct KeptCells
{
  std::vector<TupleOfPart> from;
  std::vector<std::size_t> begin{ 0 }; // of each cell in `corners`, and the end
  std::vector<VertexId> corners;       // points of all parts, one after the other
};

// The parts' points and cells, and what becomes of them.
class Joining
{
public:
  Joining(std::vector<InputPart> parts, const Execution& execution)
    : Parts(std::move(parts))
    , Runs(execution)
  {
    this->Points.first.push_back(0);
  }

  Status ReadAll()
  {
    for (std::size_t p = 0; p < this->Parts.size(); ++p)
    {
      const Status read = this->Read(p);
      if (!read)
      {
        const std::string& name = this->Parts[p].name;
        return Error{ read.GetError().code,
          (name.empty() ? "" : name + ": ") + read.GetError().message };
      }
    }
    return {};
  }

  JoinedPolyData Join(bool weldByPlace)
  {
    JoinedPolyData joined;
    joined.mesh = vtkSmartPointer<vtkPolyData>::New();
    std::vector<PartData> points, cells;
    for (std::size_t p = 0; p < this->Parts.size(); ++p)
    {
      vtkPolyData& mesh = *this->Parts[p].mesh;
      points.push_back({ mesh.GetPointData(), mesh.GetNumberOfPoints() });
      cells.push_back({ mesh.GetCellData(), this->HasKeptCells[p] ? mesh.GetNumberOfCells() : 0 });
    }
    const auto pointArrays = FindSharedArrays(points, "point", joined.leftOut);
    const auto cellArrays = FindSharedArrays(cells, "cell", joined.leftOut);
    this->FillPoints(pointArrays, weldByPlace, *joined.mesh);
    this->FillCells(cellArrays, *joined.mesh);
    if (this->Parts.size() == 1)
    {
      joined.mesh->GetFieldData()->ShallowCopy(this->Parts[0].mesh->GetFieldData());
    }
    return joined;
  }

private:
  Status Read(std::size_t part)
  {
    vtkPolyData& mesh = *this->Parts[part].mesh;
    const Result<std::vector<Vec3>> places = ReadPoints(mesh, this->Runs);
    KDSTREAM_TRY(places);
    const VertexId first = this->Points.first.back();
    if (places->size() >= noVertex - first)
    {
      return Error{ ErrorCode::LimitExceeded,
        "more than 4294967294 points: no more fit a tree in memory" };
    }
    this->Points.places.insert(this->Points.places.end(), places->begin(), places->end());
    this->Points.first.push_back(first + static_cast<VertexId>(places->size()));
    const Marks marks = PointMarks(mesh);
    std::vector<bool> isUsed(places->size()), isOfDropped(places->size());
    KDSTREAM_TRY(this->ReadCells(part, isUsed, isOfDropped));
    for (std::size_t i = 0; i < places->size(); ++i)
    {
      const auto point = static_cast<vtkIdType>(i);
      const bool mayGo = marks.Exist() ? marks.Has(point, notOwnPoint) : isOfDropped[i];
      this->Points.isCopy.push_back(marks.Has(point, copiedPoint));
      this->Points.isPresent.push_back(isUsed[i] || !mayGo);
    }
    return {};
  }

  Status ReadCells(std::size_t part, std::vector<bool>& isUsed, std::vector<bool>& isOfDropped)
  {
    vtkPolyData& mesh = *this->Parts[part].mesh;
    const Marks marks = CellMarks(mesh);
    const VertexId firstPoint = this->Points.first[part];
    this->HasKeptCells.push_back(false);
    vtkIdType firstCell = 0;
    vtkCellArray* const ofKind[] = { mesh.GetVerts(), mesh.GetLines(), mesh.GetPolys(),
      mesh.GetStrips() };
    for (std::size_t kind = 0; kind < this->Cells.size(); ++kind)
    {
      KeptCells& kept = this->Cells[kind];
      KDSTREAM_TRY(ForEachCell(ofKind[kind], firstCell, mesh.GetNumberOfPoints(),
        [&](vtkIdType cell, std::span<const vtkIdType> corners)
        {
          const bool isDropped = marks.Has(cell, notOwnCell);
          for (const vtkIdType corner : corners)
          {
            (isDropped ? isOfDropped : isUsed)[static_cast<std::size_t>(corner)] = true;
            if (!isDropped)
            {
              kept.corners.push_back(firstPoint + static_cast<VertexId>(corner));
            }
          }
          if (!isDropped)
          {
            kept.from.push_back({ static_cast<std::uint32_t>(part), cell });
            kept.begin.push_back(kept.corners.size());
            this->HasKeptCells.back() = true;
          }
        }));
      firstCell += ofKind[kind]->GetNumberOfCells();
    }
    return {};
  }

  TupleOfPart TupleOf(VertexId point) const
  {
    const auto& first = this->Points.first;
    const auto next = std::upper_bound(first.begin(), first.end(), point);
    return { static_cast<std::uint32_t>(next - first.begin() - 1),
      static_cast<vtkIdType>(point - *(next - 1)) };
  }

  // That of all parts, or double.
  int PointType() const
  {
    const auto typeOf = [](const InputPart& part) { return part.mesh->GetPoints()->GetDataType(); };
    const int type = typeOf(this->Parts[0]);
    const bool same = std::all_of(this->Parts.begin(), this->Parts.end(),
      [&](const InputPart& part) { return typeOf(part) == type; });
    return same ? type : VTK_DOUBLE;
  }

  void FillPoints(const std::vector<SharedArray>& arrays, bool weldByPlace, vtkPolyData& output)
  {
    if (const SharedArray* const ids = FindGlobalIds(arrays))
    {
      for (VertexId v = 0; v < this->Points.places.size(); ++v)
      {
        this->Points.ids.push_back(IdOf(*ids, this->TupleOf(v)));
      }
    }
    this->Points.hashOfArrays = [&](VertexId v) { return HashOfTuple(arrays, this->TupleOf(v)); };
    MergedPoints merged = MergePoints(this->Points, weldByPlace);
    vtkNew<vtkPoints> points;
    points->SetDataType(this->PointType());
    points->SetNumberOfPoints(static_cast<vtkIdType>(merged.kept.size()));
    std::vector<TupleOfPart> tuples;
    for (const VertexId v : merged.kept)
    {
      points->SetPoint(static_cast<vtkIdType>(tuples.size()), this->Points.places[v].data());
      tuples.push_back(this->TupleOf(v));
    }
    output.SetPoints(points);
    CopySharedArrays(arrays, tuples, *output.GetPointData());
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
    for (std::size_t kind = 0; kind < this->Cells.size(); ++kind)
    {
      const KeptCells& kept = this->Cells[kind];
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

  static const SharedArray* FindGlobalIds(const std::vector<SharedArray>& arrays)
  {
    const auto found = std::find_if(arrays.begin(), arrays.end(),
      [](const SharedArray& array) { return array.Is(vtkDataSetAttributes::GLOBALIDS); });
    return found != arrays.end() ? &*found : nullptr;
  }

  static std::int64_t IdOf(const SharedArray& ids, TupleOfPart tuple)
  {
    vtkAbstractArray* const array = ids.ofPart[tuple.part];
    auto* const plain = vtkIdTypeArray::SafeDownCast(array);
    return plain ? plain->GetValue(tuple.tuple) : array->GetVariantValue(tuple.tuple).ToTypeInt64();
  }

  // Whether no two cells have one id, of whatever kinds they are.
  bool AreDistinct(const SharedArray& ids) const
  {
    std::vector<std::int64_t> all;
    for (const KeptCells& kept : this->Cells)
    {
      std::transform(kept.from.begin(), kept.from.end(), std::back_inserter(all),
        [&](TupleOfPart cell) { return IdOf(ids, cell); });
    }
    std::sort(all.begin(), all.end());
    return std::adjacent_find(all.begin(), all.end()) == all.end();
  }

  // By id, or as they come where there are no ids.
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

  std::vector<InputPart> Parts;
  const Execution& Runs;
  PartPoints Points;
  std::vector<VertexId> NewPoint; // of each of all parts' points
  std::vector<bool> HasKeptCells; // of each part
  std::array<KeptCells, 4> Cells; // vertices, lines, polygons, strips
};

// One part without ghosts: itself, or all of it but arrays of a wrong length.
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

Result<std::vector<InputPart>> PartsOf(vtkDataObject& input)
{
  std::vector<InputPart> parts;
  if (auto* const whole = vtkPolyData::SafeDownCast(&input))
  {
    parts.push_back({ whole, "" });
    return parts;
  }
  auto* const tree = vtkDataObjectTree::SafeDownCast(&input);
  if (!tree)
  {
    return Error{ ErrorCode::InvalidInput,
      std::string("the input is a ") + input.GetClassName() + ", not a vtkPolyData" };
  }
  const bool isFlat = input.IsA("vtkPartitionedDataSet");
  const auto leaf = vtk::TakeSmartPointer(tree->NewTreeIterator());
  for (leaf->InitTraversal(); !leaf->IsDoneWithTraversal(); leaf->GoToNextItem())
  {
    vtkDataObject* const block = leaf->GetCurrentDataObject();
    const unsigned int index = leaf->GetCurrentFlatIndex();
    const std::string name =
      isFlat ? "partition " + std::to_string(index - 1) : "block " + std::to_string(index);
    auto* const mesh = vtkPolyData::SafeDownCast(block);
    if (!mesh && !IsEmpty(*block))
    {
      return Error{ ErrorCode::InvalidInput,
        name + " is a " + block->GetClassName() + ", not a vtkPolyData" };
    }
    if (mesh && mesh->GetNumberOfPoints() > 0)
    {
      parts.push_back({ mesh, name });
    }
  }
  return parts;
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
  Result<std::vector<InputPart>> parts = PartsOf(input);
  KDSTREAM_TRY(parts);
  if (parts->empty())
  {
    return JoinedPolyData{ vtkSmartPointer<vtkPolyData>::New(), {} };
  }
  vtkPolyData& first = *parts->front().mesh;
  if (parts->size() == 1 && !PointMarks(first).HasAny(notOwnPoint) &&
      !CellMarks(first).HasAny(notOwnCell))
  {
    return TakeWhole(first);
  }
  Joining joining(std::move(*parts), execution);
  KDSTREAM_TRY(joining.ReadAll());
  return joining.Join(weldByPlace);
}

}
