// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. convert the input to one mesh of core's
// 2. build the store (filters/build).
//
// Steps on several processes:
// 1. convert their inputs to shares of one mesh
// 2. build a store of the shares (filters/Parallel).
#include "vtkKdStoreWriter.h"

#include "filters/Parallel/DistributedBuilder.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/JoinPolyData.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/adapter/RankMesh.h"
#include "filters/adapter/RankPipeline.h"
#include "filters/build/BuildMemory.h"
#include "filters/build/Builder.h"
#include "filters/build/ExternalBuilder.h"

#include <vtkDataObject.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkMultiProcessController.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <unistd.h>

vtkStandardNewMacro(vtkKdStoreWriter);

KDSTREAM_SET_IN_RANGE(vtkKdStoreWriter, VerticesPerPartition, vtkIdType, 1, VTK_INT_MAX)
KDSTREAM_SET_IN_RANGE(vtkKdStoreWriter, NumberOfPartitions, vtkIdType, 0, 1 << 30)
KDSTREAM_SET_IN_RANGE(vtkKdStoreWriter, CellVertices, int, 1, 1024)
KDSTREAM_SET_FINITE(vtkKdStoreWriter, Up)
KDSTREAM_SET_FINITE(vtkKdStoreWriter, View)

namespace
{

using namespace kdstream;

// The direction that a member of three numbers sets; nothing for (0, 0, 0).
Result<std::optional<Vec3>> DirectionOfMember(const char* name, const double* member)
{
  const Vec3 vector{ member[0], member[1], member[2] };
  if (vector == Vec3{})
  {
    return std::optional<Vec3>();
  }
  const std::optional<Vec3> direction = DirectionOf(vector);
  return direction ? Result<std::optional<Vec3>>(direction)
                   : Error{ ErrorCode::InvalidArgument, std::string(name) + " is not a direction" };
}

// Error codes for a file that is written: a missing folder is not a FileNotFoundError, and its
// format cannot be wrong.
unsigned long CodeOf(const Error& error)
{
  switch (error.code)
  {
    case ErrorCode::DiskFull:
    case ErrorCode::InputOutput:
      return VtkErrorCodeOf(error);
    case ErrorCode::NotFound:
      return vtkErrorCode::CannotOpenFileError;
    default:
      return vtkErrorCode::UnknownError;
  }
}

// Makes one mesh with all arrays that a store can have.
Result<Mesh> ReadInput(vtkDataObject& input, bool weldByPlace, const Execution& execution,
  std::vector<std::string>& leftOut)
{
  Result<JoinedPolyData> joined = JoinPolyData(input, weldByPlace, execution);
  KDSTREAM_TRY(joined);
  vtkPolyData& whole = *joined->mesh;
  Result<Mesh> mesh = ReadMesh(whole, execution);
  KDSTREAM_TRY(mesh);
  const Result<PolyDataElements> elements = ReadElements(whole);
  KDSTREAM_TRY(elements);
  PolyDataAttributes read = ReadAttributes(whole, *elements);
  mesh->attributes = std::move(read.attributes);
  leftOut.insert(leftOut.end(), joined->leftOut.begin(), joined->leftOut.end());
  leftOut.insert(leftOut.end(), read.skipped.begin(), read.skipped.end());
  return mesh;
}

// How many ranks run on this host.
Result<std::uint64_t> RanksHere(RankGroup& ranks)
{
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  const auto hash = std::uint64_t{ std::hash<std::string>()(name.data()) } >> 1;
  const auto all = ranks.Gather(hash);
  KDSTREAM_TRY(all);
  return static_cast<std::uint64_t>(std::count(all->begin(), all->end(), hash));
}

// Takes from rank 0 the options that must be equal on all ranks, and the store's name.
Status TakeOptionsOfFirst(
  RankGroup& ranks, bool& weldByPlace, std::string& store, BuildOptions& options)
{
  const bool given = options.tree.partitions.has_value();
  RankMessage own;
  own.Put(std::vector<std::uint32_t>{ options.tree.verticesPerPartition,
    given ? *options.tree.partitions : 0, options.tree.cellVertices,
    static_cast<std::uint32_t>(options.levels.maker), options.weld, options.bits, weldByPlace });
  own.Put(std::vector<char>(store.begin(), store.end()));
  const auto received = ranks.Exchange(RankLists<unsigned char>(ranks.Count(), own.Release()));
  KDSTREAM_TRY(received);
  RankMessage first(received->front());
  const std::vector<std::uint32_t> numbers = first.Take<std::uint32_t>();
  const std::vector<char> name = first.Take<char>();
  options.tree.verticesPerPartition = numbers[0];
  options.tree.partitions.reset();
  if (numbers[1] > 0)
  {
    options.tree.partitions = numbers[1];
  }
  options.tree.cellVertices = numbers[2];
  options.levels.maker = static_cast<LevelMaker>(numbers[3]);
  options.weld = numbers[4] != 0;
  options.bits = static_cast<std::uint8_t>(numbers[5]);
  weldByPlace = numbers[6] != 0;
  store.assign(name.begin(), name.end());
  return {};
}

// Called by all ranks: builds one store of all their data.
Status BuildCollectively(MpiGroup& ranks, vtkKdStoreWriter& writer, const Status& ready,
  std::string store, BuildOptions options, const Execution& execution,
  std::vector<std::string>& leftOut)
{
  bool weldByPlace = writer.GetWeldByPlace();
  KDSTREAM_TRY(TakeOptionsOfFirst(ranks, weldByPlace, store, options));
  Result<MeshShare> share = ShareMesh(ranks, ready, *writer.GetInput(), weldByPlace, execution);
  KDSTREAM_TRY(share);
  leftOut = std::move(share->leftOut);
  if (share->areSame && ranks.IsFirst())
  {
    WarnOfSameMesh(writer);
  }
  const Result<std::uint64_t> here = RanksHere(ranks);
  KDSTREAM_TRY(here);
  options.memory = std::max(FreeMemory() / 4 * 3 / *here, leastMemory);
  options.inputName = std::filesystem::path(store).stem().string();
  const auto report = BuildStoreOfShares(ranks, std::move(share->mesh), store, options, execution);
  return report ? Status() : Status(report.GetError());
}

}

