// SPDX-License-Identifier: BSD-3-Clause
// TestRankPipelines runs this on the ranks of a job. It checks that every rank reports an error of
// one rank, with the number of that rank, and that no rank waits for ever. It also checks that no
// rank has much more of the mesh than others, whatever its ids are.
//   RankFaults CASE FOLDER; exit code 1 and a line for each difference.
#include "filters/adapter/RankMesh.h"
#include "filters/adapter/Testing/FilterTools.h"
#include "server/http/Testing/ScarceMemory.h"

#include <vtkCompositeDataPipeline.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdTreePartition.h>
#include <vtkMPIController.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkOverlappingAMR.h>
#include <vtkPartitionedDataSet.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <regex>

#include <unistd.h>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;

int rank = 0, ranks = 1, failures = 0;
std::string folder;
vtkMPIController* job = nullptr;

void Expect(bool holds, const std::string& what)
{
  if (!holds)
  {
    std::cerr << "rank " << rank << " of " << ranks << ": " << what << std::endl;
    ++failures;
  }
}

// Rank `of`'s part of a mesh.
PolyData PartOf(int of)
{
  PolyData part = MakeSphere(20);
  for (vtkIdType i = 0; i < part->GetNumberOfPoints(); ++i)
  {
    double p[3];
    part->GetPoint(i, p);
    part->GetPoints()->SetPoint(i, p[0] + 3 * of, p[1], p[2]);
  }
  return part;
}

bool Execute(vtkAlgorithm& algorithm)
{
  auto* const writer = vtkKdStoreWriter::SafeDownCast(&algorithm);
  return writer ? writer->Write() != 0 : (algorithm.Update(), algorithm.GetErrorCode() == 0);
}

// All ranks must report that this rank has failed, and why; there must be no output.
void ExpectErrorOf(
  int failed, vtkAlgorithm& algorithm, const std::string& what, const std::string& said = "")
{
  FilterObserver heard(&algorithm);
  Expect(!Execute(algorithm), what + ": done");
  const std::string name = "(rank " + std::to_string(failed) + " on ";
  Expect(heard.error.find(name) != std::string::npos, what + ": the error is " + heard.error);
  Expect(heard.error.find(said) != std::string::npos, what + ": the error is " + heard.error);
  Expect(algorithm.GetErrorCode() != 0, what + ": no error code");
  for (int port = 0; port < algorithm.GetNumberOfOutputPorts(); ++port)
  {
    vtkDataObject* const output = algorithm.GetOutputDataObject(port);
    Expect(!output || output->GetNumberOfElements(vtkDataObject::POINT) == 0,
      what + ": there is an output");
  }
  Expect(!std::filesystem::exists(folder + "/model.kds"), what + ": there is a store");
  job->Barrier();
}

using InputOf = std::function<vtkSmartPointer<vtkDataObject>()>;

vtkSmartPointer<vtkDataObject> Image()
{
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(2, 2, 2);
  image->AllocateScalars(VTK_DOUBLE, 1);
  return image;
}

const std::map<std::string, InputOf>& BadInputs()
{
  static const std::map<std::string, InputOf> inputs{
    { "none", [] { return nullptr; } },
    { "an image", Image },
    { "a composite data set of another type",
      []
      {
        auto levels = vtkSmartPointer<vtkOverlappingAMR>::New();
        const int blocks[] = { 1 };
        levels->Initialize(1, blocks);
        return levels;
      } },
    { "an image in a block",
      []
      {
        auto blocks = vtkSmartPointer<vtkMultiBlockDataSet>::New();
        blocks->SetBlock(0, PartOf(0));
        blocks->SetBlock(1, Image());
        return blocks;
      } },
    { "a cell without its point",
      []
      {
        const PolyData part = PartOf(0);
        AddCell(part->GetPolys(), { 0, 1, 1000000 });
        return part;
      } },
  };
  return inputs;
}

template <class Visit>
void ForFilterAndWriter(const Visit& visit)
{
  vtkNew<vtkKdTreePartition> filter;
  filter->SetVerticesPerPartition(50);
  visit(*filter, "the filter");
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetFileName((folder + "/model.kds").c_str());
  visit(*writer, "the writer");
}

// The input of one rank is bad, which is an error. With a good input, the next Update works.
void CheckInputs()
{
  int bad = 0;
  for (const auto& [name, make] : BadInputs())
  {
    ForFilterAndWriter(
      [&, &what = name, &input = make](vtkAlgorithm& algorithm, const std::string& which)
      {
        algorithm.SetInputDataObject(rank == bad ? input() : InputOf::result_type(PartOf(rank)));
        ExpectErrorOf(bad, algorithm, which + ", " + what);
        algorithm.SetInputDataObject(PartOf(rank));
        Expect(bad > 0 || Execute(algorithm), which + " behind " + what);
        job->Barrier();
        std::filesystem::remove(folder + "/model.kds");
        job->Barrier();
      });
    bad = (bad + 1) % ranks;
  }
}

