// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. the input as one mesh, its points and cells in core's types  2. the subclass: whose
// each point is  3. who goes where (PartitionLayout)  4. each partition's arrays.
#include "vtkMeshPartition.h"

#include "filters/Partitioning/MeshPartitionWork.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/PartitionLayout.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkErrorCode.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <numeric>
#include <vector>

KDSTREAM_SET_IN_RANGE(vtkMeshPartition, VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX)
KDSTREAM_SET_IN_RANGE(vtkMeshPartition, NumberOfPartitions, vtkIdType, 0, 1 << 30)

namespace
{

using namespace kdstream;

constexpr std::size_t cutBatch = 64; // partitions cut before progress is reported

const char* const partitionIdName = "PartitionId";

vtkSmartPointer<vtkIdTypeArray> NewPartitionIds(std::size_t points)
{
  auto ids = vtkSmartPointer<vtkIdTypeArray>::New();
  ids->SetName(partitionIdName);
  ids->SetNumberOfValues(static_cast<vtkIdType>(points));
  return ids;
}

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

// Sets `mark` in the ghost array where isMarked(i), beside the marks that came from the input.
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

// Turns one partition after the other into a vtkPolyData. Reads the input only: any number of
// threads may call Make at once.
class PartitionMaker
{
public:
  PartitionMaker(vtkPolyData& input, const PolyDataElements& elements,
    const PartitionLayout& layout, bool generateIds)
    : Input(input)
    , Elements(elements)
    , Layout(layout)
    , GenerateIds(generateIds)
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
      const auto ids = NewPartitionIds(piece.vertices.size());
      std::transform(piece.vertices.begin(), piece.vertices.end(), ids->GetPointer(0),
        [&](VertexId v) { return vtkIdType{ this->Layout.PartitionOf(v) }; });
      data->AddArray(ids);
    }
  }

  void FillCells(const PartitionPiece& piece, vtkPolyData& output) const
  {
    vtkNew<vtkIdList> from;
    from->SetNumberOfIds(static_cast<vtkIdType>(piece.elements.size()));
    std::transform(piece.elements.begin(), piece.elements.end(), from->GetPointer(0),
      [&](std::uint32_t element) { return this->Elements.cells[element]; });
    // Elements ascend: vertices, segments, triangles, the order of a vtkPolyData's cells.
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
    const auto elements = static_cast<vtkIdType>(this->Elements.corners.size());
    data->SetCopyGlobalIds(elements == this->Input.GetNumberOfCells());
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
  bool GenerateIds;
};

// Cuts all partitions, batch after batch.
Result<std::vector<vtkSmartPointer<vtkPolyData>>> MakeAll(
  const PartitionMaker& maker, std::size_t count, const Execution& execution)
{
  std::vector<vtkSmartPointer<vtkPolyData>> made(count);
  for (std::size_t first = 0; first < count; first += cutBatch)
  {
    const std::size_t batch = std::min(cutBatch, count - first);
    execution.parallelFor(batch, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = first + begin; i < first + end; ++i)
        {
          made[i] = maker.Make(i);
        }
      });
    KDSTREAM_TRY(execution.Report("partitions", double(first + batch) / double(count)));
  }
  return made;
}

}

vtkMeshPartition::vtkMeshPartition()
{
  this->SetNumberOfOutputPorts(2);
}

int vtkMeshPartition::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

int vtkMeshPartition::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPartitionedDataSet" : "vtkPolyData");
  return 1;
}

int vtkMeshPartition::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  this->SetErrorCode(vtkErrorCode::NoError);
  const Execution execution = MakeAlgorithmExecution(
    *this, { { "tree", 0.05, 0.5 }, { "octree", 0.05, 0.5 }, { "faces", 0.05, 0.2 },
             { "seeds", 0.2, 0.2 }, { "k-means", 0.2, 0.5 }, { "partitions", 0.5, 1.0 } });
  const auto fail = [this](const Error& error)
  {
    this->SetErrorCode(ReportError(*this, error));
    return error.code == ErrorCode::Cancelled ? 1 : 0;
  };
  const auto joined =
    JoinInput(*this, *vtkDataObject::GetData(inputVector[0]), this->WeldByPlace, execution);
  if (!joined)
  {
    return fail(joined.GetError());
  }
  vtkPolyData* const input = *joined;
  if (input->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  const Result<std::vector<Vec3>> points = ReadPoints(*input, execution);
  if (!points)
  {
    return fail(points.GetError());
  }
  const Result<PolyDataElements> elements = ReadElements(*input);
  if (!elements)
  {
    return fail(elements.GetError());
  }
  MeshPartitionWork work{ *points, elements->Triangles(),
    static_cast<std::uint32_t>(this->VerticesPerPartition), {}, execution };
  if (this->NumberOfPartitions > 0)
  {
    work.wantedPartitions = static_cast<std::uint32_t>(this->NumberOfPartitions);
  }
  this->AssignPoints(work);
  if (!work.status)
  {
    return fail(work.status.GetError());
  }
  const PartitionLayout layout(std::move(work.partitionOf), work.partitions, elements->corners);
  const PartitionMaker maker(*input, *elements, layout, this->GeneratePartitionIds);
  const auto made = MakeAll(maker, work.partitions, execution);
  if (!made)
  {
    return fail(made.GetError());
  }

  vtkPartitionedDataSet* const partitions = vtkPartitionedDataSet::GetData(outputVector, 0);
  partitions->SetNumberOfPartitions(static_cast<unsigned int>(made->size()));
  for (std::size_t i = 0; i < made->size(); ++i)
  {
    partitions->SetPartition(static_cast<unsigned int>(i), (*made)[i]);
  }
  vtkPolyData* const labelled = vtkPolyData::GetData(outputVector, 1);
  labelled->ShallowCopy(input);
  if (this->GeneratePartitionIds)
  {
    const auto ids = NewPartitionIds(points->size());
    for (std::size_t i = 0; i < points->size(); ++i)
    {
      ids->SetValue(
        static_cast<vtkIdType>(i), vtkIdType{ layout.PartitionOf(static_cast<VertexId>(i)) });
    }
    labelled->GetPointData()->AddArray(ids);
  }
  return 1;
}

void vtkMeshPartition::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "VerticesPerPartition: " << this->VerticesPerPartition << "\n";
  os << indent << "NumberOfPartitions: " << this->NumberOfPartitions << "\n";
  os << indent << "GeneratePartitionIds: " << (this->GeneratePartitionIds ? "on" : "off") << "\n";
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
}
