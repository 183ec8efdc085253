// SPDX-License-Identifier: BSD-3-Clause
// TestRankPipelines runs this on the ranks of a job. Each rank has a part of a mesh, and gets its
// partitions of one tree over all parts. These must equal, bit for bit, the partitions that one
// process makes of the whole mesh.
//   RankPipelines CASE FOLDER [MESH]; exit code 1 and a line for each difference.
#include "filters/adapter/Testing/FilterTools.h"

#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkKdMeshReader.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdTreePartition.h>
#include <vtkMPIController.h>
#include <vtkObjectFactory.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPolyDataAlgorithm.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>

namespace
{

using namespace kdstream::testing;

int rank = 0, ranks = 1, failures = 0;

void Expect(bool holds, const std::string& what)
{
  if (!holds)
  {
    std::cerr << "rank " << rank << " of " << ranks << ": " << what << std::endl;
    ++failures;
  }
}

bool AreSame(vtkDataArray* a, vtkDataArray* b)
{
  if (!a || !b)
  {
    return a == b;
  }
  const auto bytes = static_cast<std::size_t>(a->GetNumberOfValues() * a->GetDataTypeSize());
  return a->GetDataType() == b->GetDataType() && a->GetNumberOfValues() == b->GetNumberOfValues() &&
         a->GetNumberOfComponents() == b->GetNumberOfComponents() &&
         std::memcmp(a->GetVoidPointer(0), b->GetVoidPointer(0), bytes) == 0;
}

bool AreSame(vtkCellArray* a, vtkCellArray* b)
{
  return a->GetNumberOfCells() == b->GetNumberOfCells() &&
         (a->GetNumberOfCells() == 0 ||
           (AreSame(a->GetConnectivityArray(), b->GetConnectivityArray()) &&
             AreSame(a->GetOffsetsArray(), b->GetOffsetsArray())));
}

bool AreSame(vtkDataSetAttributes* a, vtkDataSetAttributes* b)
{
  bool same = a->GetNumberOfArrays() == b->GetNumberOfArrays();
  for (int i = 0; same && i < a->GetNumberOfArrays(); ++i)
  {
    same = std::strcmp(a->GetArrayName(i), b->GetArrayName(i)) == 0 &&
           AreSame(a->GetArray(i), b->GetArray(i)) &&
           a->IsArrayAnAttribute(i) == b->IsArrayAnAttribute(i);
  }
  return same;
}

bool AreSame(vtkPolyData* a, vtkPolyData* b)
{
  return AreSame(a->GetPoints()->GetData(), b->GetPoints()->GetData()) &&
         AreSame(a->GetVerts(), b->GetVerts()) && AreSame(a->GetLines(), b->GetLines()) &&
         AreSame(a->GetPolys(), b->GetPolys()) && AreSame(a->GetPointData(), b->GetPointData()) &&
         AreSame(a->GetCellData(), b->GetCellData());
}

using IdOf = std::function<vtkIdType(vtkIdType number, vtkIdType count)>;

void AddGlobalIds(
  vtkPolyData* mesh, const IdOf& idOf = [](vtkIdType i, vtkIdType) { return i; })
{
  const auto add = [&](vtkDataSetAttributes* data, vtkIdType count)
  {
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName("GlobalIds");
    for (vtkIdType i = 0; i < count; ++i)
    {
      ids->InsertNextValue(idOf(i, count));
    }
    data->SetGlobalIds(ids);
  };
  add(mesh->GetPointData(), mesh->GetNumberOfPoints());
  add(mesh->GetCellData(), mesh->GetNumberOfCells());
}

vtkCellArray* CellsOfKind(vtkPolyData* mesh, int kind)
{
  vtkCellArray* const kinds[] = { mesh->GetVerts(), mesh->GetLines(), mesh->GetPolys(),
    mesh->GetStrips() };
  return kinds[kind];
}

int KindOf(vtkPolyData* mesh, vtkIdType cell)
{
  int kind = 0;
  while (cell >= CellsOfKind(mesh, kind)->GetNumberOfCells())
  {
    cell -= CellsOfKind(mesh, kind++)->GetNumberOfCells();
  }
  return kind;
}

// vtkPolyData does not allow polygons of two points, but its arrays can hold them.
Ids CornersOf(vtkPolyData* mesh, vtkIdType cell)
{
  int kind = 0;
  while (cell >= CellsOfKind(mesh, kind)->GetNumberOfCells())
  {
    cell -= CellsOfKind(mesh, kind++)->GetNumberOfCells();
  }
  vtkNew<vtkIdList> corners;
  CellsOfKind(mesh, kind)->GetCellAtId(cell, corners);
  return Ids(corners->begin(), corners->end());
}

void CopyTuples(vtkDataSetAttributes* from, const Ids& which, vtkDataSetAttributes* to)
{
  to->CopyGlobalIdsOn();
  to->CopyAllocate(from, static_cast<vtkIdType>(which.size()));
  for (std::size_t i = 0; i < which.size(); ++i)
  {
    to->CopyData(from, which[i], static_cast<vtkIdType>(i));
  }
}

// Makes a mesh of these points and cells; both lists are in ascending order.
PolyData Extract(vtkPolyData* whole, const Ids& points, const Ids& cells)
{
  const auto part = PolyData::New();
  vtkNew<vtkPoints> places;
  places->SetDataType(whole->GetPoints()->GetDataType());
  for (const vtkIdType point : points)
  {
    places->InsertNextPoint(whole->GetPoint(point));
  }
  part->SetPoints(places);
  vtkNew<vtkCellArray> kinds[4];
  Ids newIds(static_cast<std::size_t>(whole->GetNumberOfPoints()), -1);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    newIds[static_cast<std::size_t>(points[i])] = static_cast<vtkIdType>(i);
  }
  for (const vtkIdType cell : cells)
  {
    Ids corners = CornersOf(whole, cell);
    for (vtkIdType& corner : corners)
    {
      corner = newIds[static_cast<std::size_t>(corner)];
    }
    AddCell(kinds[KindOf(whole, cell)], corners);
  }
  part->SetVerts(kinds[0]);
  part->SetLines(kinds[1]);
  part->SetPolys(kinds[2]);
  part->SetStrips(kinds[3]);
  CopyTuples(whole->GetPointData(), points, part->GetPointData());
  CopyTuples(whole->GetCellData(), cells, part->GetCellData());
  return part;
}