// The same, if another algorithm after the filter asks for the output.
void CheckBehind()
{
  vtkNew<vtkKdTreePartition> filter;
  FilterObserver heard(filter);
  if (rank > 0)
  {
    filter->SetInputData(PartOf(rank));
  }
  vtkNew<vtkKdTreePartition> behind;
  FilterObserver unheard(behind);
  behind->SetController(nullptr);
  behind->SetInputConnection(filter->GetOutputPort());
  behind->Update();
  Expect(heard.error.find("it has no input (rank 0 on ") != std::string::npos,
    "the error is " + heard.error);
}

// Does with a filter what ParaView does. A filter keeps its executive only if this is of the class
// that the XML of its panel names; without a name, it gets ParaView's own. Then the input of one
// rank fails.
void CheckParaView()
{
  std::ifstream file(KDSTREAM_PANELS);
  const std::string text{ std::istreambuf_iterator<char>(file), {} };
  std::smatch proxy;
  Expect(
    std::regex_search(text, proxy, std::regex("<SourceProxy [^>]*\"vtkKdTreePartition\"[^>]*>")),
    "the filter has no panel");
  std::smatch name;
  const std::string attributes = proxy.str();
  const bool isNamed = std::regex_search(attributes, name, std::regex("executive=\"([^\"]*)\""));
  vtkNew<vtkKdTreePartition> filter;
  if (!isNamed || !filter->GetExecutive()->IsA(name.str(1).c_str()))
  {
    vtkNew<vtkCompositeDataPipeline> paraViews;
    filter->SetExecutive(paraViews);
  }
  filter->SetInputDataObject(rank == 1 ? nullptr : PartOf(rank).Get());
  ExpectErrorOf(1, *filter, "in ParaView", "it has no input");
  filter->SetInputDataObject(PartOf(rank));
  Expect(Execute(*filter), "in ParaView, with an input");
}

void CheckOptions()
{
  vtkNew<vtkKdTreePartition> filter;
  filter->SetInputData(PartOf(rank));
  const auto expect = [&](const std::string& said)
  {
    FilterObserver heard(filter);
    filter->Update(said.find("port") != std::string::npos && rank == 1 ? 1 : 0);
    Expect(heard.error.find(said) != std::string::npos, "the error is " + heard.error);
    Expect(filter->GetErrorCode() != 0, "no error code");
  };
  filter->SetVerticesPerPartition(rank == 1 ? 60 : 50);
  expect("VerticesPerPartition is 50 on rank 0, and 60 on rank 1");
  filter->SetVerticesPerPartition(50);
  filter->SetNumberOfPartitions(rank == 1 ? 4 : 8);
  expect("NumberOfPartitions is 8 on rank 0, and 4 on rank 1");
  filter->SetNumberOfPartitions(3);
  expect("3");
  filter->SetNumberOfPartitions(8);
  filter->SetGeneratePartitionIds(rank == 1);
  expect("GeneratePartitionIds is 0 on rank 0, and 1 on rank 1");
  filter->GeneratePartitionIdsOn();
  expect("the output port is 0 on rank 0, and 1 on rank 1");
  filter->Modified();
  Expect(Execute(*filter), "with the same options");
}

constexpr std::size_t leastOfLists = 2000; // bytes: with less, VTK itself aborts

// Rank 1 runs out of memory: at its first allocation, then at a later one, then at an even later
// one, …
void CheckMemory()
{
  PolyData part = PartOf(rank);
  AddIds(*part);
  vtkNew<vtkIdTypeArray> ids;
  for (vtkIdType i = 0; i < part->GetNumberOfPoints(); ++i)
  {
    ids->InsertNextValue(i * ranks + rank);
  }
  ids->SetName("Global");
  part->GetPointData()->SetGlobalIds(ids);
  ForFilterAndWriter(
    [&](vtkAlgorithm& algorithm, const std::string& which)
    {
      algorithm.SetInputDataObject(part);
      Execute(algorithm); // VTK sets up its pipelines here
      int isFailed = 1, times = 0;
      for (long at = 0; isFailed; at += 1 + at / 2)
      {
        algorithm.Modified();
        FilterObserver heard(&algorithm);
        bool done = false;
        {
          const ScarceMemory scarce(
            rank == 1 ? at : -1, ScarceMemory::Where::Everywhere, leastOfLists);
          done = Execute(algorithm);
          isFailed = scarce.HasFailed();
        }
        job->Broadcast(&isFailed, 1, 1);
        const std::string what = which + ", allocation " + std::to_string(at);
        Expect(done == !isFailed, what + (done ? ": done" : ": " + heard.error));
        Expect(
          (heard.error.find("out of memory (rank 1 on ") != std::string::npos) == (isFailed != 0),
          what + ": the error is " + heard.error);
        times += isFailed;
      }
      Expect(times > 10, which + ": " + std::to_string(times) + " allocations only");
    });
}

