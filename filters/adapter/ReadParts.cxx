// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/ReadParts.h"

#include "filters/adapter/PolyDataCells.h"
#include "filters/adapter/PolyDataMesh.h"

#include <vtkCellData.h>
#include <vtkDataObjectTree.h>
#include <vtkDataObjectTreeIterator.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
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

// The marks in vtkGhostType, if a part has them.
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

// A mesh without points must not have cells that use points. Other meshes are checked while their
// cells are read.
Status CheckIfEmpty(vtkPolyData& mesh)
{
  return mesh.GetNumberOfPoints() > 0 ? Status() : CheckCells(mesh);
}

class Reading
{
public:
  Reading(const std::vector<InputPart>& parts, const Execution& execution)
    : Parts(parts)
    , Runs(execution)
  {
    this->Output.points.first.push_back(0);
  }

  Result<PartsRead> Run()
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
    return std::move(this->Output);
  }

private:
  Status Read(std::size_t part)
  {
    vtkPolyData& mesh = *this->Parts[part].mesh;
    const Result<std::vector<Vec3>> places = ReadPoints(mesh, this->Runs);
    KDSTREAM_TRY(places);
    const VertexId first = this->Output.points.first.back();
    if (places->size() >= noVertex - first)
    {
      return Error{ ErrorCode::LimitExceeded,
        "more than 4294967294 points: no more fit a tree in memory" };
    }
    this->Output.points.places.insert(
      this->Output.points.places.end(), places->begin(), places->end());
    this->Output.points.first.push_back(first + static_cast<VertexId>(places->size()));
    const Marks marks = PointMarks(mesh);
    std::vector<bool> isUsed(places->size()), isOfDropped(places->size());
    KDSTREAM_TRY(this->ReadCells(part, isUsed, isOfDropped));
    for (std::size_t i = 0; i < places->size(); ++i)
    {
      const auto point = static_cast<vtkIdType>(i);
      const bool mayGo = marks.Exist() ? marks.Has(point, notOwnPoint) : isOfDropped[i];
      this->Output.points.isCopy.push_back(marks.Has(point, copiedPoint));
      this->Output.points.isPresent.push_back(isUsed[i] || !mayGo);
    }
    return {};
  }

  Status ReadCells(std::size_t part, std::vector<bool>& isUsed, std::vector<bool>& isOfDropped)
  {
    vtkPolyData& mesh = *this->Parts[part].mesh;
    const Marks marks = CellMarks(mesh);
    const VertexId firstPoint = this->Output.points.first[part];
    bool anyKept = false;
    vtkIdType firstCell = 0;
    vtkCellArray* const ofKind[] = { mesh.GetVerts(), mesh.GetLines(), mesh.GetPolys(),
      mesh.GetStrips() };
    for (std::size_t kind = 0; kind < this->Output.cells.size(); ++kind)
    {
      KeptCells& kept = this->Output.cells[kind];
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
            anyKept = true;
          }
        }));
      firstCell += ofKind[kind]->GetNumberOfCells();
    }
    this->Output.pointData.push_back({ mesh.GetPointData(), mesh.GetNumberOfPoints() });
    this->Output.cellData.push_back({ mesh.GetCellData(), anyKept ? mesh.GetNumberOfCells() : 0 });
    this->Output.areFloats = this->Output.areFloats && mesh.GetPoints()->GetDataType() == VTK_FLOAT;
    return {};
  }

  const std::vector<InputPart>& Parts;
  const Execution& Runs;
  PartsRead Output;
};

}

Result<std::vector<InputPart>> PartsOf(vtkDataObject& input)
{
  std::vector<InputPart> parts;
  if (auto* const whole = vtkPolyData::SafeDownCast(&input))
  {
    KDSTREAM_TRY(CheckIfEmpty(*whole));
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
    if (mesh)
    {
      const Status checked = CheckIfEmpty(*mesh);
      if (!checked)
      {
        return Error{ checked.GetError().code, name + ": " + checked.GetError().message };
      }
    }
    if (mesh && mesh->GetNumberOfPoints() > 0)
    {
      parts.push_back({ mesh, name });
    }
  }
  return parts;
}

bool HasGhosts(vtkPolyData& part)
{
  return PointMarks(part).HasAny(notOwnPoint) || CellMarks(part).HasAny(notOwnCell);
}

TupleOfPart PartsRead::TupleOf(VertexId point) const
{
  const auto& first = this->points.first;
  const auto next = std::upper_bound(first.begin(), first.end(), point);
  return { static_cast<std::uint32_t>(next - first.begin() - 1),
    static_cast<vtkIdType>(point - *(next - 1)) };
}

Result<PartsRead> ReadParts(const std::vector<InputPart>& parts, const Execution& execution)
{
  return Reading(parts, execution).Run();
}

}
