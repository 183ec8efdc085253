// SPDX-License-Identifier: BSD-3-Clause
// Run by TestRankPipelines on the ranks of a job: each rank has a part of a mesh, and gets its
// partitions of one tree over all; one process's, of the whole mesh, are the same to the bit.
//   RankPipelines CASE FOLDER [MESH]; exit code 1 and a line for what differs.
#include "filters/adapter/Testing/FilterTools.h"

#include <vtkKdMeshReader.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdTreePartition.h>
#include <vtkMPIController.h>
#include <vtkPartitionedDataSet.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cstring>
#include <fstream>
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

void AddGlobalIds(vtkPolyData* mesh)
{
  const auto add = [](vtkDataSetAttributes* data, vtkIdType count)
  {
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName("GlobalIds");
    for (vtkIdType i = 0; i < count; ++i)
    {
      ids->InsertNextValue(i);
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

// vtkPolyData knows no polygons of two points, but its arrays do.
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

// Points and cells of a mesh, ascending, as a mesh.
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

// What rank `of` has of a mesh: every cell once, with its points, and its share of those without
// cells; with ghosts also some of the next rank's cells, marked. Rank `none` has nothing. The same
// of another number of shares than there are ranks.
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

// Parts one after the other as one mesh: their points, and their cells kind by kind.
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

// This rank's partitions are those of one process, and no others are here.
void ComparePartitions(vtkDataObject* own, vtkPolyData* whole, vtkIdType size)
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
  // Port 1 alone says the same of the points.
  together->Modified();
  together->Update(1);
  const auto ids = vtkPolyData::SafeDownCast(together->GetOutputDataObject(1));
  vtkDataArray* const numbers = ids->GetPointData()->GetGlobalIds();
  const auto all = vtkPolyData::SafeDownCast(one->GetOutputDataObject(1));
  for (vtkIdType i = 0; numbers && i < ids->GetNumberOfPoints(); ++i)
  {
    const auto number = static_cast<vtkIdType>(numbers->GetComponent(i, 0));
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

// Without ids nothing is the same point: the whole mesh is the shares, one after the other.
void CompareInTurn(vtkPolyData* whole, vtkIdType size, const Sharing& sharing)
{
  std::vector<PolyData> shares;
  for (int each = 0; each < ranks; ++each)
  {
    shares.push_back(ShareOf(whole, each, sharing));
  }
  ComparePartitions(shares[static_cast<std::size_t>(rank)], Join(shares), size);
}

// An error of one rank is told by all, and nobody waits.
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
  const std::string said = "rank 1: point 7: a coordinate is not finite";
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

// What only numbers can do: arrays of texts do not travel, and each rank that has one says so.
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

// A store of what all ranks have is that of one process.
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
  controller->Barrier();
  if (rank == 0)
  {
    write(whole, one, true);
    const std::string content = ContentOf(together);
    Expect(content.size() > 10000 && content == ContentOf(one), "the stores differ");
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
  else if (name == "store")
  {
    CompareStores(folder, controller);
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