void Mark(vtkDataSetAttributes* data, vtkIdType count, const std::vector<bool>& isGhost)
{
  vtkNew<vtkUnsignedCharArray> marks;
  marks->SetName(vtkDataSetAttributes::GhostArrayName());
  for (vtkIdType i = 0; i < count; ++i)
  {
    marks->InsertNextValue(isGhost[static_cast<std::size_t>(i)] ? 1 : 0);
  }
  data->AddArray(marks);
}

// The part of a mesh that rank `of` has. Every cell, with its points, is in one part; points
// without cells are distributed, too. ghosts: each part also has some of the next rank's cells,
// marked as ghosts. none: a rank that has nothing. shares: the number of parts, which can differ
// from the number of ranks.
struct Sharing
{
  bool ghosts = false;
  int none = -1;
  int shares = ranks;
};

PolyData ShareOf(vtkPolyData* whole, int of, const Sharing& sharing)
{
  std::vector<int> having;
  for (int each = 0; each < sharing.shares; ++each)
  {
    if (each != sharing.none)
    {
      having.push_back(each);
    }
  }
  const vtkIdType cells = whole->GetNumberOfCells(), points = whole->GetNumberOfPoints();
  const auto count = static_cast<vtkIdType>(having.size());
  const auto isAt = [&](vtkIdType place, vtkIdType all)
  { return having[static_cast<std::size_t>(place * count / all)] == of; };
  Ids own, ids;
  std::vector<bool> isGhost, used(static_cast<std::size_t>(points)), here(used), usedByOwn(used);
  for (vtkIdType cell = 0; cell < cells; ++cell)
  {
    const bool isOwn = isAt(cell, cells);
    const bool isNear = sharing.ghosts && cell >= 20 && isAt(cell - 20, cells);
    for (const vtkIdType corner : CornersOf(whole, cell))
    {
      const auto point = static_cast<std::size_t>(corner);
      used[point] = true;
      here[point] = here[point] || isOwn || isNear;
      usedByOwn[point] = usedByOwn[point] || isOwn;
    }
    if (isOwn || isNear)
    {
      own.push_back(cell);
      isGhost.push_back(!isOwn);
    }
  }
  for (vtkIdType i = 0; i < points; ++i)
  {
    const auto point = static_cast<std::size_t>(i);
    const bool isAlone = !used[point] && isAt(i, points);
    usedByOwn[point] = usedByOwn[point] || isAlone;
    if (here[point] || isAlone)
    {
      ids.push_back(i);
    }
  }
  const PolyData part = of == sharing.none ? PolyData::New() : Extract(whole, ids, own);
  if (sharing.ghosts && of != sharing.none)
  {
    std::vector<bool> pointGhosts;
    for (const vtkIdType id : ids)
    {
      pointGhosts.push_back(!usedByOwn[static_cast<std::size_t>(id)]);
    }
    Mark(part->GetPointData(), part->GetNumberOfPoints(), pointGhosts);
    Mark(part->GetCellData(), part->GetNumberOfCells(), isGhost);
  }
  return part;
}

