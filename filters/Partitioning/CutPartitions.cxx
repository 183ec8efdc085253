// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Partitioning/CutPartitions.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::size_t cutBatch = 64; // how many partitions are cut between reports of progress

const char* const partitionIdName = "PartitionId";

// Copies the tuples `from` of all arrays.
void CopyTuples(vtkDataSetAttributes* input, vtkIdList* from, vtkDataSetAttributes* output)
{
  const vtkIdType count = from->GetNumberOfIds();
  vtkNew<vtkIdList> to;
  to->SetNumberOfIds(count);
  std::iota(to->GetPointer(0), to->GetPointer(0) + count, vtkIdType{ 0 });
  output->CopyAllocate(input, count);
  output->CopyData(input, from, to);
}

// Sets `mark` in the ghost array where isMarked(i); marks from the input stay.
template <class IsMarked>
void MarkGhosts(
  vtkDataSetAttributes* attributes, std::size_t count, unsigned char mark, const IsMarked& isMarked)
{
  const char* const name = vtkDataSetAttributes::GhostArrayName();
  vtkSmartPointer<vtkUnsignedCharArray> ghosts =
    vtkUnsignedCharArray::SafeDownCast(attributes->GetAbstractArray(name));
  if (!ghosts || ghosts->GetNumberOfValues() != static_cast<vtkIdType>(count))
  {
    ghosts = vtkSmartPointer<vtkUnsignedCharArray>::New();
    ghosts->SetName(name);
    ghosts->SetNumberOfValues(static_cast<vtkIdType>(count));
    ghosts->FillValue(0);
    attributes->AddArray(ghosts);
  }
  for (std::size_t i = 0; i < count; ++i)
  {
    if (isMarked(i))
    {
      const auto id = static_cast<vtkIdType>(i);
      ghosts->SetValue(id, static_cast<unsigned char>(ghosts->GetValue(id) | mark));
    }
  }
}

// Turns partitions into vtkPolyData. Only reads the input: any number of threads may call Make at
// the same time.
class PartitionMaker
{
public:
  PartitionMaker(vtkPolyData& input, const PolyDataElements& elements,
    const PartitionLayout& layout, bool generateIds)
    : Input(input)
    , Elements(elements)
    , Layout(layout)
    , GenerateIds(generateIds)
    , AreCellsWhole(
        std::adjacent_find(elements.cells.begin(), elements.cells.end()) == elements.cells.end())
  {
  }

  vtkSmartPointer<vtkPolyData> Make(std::size_t partition) const
  {
    const PartitionPiece piece = this->Layout.Cut(partition);
    auto output = vtkSmartPointer<vtkPolyData>::New();
    this->FillPoints(piece, *output);
    this->FillCells(piece, *output);
    return output;
  }

private:
  void FillPoints(const PartitionPiece& piece, vtkPolyData& output) const
  {
    vtkNew<vtkIdList> from;
    from->SetNumberOfIds(static_cast<vtkIdType>(piece.vertices.size()));
    std::copy(piece.vertices.begin(), piece.vertices.end(), from->GetPointer(0));
    vtkNew<vtkPoints> points;
    points->SetDataType(this->Input.GetPoints()->GetDataType());
    points->SetNumberOfPoints(from->GetNumberOfIds());
    this->Input.GetPoints()->GetPoints(from, points);
    output.SetPoints(points);
    vtkPointData* const data = output.GetPointData();
    data->CopyGlobalIdsOn();
    CopyTuples(this->Input.GetPointData(), from, data);
    MarkGhosts(data, piece.vertices.size(), vtkDataSetAttributes::DUPLICATEPOINT,
      [&](std::size_t i) { return i >= piece.owned; });
    if (this->GenerateIds)
    {
      std::vector<std::uint32_t> partitionOf(piece.vertices.size());
      std::transform(piece.vertices.begin(), piece.vertices.end(), partitionOf.begin(),
        [&](VertexId v) { return this->Layout.PartitionOf(v); });
      data->AddArray(NewPartitionIds(partitionOf));
    }
  }

  void FillCells(const PartitionPiece& piece, vtkPolyData& output) const
  {
    vtkNew<vtkIdList> from;
    from->SetNumberOfIds(static_cast<vtkIdType>(piece.elements.size()));
    std::transform(piece.elements.begin(), piece.elements.end(), from->GetPointer(0),
      [&](std::uint32_t element) { return this->Elements.cells[element]; });
    // Elements ascend: vertices, segments, triangles, which is the order of cells in a vtkPolyData.
    const auto firstFrom = [&](std::size_t element)
    {
      const auto found = std::lower_bound(piece.elements.begin(), piece.elements.end(), element);
      return static_cast<std::size_t>(found - piece.elements.begin());
    };
    const std::size_t segments = firstFrom(this->Elements.vertices);
    const std::size_t triangles = firstFrom(this->Elements.vertices + this->Elements.segments);
    const std::span corners(piece.corners);
    output.SetVerts(MakeCells(corners.first(segments), 1));
    output.SetLines(MakeCells(corners.subspan(segments, triangles - segments), 2));
    output.SetPolys(MakeCells(corners.subspan(triangles), 3));
    vtkCellData* const data = output.GetCellData();
    data->SetCopyGlobalIds(this->AreCellsWhole);
    CopyTuples(this->Input.GetCellData(), from, data);
    MarkGhosts(data, piece.elements.size(), vtkDataSetAttributes::DUPLICATECELL,
      [&](std::size_t i) { return piece.duplicate[i] != 0; });
  }

  static vtkSmartPointer<vtkCellArray> MakeCells(std::span<const Triangle> elements, vtkIdType size)
  {
    auto cells = vtkSmartPointer<vtkCellArray>::New();
    const auto count = static_cast<vtkIdType>(elements.size());
    cells->AllocateExact(count, count * size);
    for (const Triangle& corners : elements)
    {
      const vtkIdType ids[] = { corners[0], corners[1], corners[2] };
      cells->InsertNextCell(size, ids);
    }
    return cells;
  }

  vtkPolyData& Input;
  const PolyDataElements& Elements;
  const PartitionLayout& Layout;
  bool GenerateIds, AreCellsWhole;
};

}

vtkSmartPointer<vtkIdTypeArray> NewPartitionIds(std::span<const std::uint32_t> partitionOf)
{
  auto ids = vtkSmartPointer<vtkIdTypeArray>::New();
  ids->SetName(partitionIdName);
  ids->SetNumberOfValues(static_cast<vtkIdType>(partitionOf.size()));
  std::copy(partitionOf.begin(), partitionOf.end(), ids->GetPointer(0));
  return ids;
}

Result<std::vector<vtkSmartPointer<vtkPolyData>>> CutPartitions(vtkPolyData& input,
  const PolyDataElements& elements, const PartitionLayout& layout, bool generateIds,
  std::size_t first, std::size_t end, const Execution& execution)
{
  const PartitionMaker maker(input, elements, layout, generateIds);
  std::vector<vtkSmartPointer<vtkPolyData>> made(end - first);
  for (std::size_t done = 0; done < made.size(); done += cutBatch)
  {
    const std::size_t batch = std::min(cutBatch, made.size() - done);
    execution.parallelFor(batch, 1,
      [&](std::size_t from, std::size_t to)
      {
        for (std::size_t i = done + from; i < done + to; ++i)
        {
          made[i] = maker.Make(first + i);
        }
      });
    KDSTREAM_TRY(execution.Report("partitions", double(done + batch) / double(made.size())));
  }
  return made;
}

}