// Each rank's share of points and triangles, as the build of a store gets it.
void CheckShares()
{
  constexpr std::int64_t stray = std::int64_t{ 1 } << 62;
  const std::map<std::string, std::function<std::int64_t(std::int64_t)>> kinds{
    { "in turn", [](std::int64_t i) { return i; } },
    { "with one stray id", [](std::int64_t i) { return i == 7 ? stray : i; } },
    { "negative, with two stray ids",
      [](std::int64_t i) { return i == 7   ? stray
                                  : i == 8 ? -stray
                                           : -i; } },
    { "multiples of many numbers of ranks", [](std::int64_t i) { return 2520 * i; } },
  };
  for (const auto& [name, idOf] : kinds)
  {
    const PolyData part = PartOf(rank);
    const auto add = [&, &id = idOf](vtkDataSetAttributes* data, vtkIdType count)
    {
      vtkNew<vtkIdTypeArray> ids;
      ids->SetName("Global");
      for (vtkIdType i = 0; i < count; ++i)
      {
        ids->InsertNextValue(id(rank * count + i));
      }
      data->SetGlobalIds(ids);
    };
    add(part->GetPointData(), part->GetNumberOfPoints());
    add(part->GetCellData(), part->GetNumberOfCells());
    RankGroup group(*job);
    const auto share = group.Run([&] { return ShareMesh(group, {}, *part, false, {}); });
    Expect(static_cast<bool>(share), name + ": no share");
    if (share)
    {
      const auto expect = [&, &what = name](std::size_t has, vtkIdType average)
      {
        Expect(
          4 * has <= 5 * static_cast<std::size_t>(average + ranks) &&
            4 * (has + static_cast<std::size_t>(ranks)) >= 3 * static_cast<std::size_t>(average),
          what + ": this rank has " + std::to_string(has) + " of " + std::to_string(average));
      };
      expect(share->mesh.points.size(), part->GetNumberOfPoints());
      expect(share->mesh.triangles.size(), part->GetNumberOfCells());
    }
  }
}

// The store's folder does not exist on one rank, or cannot be written. On the first rank, this is
// an error of all ranks. Other ranks then use the system's folder for temporary files; if that does
// not exist either, the error names both folders.
void CheckFolders()
{
  const std::filesystem::path own = folder + "/rank" + std::to_string(rank);
  std::filesystem::create_directories(own / "there");
  std::filesystem::current_path(own);
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputData(PartOf(rank));
  const auto removeFrom = [&](int of)
  {
    std::filesystem::create_directories(own / "there");
    if (rank == of)
    {
      std::filesystem::remove_all(own / "there");
    }
    writer->SetFileName("there/model.kds");
  };
  removeFrom(0);
  ExpectErrorOf(0, *writer, "no folder on rank 0", "No such file or directory");
  Expect(writer->GetErrorCode() == vtkErrorCode::CannotOpenFileError, "the code is another");
  for (const bool isThere : { false, true })
  {
    removeFrom(1);
    if (rank == 1 && isThere)
    {
      std::filesystem::create_directory_symlink("/proc", "there"); // even root cannot write there
    }
    job->Barrier();
    Expect(Execute(*writer), "no folder to write on rank 1");
    Expect(rank != 0 || std::filesystem::exists("there/model.kds"), "there is no store");
    job->Barrier();
    std::filesystem::remove_all("there");
  }
  removeFrom(1);
  if (rank == 1)
  {
    ::setenv("TMPDIR", "/nonexistent", 1);
  }
  job->Barrier();
  ExpectErrorOf(1, *writer, "no folder at all on rank 1");
}

}

int main(int argc, char** argv)
{
  ::alarm(100); // seconds: no rank waits for ever
  vtkNew<vtkMPIController> controller;
  controller->Initialize(&argc, &argv);
  vtkMultiProcessController::SetGlobalController(controller);
  job = controller;
  rank = controller->GetLocalProcessId();
  ranks = controller->GetNumberOfProcesses();
  folder = argc > 2 ? argv[2] : ".";
  const std::map<std::string, std::function<void()>> cases{ { "inputs", CheckInputs },
    { "behind", CheckBehind }, { "paraview", CheckParaView }, { "options", CheckOptions },
    { "memory", CheckMemory }, { "shares", CheckShares }, { "folders", CheckFolders } };
  const auto found = cases.find(argc > 1 ? argv[1] : "");
  Expect(found != cases.end(), "there is no such case");
  if (found != cases.end())
  {
    found->second();
  }
  vtkMultiProcessController::SetGlobalController(nullptr);
  controller->Finalize();
  return failures == 0 ? 0 : 1;
}