// Joins parts into one mesh, in order: their points, and their cells kind by kind.
PolyData Join(const std::vector<PolyData>& parts)
{
  const auto whole = PolyData::New();
  vtkNew<vtkPoints> places;
  vtkNew<vtkCellArray> kinds[4];
  vtkIdType points = 0, cells = 0;
  PolyData first = parts[0];
  for (const PolyData& part : parts)
  {
    first = first->GetNumberOfPoints() == 0 ? part : first;
    points += part->GetNumberOfPoints();
    cells += part->GetNumberOfCells();
  }
  places->SetDataType(first->GetPoints()->GetDataType());
  whole->GetPointData()->CopyAllocate(first->GetPointData(), points);
  whole->GetCellData()->CopyAllocate(first->GetCellData(), cells);
  cells = 0;
  for (int kind = 0; kind < 4; ++kind)
  {
    vtkIdType before = 0;
    for (const PolyData& part : parts)
    {
      for (vtkIdType cell = 0; cell < part->GetNumberOfCells(); ++cell)
      {
        if (KindOf(part, cell) == kind)
        {
          Ids corners = CornersOf(part, cell);
          for (vtkIdType& corner : corners)
          {
            corner += before;
          }
          AddCell(kinds[kind], corners);
          whole->GetCellData()->CopyData(part->GetCellData(), cell, cells++);
        }
      }
      before += part->GetNumberOfPoints();
    }
  }
  for (const PolyData& part : parts)
  {
    for (vtkIdType point = 0; point < part->GetNumberOfPoints(); ++point)
    {
      whole->GetPointData()->CopyData(
        part->GetPointData(), point, places->InsertNextPoint(part->GetPoint(point)));
    }
  }
  whole->SetPoints(places);
  whole->SetVerts(kinds[0]);
  whole->SetLines(kinds[1]);
  whole->SetPolys(kinds[2]);
  whole->SetStrips(kinds[3]);
  return whole;
}

vtkSmartPointer<vtkKdTreePartition> Partition(vtkDataObject* input, vtkIdType size, bool alone)
{
  auto filter = vtkSmartPointer<vtkKdTreePartition>::New();
  if (alone)
  {
    filter->SetController(nullptr);
  }
  filter->SetInputDataObject(input);
  filter->SetVerticesPerPartition(size);
  filter->GeneratePartitionIdsOn();
  filter->Update();
  return filter;
}

vtkPolyData* PartitionAt(vtkKdTreePartition* filter, unsigned int i)
{
  return vtkPolyData::SafeDownCast(filter->GetOutput()->GetPartition(i));
}

// Checks that this rank's partitions equal those of one process, and that it has no others. first:
// the number of this rank's first point, if its global ids count only its own points; -1: the ids
// are other numbers.
void ComparePartitions(vtkDataObject* own, vtkPolyData* whole, vtkIdType size, vtkIdType first = 0)
{
  const auto together = Partition(own, size, false), one = Partition(whole, size, true);
  const auto count = one->GetOutput()->GetNumberOfPartitions();
  Expect(count > static_cast<unsigned int>(2 * ranks), "too few partitions to compare");
  Expect(together->GetOutput()->GetNumberOfPartitions() == count, "the number of partitions");
  for (unsigned int i = 0; i < count; ++i)
  {
    vtkPolyData* const here = PartitionAt(together, i);
    const bool isOwn = static_cast<int>(i) * ranks / static_cast<int>(count) == rank;
    Expect((here != nullptr) == isOwn, "who has partition " + std::to_string(i));
    Expect(!here || AreSame(here, PartitionAt(one, i)), "partition " + std::to_string(i));
  }
  // Port 1 without port 0 must give the same partitions to points.
  together->Modified();
  together->Update(1);
  const auto ids = vtkPolyData::SafeDownCast(together->GetOutputDataObject(1));
  vtkDataArray* const numbers = ids->GetPointData()->GetGlobalIds();
  const auto all = vtkPolyData::SafeDownCast(one->GetOutputDataObject(1));
  for (vtkIdType i = 0; numbers && first >= 0 && i < ids->GetNumberOfPoints(); ++i)
  {
    const auto number = first + static_cast<vtkIdType>(numbers->GetComponent(i, 0));
    Expect(ids->GetPointData()->GetArray("PartitionId")->GetComponent(i, 0) ==
             all->GetPointData()->GetArray("PartitionId")->GetComponent(number, 0),
      "the partition of point " + std::to_string(number));
  }
}

void CompareByIds(vtkPolyData* whole, vtkIdType size, const Sharing& sharing)
{
  AddGlobalIds(whole);
  ComparePartitions(ShareOf(whole, rank, sharing), whole, size);
}

// Each rank has two blocks, with ghosts.
void CompareBlocks(vtkPolyData* whole, vtkIdType size)
{
  AddGlobalIds(whole);
  vtkNew<vtkPartitionedDataSet> blocks;
  blocks->SetPartition(0, ShareOf(whole, 2 * rank, { true, -1, 2 * ranks }));
  blocks->SetPartition(1, ShareOf(whole, 2 * rank + 1, { true, -1, 2 * ranks }));
  ComparePartitions(blocks, whole, size);
}

// Without ids, no two points are the same, so the whole mesh is the shares, one after the other.
void CompareInTurn(vtkPolyData* whole, vtkIdType size, const Sharing& sharing)
{
  std::vector<PolyData> shares;
  for (int each = 0; each < ranks; ++each)
  {
    shares.push_back(ShareOf(whole, each, sharing));
  }
  ComparePartitions(shares[static_cast<std::size_t>(rank)], Join(shares), size);
}

void SetInactive(vtkDataSetAttributes* data)
{
  data->SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
}