vtkCxxSetObjectMacro(vtkKdStoreWriter, Controller, vtkMultiProcessController);

vtkKdStoreWriter::vtkKdStoreWriter()
{
  this->SetController(vtkMultiProcessController::GetGlobalController());
}

vtkKdStoreWriter::~vtkKdStoreWriter()
{
  this->SetController(nullptr);
  this->SetFileName(nullptr);
}

const char* vtkKdStoreWriter::GetMakerAsString() const
{
  return this->Maker == Collapse ? "Collapse" : "Cluster";
}

void vtkKdStoreWriter::SetGridBits(int bits)
{
  if (bits < 0)
  {
    vtkErrorMacro(<< "GridBits must be 0 or from 8 to 24, not " << bits << ": it stays "
                  << this->GridBits);
    return;
  }
  const int clamped = bits == 0 ? 0 : std::clamp(bits, 8, 24);
  if (clamped != this->GridBits)
  {
    this->GridBits = clamped;
    this->Modified();
  }
}

int vtkKdStoreWriter::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

void vtkKdStoreWriter::WriteData()
{
  this->HasBegun = true;
  const bool hasName = this->FileName && *this->FileName;
  const auto fail = [&](const Error& error)
  {
    this->SetErrorCode(CodeOf(error));
    if (error.code != ErrorCode::Cancelled)
    {
      const std::string name = hasName ? this->FileName : "";
      const bool isOther = !error.file.empty() && error.file != name;
      vtkErrorMacro(<< (hasName ? name + ": " : "") << (isOther ? error.file + ": " : "")
                    << error.message);
    }
  };
  const bool isCollective = AreSeveral(this->Controller);
  // If only one process writes, the names and directions of the others do not matter.
  const bool writes = !isCollective || this->Controller->GetLocalProcessId() == 0;
  this->SetErrorCode(vtkErrorCode::NoError);
  BuildOptions options;
  options.tree.verticesPerPartition = static_cast<std::uint32_t>(this->VerticesPerPartition);
  if (this->NumberOfPartitions > 0)
  {
    options.tree.partitions = static_cast<std::uint32_t>(this->NumberOfPartitions);
  }
  options.tree.cellVertices = static_cast<std::uint32_t>(this->CellVertices);
  static_assert(int(LevelMaker::Collapse) == Collapse && int(LevelMaker::Cluster) == Cluster);
  options.levels.maker = static_cast<LevelMaker>(this->Maker);
  options.weld = this->Weld;
  options.bits = static_cast<std::uint8_t>(this->GridBits);
  options.title = this->Title;
  options.credit = this->Credit;
  options.license = this->License;
  options.unit = this->Unit;
  const auto up = DirectionOfMember("Up", this->Up), view = DirectionOfMember("View", this->View);
  Status ready;
  if (writes && !hasName)
  {
    ready = Error{ ErrorCode::InvalidArgument, "no FileName is set" };
  }
  else if (writes && (!up || !view))
  {
    ready = (up ? view : up).GetError();
  }

  const Execution execution = MakeAlgorithmExecution(
    *this, { { "tree", 0.05, 0.2 }, { "faces", 0.2, 0.25 }, { "levels", 0.25, 0.75 },
             { "encode", 0.75, 0.95 }, { "write", 0.95, 1.0 } });
  std::vector<std::string> leftOut;
  const auto build = [&]() -> Status
  {
    Result<Mesh> mesh = ReadInput(*this->GetInput(), this->WeldByPlace, execution, leftOut);
    KDSTREAM_TRY(mesh);
    const std::string name = std::filesystem::path(this->FileName).stem().string();
    const auto report = BuildStore(std::move(*mesh), name, this->FileName, options, execution);
    return report ? Status() : Status(report.GetError());
  };
  if (ready && writes)
  {
    options.up = *up;
    options.view = *view;
  }
  const auto buildCollectively = [&]
  {
    RankMessages messages(*this->Controller);
    MpiGroup ranks(messages);
    return RunCollectively(ranks,
      [&]
      {
        return BuildCollectively(
          ranks, *this, ready, hasName ? this->FileName : "", options, execution, leftOut);
      });
  };
  const Status built = isCollective ? buildCollectively() : ready ? build() : ready;
  WarnOfArrays(*this, leftOut);
  if (!built)
  {
    fail(built.GetError());
  }
  if (writes && !hasName)
  {
    this->SetErrorCode(vtkErrorCode::NoFileNameError);
  }
}