// If each rank counts its ids from the beginning, they have no meaning. The whole mesh is then the
// shares, one after the other, and the array of these ids is an ordinary array.
void CompareRestartedIds(vtkPolyData* whole, vtkIdType size)
{
  std::vector<PolyData> shares;
  vtkIdType first = 0;
  for (int each = 0; each < ranks; ++each)
  {
    shares.push_back(ShareOf(whole, each, {}));
    first += each < rank ? shares.back()->GetNumberOfPoints() : 0;
    AddGlobalIds(shares.back());
    SetInactive(shares.back()->GetPointData());
    SetInactive(shares.back()->GetCellData());
  }
  const PolyData all = Join(shares), own = shares[static_cast<std::size_t>(rank)];
  AddGlobalIds(own);
  ComparePartitions(own, all, size, first);
}

// The same for the ids of cells, if points have valid ids.
void CompareRestartedCellIds(vtkPolyData* whole, vtkIdType size)
{
  AddGlobalIds(whole);
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("GlobalIds");
  PolyData own;
  for (int each = 0; each < ranks; ++each)
  {
    const PolyData share = ShareOf(whole, each, {});
    AddGlobalIds(share);
    ids->InsertTuples(
      ids->GetNumberOfTuples(), share->GetNumberOfCells(), 0, share->GetCellData()->GetGlobalIds());
    own = each == rank ? share : own;
  }
  const PolyData points = ShareOf(whole, rank, {});
  own->GetPointData()->ShallowCopy(points->GetPointData());
  whole->GetCellData()->SetGlobalIds(ids);
  SetInactive(whole->GetCellData());
  ComparePartitions(own, whole, size);
}

// Ids must be compared to the last bit.
void CompareHighCellIds(vtkPolyData* whole, vtkIdType size)
{
  AddGlobalIds(whole);
  auto* const ids = vtkIdTypeArray::SafeDownCast(whole->GetCellData()->GetGlobalIds());
  for (vtkIdType i = 0; i < ids->GetNumberOfValues(); ++i)
  {
    ids->SetValue(i, (vtkIdType{ 1 } << 60) + i);
  }
  ComparePartitions(ShareOf(whole, rank, {}), whole, size);
}

// Ids of any size: negative ones, one far from all others, and multiples of many numbers of ranks.
const std::vector<IdOf>& StrayIds()
{
  constexpr vtkIdType far = vtkIdType{ 1 } << 62;
  static const std::vector<IdOf> kinds{
    [](vtkIdType i, vtkIdType count) { return i < count - 1 ? i : far; },
    [](vtkIdType i, vtkIdType count) { return i > 0 ? i - count : -far; },
    [](vtkIdType i, vtkIdType) { return 12 * i - (vtkIdType{ 1 } << 40); },
  };
  return kinds;
}

void CompareStrayIds(vtkPolyData* whole, vtkIdType size)
{
  for (const IdOf& idOf : StrayIds())
  {
    AddGlobalIds(whole, idOf);
    ComparePartitions(ShareOf(whole, rank, {}), whole, size, -1);
  }
}

// The arrays of cells are those of the ranks that have cells.
void CompareArrays(vtkPolyData* whole, vtkIdType size)
{
  AddGlobalIds(whole);
  PolyData own = ShareOf(whole, rank, { false, ranks - 1 });
  if (rank == ranks - 1)
  {
    own = Extract(whole, { 0, 1, 2, 3 }, {});
    own->GetCellData()->Initialize();
  }
  ComparePartitions(own, whole, size);
}

// A cell that was cut up, and one that has no elements, must not count as two whole cells.
void ExpectNoIdsOfCutCells()
{
  const PolyData whole = MakePlate(20);
  AddCell(whole->GetPolys(), { 18, 19, 39, 38 });
  AddCell(whole->GetPolys(), { 5, 6 });
  whole->GetPointData()->Initialize();
  whole->GetCellData()->Initialize();
  AddIds(*whole);
  AddGlobalIds(whole);
  const PolyData own = ShareOf(whole, rank, {});
  ComparePartitions(own, whole, 20);
  const auto together = Partition(own, 20, false);
  for (unsigned int i = 0; i < together->GetOutput()->GetNumberOfPartitions(); ++i)
  {
    vtkPolyData* const here = PartitionAt(together, i);
    Expect(!here || !here->GetCellData()->GetGlobalIds(), "ids of cells that were cut up");
  }
}

// An error in one rank's input: all ranks must report it, and none may wait for ever.
void ExpectErrorOfInput(const std::string& folder)
{
  vtkNew<vtkKdMeshReader> reader;
  FilterObserver unheard(reader);
  reader->SetFileName((folder + "/missing.ply").c_str());
  vtkNew<vtkKdTreePartition> filter;
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetFileName((folder + "/model.kds").c_str());
  for (vtkAlgorithm* const each :
    { static_cast<vtkAlgorithm*>(filter.Get()), static_cast<vtkAlgorithm*>(writer.Get()) })
  {
    rank == 1 ? each->SetInputConnection(reader->GetOutputPort())
              : each->SetInputDataObject(MakeSphere(20));
    for (int time = 0; time < 2; ++time)
    {
      FilterObserver heard(each);
      each == writer.Get() ? void(writer->Write()) : each->Update();
      Expect(heard.error.find("its input could not be made (rank 1 on ") != std::string::npos,
        "the error is " + heard.error);
      Expect(each->GetErrorCode() != 0, "no error code");
    }
  }
  Expect(filter->GetOutput()->GetNumberOfPartitions() == 0, "there is an output");
}