// If several processes write together, a process without input takes part, too, and fails, because
// the others wait for it.
int vtkKdStoreWriter::Write()
{
  this->HasBegun = false;
  this->SetErrorCode(vtkErrorCode::UnknownError); // until WriteData has a better code
  const bool isCollective = AreSeveral(this->Controller);
  const bool hasInput = this->GetNumberOfInputConnections(0) > 0;
  if (hasInput || !isCollective)
  {
    const int isWritten = this->Superclass::Write();
    if (hasInput && !isCollective && !this->HasBegun)
    {
      vtkErrorMacro(<< (this->FileName ? this->FileName : "")
                    << ": it was not written: its input could not be made");
    }
    return isWritten;
  }
  this->Modified();
  this->UpdateWholeExtent();
  return 0;
}

vtkExecutive* vtkKdStoreWriter::CreateDefaultExecutive()
{
  return RankPipeline::Make(
    this->Controller, [this](unsigned long code) { this->SetErrorCode(code); });
}

void vtkKdStoreWriter::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "Controller: " << static_cast<void*>(this->Controller) << "\n";
  os << indent << "GridBits: " << this->GridBits << "\n";
  os << indent << "VerticesPerPartition: " << this->VerticesPerPartition << "\n";
  os << indent << "NumberOfPartitions: " << this->NumberOfPartitions << "\n";
  os << indent << "CellVertices: " << this->CellVertices << "\n";
  os << indent << "Maker: " << this->GetMakerAsString() << "\n";
  os << indent << "Weld: " << (this->Weld ? "on" : "off") << "\n";
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
  os << indent << "Title: " << this->Title << "\n";
  os << indent << "Credit: " << this->Credit << "\n";
  os << indent << "License: " << this->License << "\n";
  os << indent << "Unit: " << this->Unit << "\n";
  os << indent << "Up: " << this->Up[0] << " " << this->Up[1] << " " << this->Up[2] << "\n";
  os << indent << "View: " << this->View[0] << " " << this->View[1] << " " << this->View[2] << "\n";
}