// Process 0 writes, so only its file name counts.
void ExpectNameOfFirst(const std::string& folder, vtkMPIController* controller)
{
  const std::string file = folder + "/named.kds";
  for (const int named : { 1, 0 })
  {
    vtkNew<vtkKdStoreWriter> writer;
    FilterObserver heard(writer);
    writer->SetInputData(rank == 0 ? MakeSphere(20) : PolyData::New());
    if (rank == named)
    {
      writer->SetFileName(file.c_str());
    }
    Expect(writer->Write() == (named == 0 ? 1 : 0), "who has the name: " + std::to_string(named));
    Expect(
      (heard.error.find("no FileName is set (rank 0 on ") != std::string::npos) == (named == 1),
      "the error is " + heard.error);
    controller->Barrier();
    Expect(std::ifstream(file).good() == (named == 0), "the file");
  }
}

// All ranks must report an error of one rank, and none may wait for ever.
void ExpectErrorOfAll()
{
  const PolyData input = MakeSphere(20);
  if (rank == 1)
  {
    input->GetPoints()->SetPoint(7, 0, std::numeric_limits<double>::quiet_NaN(), 0);
  }
  vtkNew<vtkKdTreePartition> filter;
  FilterObserver heard(filter);
  filter->SetInputData(input);
  filter->Update();
  const std::string said = "point 7: a coordinate is not finite (rank 1 on ";
  Expect(heard.error.find(said) != std::string::npos, "the error is " + heard.error);
  Expect(filter->GetOutput()->GetNumberOfPartitions() == 0, "there is an output");
  vtkNew<vtkKdStoreWriter> writer;
  FilterObserver heardWriter(writer);
  writer->SetInputData(input);
  writer->SetFileName("/nonexistent/folder/model.kds");
  Expect(writer->Write() == 0, "a store of points that are not finite");
  Expect(heardWriter.error.find("point 7: a coordinate is not finite") != std::string::npos,
    "the error is " + heardWriter.error);
  writer->SetInputData(MakeSphere(20));
  Expect(writer->Write() == 0, "a store where there is no folder");
  Expect(writer->GetErrorCode() != 0, "no error code");
}

// Only arrays of numbers are sent to other ranks. Each rank that has an array of texts must warn.
void ExpectWarningOfTexts(const std::string& folder)
{
  const PolyData whole = MakeSphere(40);
  AddGlobalIds(whole);
  const PolyData input = ShareOf(whole, rank, {});
  for (vtkDataSetAttributes* const data :
    { static_cast<vtkDataSetAttributes*>(input->GetPointData()),
      static_cast<vtkDataSetAttributes*>(input->GetCellData()) })
  {
    vtkNew<vtkStringArray> texts;
    texts->SetName(data == input->GetPointData() ? "Names" : "Kinds");
    texts->SetNumberOfValues(data->GetNumberOfTuples());
    data->AddArray(texts);
  }
  const auto heardOfBoth = [](const FilterObserver& heard, const std::string& by)
  {
    Expect(heard.error.empty(), by + ": " + heard.error);
    for (const char* const name : { "\"Names\"", "\"Kinds\"" })
    {
      Expect(heard.warning.find(name) != std::string::npos, by + " warns: " + heard.warning);
    }
  };
  vtkNew<vtkKdTreePartition> filter;
  filter->SetInputData(input);
  filter->SetVerticesPerPartition(50);
  {
    const FilterObserver heard(filter);
    filter->Update();
    heardOfBoth(heard, "the filter");
  }
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputData(input);
  writer->SetFileName((folder + "/model.kds").c_str());
  const FilterObserver heard(writer);
  Expect(writer->Write() == 1, "no store");
  heardOfBoth(heard, "the writer");
}

std::string ContentOf(const std::string& file)
{
  std::ifstream stream(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

// The store that all ranks write together must equal that of one process.
void CompareStores(const std::string& folder, vtkMPIController* controller)
{
  const PolyData whole = MakeSphere(60);
  AddGlobalIds(whole);
  const auto write = [&](vtkPolyData* input, const std::string& file, bool alone)
  {
    const auto partition = Partition(input, 200, alone);
    vtkNew<vtkKdStoreWriter> writer;
    if (alone)
    {
      writer->SetController(nullptr);
    }
    writer->SetInputConnection(partition->GetOutputPort());
    writer->SetVerticesPerPartition(100);
    writer->SetTitle("one title");
    writer->SetFileName(file.c_str());
    Expect(writer->Write() == 1, "no " + file);
  };
  const std::string together = folder + "/model.kds", one = folder + "/one/model.kds";
  write(ShareOf(whole, rank, {}), together, false);
  // Blocks without points may be of any type, as on one process.
  vtkNew<vtkPartitionedDataSet> blocks;
  blocks->SetPartition(0, vtkSmartPointer<vtkUnstructuredGrid>::New());
  blocks->SetPartition(1, ShareOf(whole, rank, {}));
  vtkNew<vtkKdStoreWriter> ofBlocks;
  ofBlocks->SetInputDataObject(blocks);
  ofBlocks->SetFileName((folder + "/blocks.kds").c_str());
  Expect(ofBlocks->Write() == 1, "no store of blocks");
  controller->Barrier();
  if (rank == 0)
  {
    write(whole, one, true);
    const std::string content = ContentOf(together);
    Expect(content.size() > 10000 && content == ContentOf(one), "the stores differ");
  }
}

using Parts = std::vector<PolyData>;
using SetUpWriter = std::function<void(vtkKdStoreWriter&)>;

// The store of the ranks' parts must equal, byte for byte, that of all these parts on one process.
void CompareStoreOfParts(const std::string& what, const std::string& folder,
  vtkMPIController* controller, const std::vector<Parts>& ofRanks, const SetUpWriter& setUp = {})
{
  const auto blocksOf = [](const std::vector<Parts>& all)
  {
    auto blocks = vtkSmartPointer<vtkPartitionedDataSet>::New();
    for (const Parts& parts : all)
    {
      for (const PolyData& part : parts)
      {
        blocks->SetPartition(blocks->GetNumberOfPartitions(), part);
      }
    }
    return blocks;
  };
  const auto write = [&](vtkDataObject* input, const std::string& file, bool alone)
  {
    vtkNew<vtkKdStoreWriter> writer;
    if (alone)
    {
      writer->SetController(nullptr);
    }
    writer->SetInputDataObject(input);
    writer->SetVerticesPerPartition(50);
    if (setUp)
    {
      setUp(*writer);
    }
    writer->SetFileName(file.c_str());
    const FilterObserver heard(writer);
    Expect(writer->Write() == 1, what + ": no " + file + ": " + heard.error);
  };
  const std::string together = folder + "/model.kds", one = folder + "/one/model.kds";
  write(blocksOf({ ofRanks[static_cast<std::size_t>(rank)] }), together, false);
  controller->Barrier();
  if (rank == 0)
  {
    write(blocksOf(ofRanks), one, true);
    const std::string content = ContentOf(together);
    Expect(content.size() > 1000 && content == ContentOf(one), what + ": the stores differ");
  }
  controller->Barrier();
}

std::vector<Parts> SharesOf(vtkPolyData* whole, const Sharing& sharing)
{
  std::vector<Parts> shares;
  for (int each = 0; each < ranks; ++each)
  {
    shares.push_back({ ShareOf(whole, each, sharing) });
  }
  return shares;
}

// Two blocks for each rank, with ghosts.
std::vector<Parts> BlocksOf(vtkPolyData* whole)
{
  std::vector<Parts> blocks;
  for (int each = 0; each < ranks; ++each)
  {
    blocks.push_back({ ShareOf(whole, 2 * each, { true, -1, 2 * ranks }),
      ShareOf(whole, 2 * each + 1, { true, -1, 2 * ranks }) });
  }
  return blocks;
}

PolyData WithIds(PolyData mesh)
{
  AddGlobalIds(mesh);
  return mesh;
}

void CompareStoresOfStrayIds(const std::string& folder, vtkMPIController* controller)
{
  const PolyData whole = MakeSphere(30);
  std::vector<IdOf> kinds = StrayIds();
  kinds.push_back([](vtkIdType, vtkIdType) { return 5; }); // no valid ids
  for (const IdOf& idOf : kinds)
  {
    AddGlobalIds(whole, idOf);
    CompareStoreOfParts("stray ids", folder, controller, SharesOf(whole, {}),
      [](vtkKdStoreWriter& writer) { writer.SetGridBits(0); });
  }
}

void CompareStoresOfParts(const std::string& folder, vtkMPIController* controller)
{
  const auto compare =
    [&](const std::string& what, const std::vector<Parts>& parts, const SetUpWriter& setUp = {})
  { CompareStoreOfParts(what, folder, controller, parts, setUp); };
  const auto keepAll = [](vtkKdStoreWriter& writer)
  {
    writer.WeldOff();
    writer.SetGridBits(0);
  };
  compare("in turn", SharesOf(MakeSphere(40), {}));
  compare("without welding", SharesOf(MakeSphere(40, VTK_DOUBLE), {}), keepAll);
  compare("by ids", SharesOf(WithIds(MakeSphere(40)), {}), keepAll);
  compare("ghosts with ids", SharesOf(WithIds(MakeSphere(40)), { true }), keepAll);
  compare("ghosts without ids", SharesOf(MakeSphere(40), { true }), keepAll);
  compare("blocks with ids", BlocksOf(WithIds(MakeSphere(40))), keepAll);
  compare("blocks without ids", BlocksOf(MakeSphere(40)), keepAll);
  compare("by place", SharesOf(MakeSphere(40), {}),
    [&](vtkKdStoreWriter& writer)
    {
      keepAll(writer);
      writer.WeldByPlaceOn();
    });
  compare("a rank has nothing", SharesOf(MakePlate(40), { false, 1 }));
  compare("one rank has all", SharesOf(WithIds(MakeSphere(30)), { false, -1, 1 }), keepAll);
  compare("cells of all kinds", SharesOf(MakeAllCells(), {}), keepAll);
  compare("cells of all kinds with ids", SharesOf(WithIds(MakeAllCells()), {}), keepAll);
  compare("many in one place", SharesOf(WithIds(MakeRepeatedPoint(30)), {}), keepAll);
  std::vector<Parts> parts;
  for (int each = 0; each < ranks; ++each)
  {
    parts.push_back({ WithIds(MakeSphere(20 + each)), WithIds(MakePlate(10 + each)) });
  }
  compare("ids that each part counts", parts, keepAll);
  parts.back()[0] = MakeSphere(20, VTK_DOUBLE);
  parts.back()[0]->GetPointData()->Initialize();
  compare("arrays and types that not all have", parts, keepAll);
  for (Parts& each : parts)
  {
    for (const PolyData& part : each)
    {
      vtkNew<vtkCellArray> none;
      part->SetPolys(none);
      part->GetCellData()->Initialize();
    }
  }
  compare("a cloud", parts, keepAll);
}

// Returns the piece that is requested, as vtkKdStoreReader does.
class PieceSource : public vtkPolyDataAlgorithm
{
public:
  static PieceSource* New();
  vtkTypeMacro(PieceSource, vtkPolyDataAlgorithm);
  PolyData Whole;

protected:
  PieceSource() { this->SetNumberOfInputPorts(0); }
  int RequestInformation(
    vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector) override
  {
    outputVector->GetInformationObject(0)->Set(CAN_HANDLE_PIECE_REQUEST(), 1);
    return 1;
  }
  int RequestData(
    vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector) override
  {
    using Pipeline = vtkStreamingDemandDrivenPipeline;
    vtkInformation* const asked = outputVector->GetInformationObject(0);
    const PolyData piece = ShareOf(this->Whole, asked->Get(Pipeline::UPDATE_PIECE_NUMBER()),
      { false, -1, asked->Get(Pipeline::UPDATE_NUMBER_OF_PIECES()) });
    vtkPolyData::GetData(outputVector)->ShallowCopy(piece);
    return 1;
  }
};
vtkStandardNewMacro(PieceSource);

// Passes its input on.
class Between : public vtkPolyDataAlgorithm
{
public:
  static Between* New();
  vtkTypeMacro(Between, vtkPolyDataAlgorithm);

protected:
  int RequestData(vtkInformation*, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override
  {
    vtkPolyData::GetData(outputVector)->ShallowCopy(vtkPolyData::GetData(inputVector[0]));
    return 1;
  }
};
vtkStandardNewMacro(Between);

// If a source can give pieces, each rank gets its own piece, even if the source has given
// everything before.
void ComparePieces(const std::string& folder, vtkMPIController* controller)
{
  vtkNew<PieceSource> source;
  source->Whole = MakeSphere(50);
  AddGlobalIds(source->Whole);
  source->Update();
  vtkNew<Between> between;
  between->SetInputConnection(source->GetOutputPort());
  vtkNew<vtkKdTreePartition> filter;
  FilterObserver heard(filter);
  filter->SetInputConnection(between->GetOutputPort());
  filter->SetVerticesPerPartition(50);
  filter->GeneratePartitionIdsOn();
  filter->Update();
  const auto one = Partition(source->Whole, 50, true);
  for (unsigned int i = 0; i < one->GetOutput()->GetNumberOfPartitions(); ++i)
  {
    vtkPolyData* const here = PartitionAt(filter, i);
    Expect(!here || AreSame(here, PartitionAt(one, i)), "partition " + std::to_string(i));
  }
  const auto labelled = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1));
  Expect(
    labelled->GetNumberOfPoints() < source->Whole->GetNumberOfPoints(), "this rank has all of it");
  Expect(heard.warning.empty(), "the warning is " + heard.warning);
  const auto write = [&](const std::string& to, bool alone)
  {
    vtkNew<vtkKdStoreWriter> writer;
    if (alone)
    {
      writer->SetController(nullptr);
    }
    writer->SetInputConnection(source->GetOutputPort());
    writer->SetFileName(to.c_str());
    Expect(writer->Write() == 1, "no " + to);
  };
  write(folder + "/model.kds", false);
  controller->Barrier();
  if (rank == 0)
  {
    write(folder + "/one/model.kds", true);
    const std::string content = ContentOf(folder + "/model.kds");
    Expect(content.size() > 10000 && content == ContentOf(folder + "/one/model.kds"),
      "the stores differ");
  }
}

void WriteObj(vtkPolyData* mesh, const std::string& file)
{
  std::ofstream text(file);
  for (vtkIdType i = 0; i < mesh->GetNumberOfPoints(); ++i)
  {
    const auto p = Point(*mesh, i);
    text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  }
  for (vtkIdType c = 0; c < mesh->GetNumberOfCells(); ++c)
  {
    const Ids t = CellPoints(*mesh, c);
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
}

// If a source cannot give pieces, each rank uses the file that it reads: its own file, or one that
// all ranks read, with a warning.
void CompareFiles(const std::string& folder)
{
  const PolyData whole = MakeSphere(40);
  for (const bool isOwn : { true, false })
  {
    const std::string file =
      folder + "/mesh" + std::to_string(rank) + (isOwn ? "own" : "same") + ".obj";
    WriteObj(isOwn ? ShareOf(whole, rank, {}) : whole, file);
    vtkIdType expected = isOwn ? 0 : ranks * whole->GetNumberOfPoints();
    for (int each = 0; isOwn && each < ranks; ++each)
    {
      expected += ShareOf(whole, each, {})->GetNumberOfPoints();
    }
    vtkNew<vtkKdMeshReader> reader;
    reader->SetFileName(file.c_str());
    vtkNew<vtkKdTreePartition> filter;
    vtkNew<vtkKdStoreWriter> writer;
    writer->SetFileName((folder + "/files.kds").c_str());
    FilterObserver heard(filter), heardWriter(writer);
    filter->SetInputConnection(reader->GetOutputPort());
    filter->SetNumberOfPartitions(1);
    filter->Update();
    writer->SetInputConnection(reader->GetOutputPort());
    Expect(writer->Write() == 1, "no store");
    vtkPolyData* const all = PartitionAt(filter, 0);
    Expect(!all || all->GetNumberOfPoints() == expected, "the number of points");
    for (const FilterObserver* const each : { &heard, &heardWriter })
    {
      const bool isReported =
        each->warning.find("all processes have the same mesh") != std::string::npos;
      const bool knows = each == &heard || rank == 0; // only rank 0 writes
      Expect(isReported == (knows && !isOwn), "the warning is " + each->warning);
    }
  }
}

void CompareFile(const char* file)
{
  vtkNew<vtkKdMeshReader> reader;
  reader->SetFileName(file);
  reader->Update();
  const PolyData whole = PolyData::New();
  whole->ShallowCopy(reader->GetOutput());
  Expect(whole->GetNumberOfPoints() > 100000, "the mesh was not read");
  CompareByIds(whole, 2000, {});
}

void Run(const std::string& name, const std::string& folder, const char* file,
  vtkMPIController* controller)
{
  if (name == "ids")
  {
    CompareByIds(MakeSphere(70), 50, {});
    CompareByIds(MakeSphere(40, VTK_DOUBLE), 50, {});
    CompareByIds(MakeRepeatedPoint(30), 20, {});
    CompareByIds(MakePlate(40), 30, { false, 1 });
    CompareByIds(MakeAllCells(), 4, {});
  }
  else if (name == "turn")
  {
    CompareInTurn(MakeSphere(70), 50, {});
    CompareInTurn(MakePlate(40), 30, { false, 0 });
    CompareInTurn(MakeAllCells(), 4, {});
  }
  else if (name == "ghosts")
  {
    CompareByIds(MakeSphere(70), 50, { true });
  }
  else if (name == "blocks")
  {
    CompareBlocks(MakeSphere(70), 50);
  }
  else if (name == "error")
  {
    ExpectErrorOfAll();
  }
  else if (name == "texts")
  {
    ExpectWarningOfTexts(folder);
  }
  else if (name == "restart")
  {
    CompareRestartedIds(MakeSphere(50), 50);
    CompareRestartedCellIds(MakeSphere(50), 50);
    CompareHighCellIds(MakeSphere(50), 50);
  }
  else if (name == "arrays")
  {
    CompareArrays(MakeSphere(40), 50);
    ExpectNoIdsOfCutCells();
  }
  else if (name == "pieces")
  {
    ComparePieces(folder, controller);
    CompareFiles(folder);
  }
  else if (name == "input")
  {
    ExpectErrorOfInput(folder);
  }
  else if (name == "name")
  {
    ExpectNameOfFirst(folder, controller);
  }
  else if (name == "store")
  {
    CompareStores(folder, controller);
  }
  else if (name == "parts")
  {
    CompareStoresOfParts(folder, controller);
  }
  else if (name == "stray")
  {
    CompareStrayIds(MakeSphere(40), 50);
    CompareStoresOfStrayIds(folder, controller);
  }
  else if (name == "file")
  {
    CompareFile(file);
  }
  else
  {
    Expect(false, "there is no case " + name);
  }
}

}

int main(int argc, char** argv)
{
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  rank = controller->GetLocalProcessId();
  ranks = controller->GetNumberOfProcesses();
  Run(argc > 1 ? argv[1] : "", argc > 2 ? argv[2] : ".", argc > 3 ? argv[3] : "", controller);
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return failures == 0 ? 0 : 1;
}
