// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. finds the requested partitions or level, and checks that the model has them;
// 2. converts their pieces to VTK's data (PieceOutput).
#include "vtkKdModelSource.h"

#include "filters/adapter/ArraySelections.h"
#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/core/tree/Region.h"
#include "viewer/sources/PieceOutput.h"
#include "viewer/sources/SourceExecution.h"
#include "viewer/sources/ViewCut.h"

#include <vtkCompositeDataPipeline.h>
#include <vtkDataArraySelection.h>
#include <vtkInformation.h>
#include <vtkInformationDoubleVectorKey.h>
#include <vtkInformationIdTypeKey.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationIntegerVectorKey.h>
#include <vtkInformationObjectBaseKey.h>
#include <vtkInformationVector.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <initializer_list>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

KDSTREAM_SET_IN_RANGE(vtkKdModelSource, LevelDepth, int, -1, 62)
KDSTREAM_SET_IN_RANGE(vtkKdModelSource, Rings, int, 0, 16)
KDSTREAM_SET_IN_RANGE(vtkKdModelSource, Tolerance, double, 0.01, 100)
KDSTREAM_SET_IN_RANGE(vtkKdModelSource, NumberOfTriangles, vtkIdType, 1000, VTK_INT_MAX)
KDSTREAM_SET_FINITE(vtkKdModelSource, RegionPoint)
KDSTREAM_SET_FINITE(vtkKdModelSource, CameraPosition)
KDSTREAM_SET_FINITE(vtkKdModelSource, CameraFocalPoint)
KDSTREAM_SET_FINITE(vtkKdModelSource, CameraViewUp)

namespace
{

using namespace kdstream;

// The share that the pipeline requests from this process.
OutputShare ShareOf(vtkInformation& outInfo)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  OutputShare share;
  if (outInfo.Has(Pipeline::UPDATE_NUMBER_OF_PIECES()))
  {
    share.pieces =
      static_cast<std::uint32_t>(std::max(outInfo.Get(Pipeline::UPDATE_NUMBER_OF_PIECES()), 1));
    share.piece =
      static_cast<std::uint32_t>(std::max(outInfo.Get(Pipeline::UPDATE_PIECE_NUMBER()), 0));
    share.ghostLevels = static_cast<unsigned>(
      std::clamp(outInfo.Get(Pipeline::UPDATE_NUMBER_OF_GHOST_LEVELS()), 0, 16));
  }
  if (outInfo.Has(vtkCompositeDataPipeline::LOAD_REQUESTED_BLOCKS()))
  {
    share.blocks.emplace();
    const int count = outInfo.Length(vtkCompositeDataPipeline::UPDATE_COMPOSITE_INDICES());
    const int* indices = outInfo.Get(vtkCompositeDataPipeline::UPDATE_COMPOSITE_INDICES());
    for (int i = 0; i < count; ++i)
    {
      if (indices[i] > 0)
      {
        share.blocks->insert(static_cast<std::uint32_t>(indices[i] - 1)); // 0 is the root
      }
    }
  }
  return share;
}

// Outputs the surface that a camera needs. If the pipeline has several pieces, the first one has
// all of it.
Status DrawView(const PieceSource& model, const ViewDemand& demand, const OutputShare& share,
  const PieceOutput& pieces, const Execution& execution, vtkDataObject& output)
{
  vtkNew<vtkPolyData> drawn;
  auto* const whole = vtkPolyData::SafeDownCast(&output);
  if (share.piece == 0)
  {
    const auto shown = ChooseByView(model, demand, execution);
    KDSTREAM_TRY(shown);
    KDSTREAM_TRY(pieces.DrawInto(*shown, whole ? *whole : *drawn));
  }
  if (auto* const parts = vtkPartitionedDataSet::SafeDownCast(&output))
  {
    parts->SetNumberOfPartitions(1);
    parts->SetPartition(0, drawn);
  }
  return {};
}

// The requested partitions of the original, ascending.
Result<std::vector<std::uint32_t>> Choose(const PieceSource& model, int content,
  const std::vector<vtkIdType>& chosen, const Vec3& point, unsigned rings,
  const Execution& execution)
{
  const ModelDescription& info = model.Info();
  std::vector<std::uint32_t> partitions;
  if (content == vtkKdModelSource::Original)
  {
    partitions.resize(info.partitions);
    std::iota(partitions.begin(), partitions.end(), 0u);
  }
  else if (content == vtkKdModelSource::Partitions)
  {
    for (const vtkIdType each : chosen)
    {
      if (each < 0 || static_cast<std::uint64_t>(each) >= info.partitions)
      {
        return Error{ ErrorCode::InvalidArgument, "there is no partition " + std::to_string(each) +
                                                    ": the model has " +
                                                    std::to_string(info.partitions) };
      }
      partitions.push_back(static_cast<std::uint32_t>(each));
    }
  }
  else
  {
    const auto boxes = model.ReadBoxes(execution);
    KDSTREAM_TRY(boxes);
    const std::uint32_t nearest = NearestPartition(*boxes, info.depths, point);
    auto region = FindRegion(*boxes, info.depths, NodeOfPartition(nearest, info.depths), rings);
    KDSTREAM_TRY(region);
    partitions = std::move(*region);
  }
  std::sort(partitions.begin(), partitions.end());
  return partitions;
}

Result<unsigned> LevelOf(const ModelDescription& info, int depth)
{
  if (!info.HasLevels())
  {
    return Error{ ErrorCode::InvalidArgument, "the model has no levels, only partitions" };
  }
  if (depth > static_cast<int>(info.depths.finest))
  {
    return Error{ ErrorCode::InvalidArgument, "there is no level " + std::to_string(depth) +
                                                ": the finest is " +
                                                std::to_string(info.depths.finest) };
  }
  return depth < 0 ? PreviewLevel(info) : static_cast<unsigned>(depth);
}

void SetBox(
  vtkInformation& info, const Box& box, std::initializer_list<vtkInformationDoubleVectorKey*> keys)
{
  const double ends[6] = { box.lo[0], box.hi[0], box.lo[1], box.hi[1], box.lo[2], box.hi[2] };
  for (vtkInformationDoubleVectorKey* const key : keys)
  {
    box.Empty() ? info.Remove(key) : info.Set(key, ends, 6);
  }
}

using Range = std::optional<std::pair<double, double>>;

// The range of an array of the original, from the model's description, or as measured. facts: null
// if nothing was measured.
Range RangeOf(const ModelDescription& info, const AttributeInfo& array, const OriginalFacts* facts)
{
  const ScalarDescription* const scalar =
    array.association == AttributeAssociation::Point ? info.scalars.Find(array.name) : nullptr;
  if (scalar)
  {
    return std::pair(scalar->least, scalar->most);
  }
  const auto place = std::find(info.attributes.begin(), info.attributes.end(), array);
  return facts ? facts->ranges[std::size_t(place - info.attributes.begin())] : Range();
}

}

vtkInformationKeyMacro(vtkKdModelSource, NUMBER_OF_POINTS, IdType);
vtkInformationKeyMacro(vtkKdModelSource, NUMBER_OF_CELLS, IdType);

vtkKdModelSource::vtkKdModelSource()
{
  this->SetNumberOfInputPorts(0);
}

vtkKdModelSource::~vtkKdModelSource() = default;

vtkMTimeType vtkKdModelSource::GetMTime()
{
  if (std::exchange(this->IsStale, false))
  {
    this->Modified(); // only now, or the pipeline would consider it loaded
  }
  return std::max(
    { this->Superclass::GetMTime(), this->PointArrays->GetMTime(), this->CellArrays->GetMTime() });
}

void vtkKdModelSource::AddPartition(vtkIdType partition)
{
  this->ChosenPartitions.push_back(partition);
  this->Modified();
}

void vtkKdModelSource::RemoveAllPartitions()
{
  this->ChosenPartitions.clear();
  this->Modified();
}

int vtkKdModelSource::GetFinestLevel() const
{
  return this->Model && this->Model->Info().HasLevels()
           ? static_cast<int>(this->Model->Info().depths.finest)
           : -1;
}

int vtkKdModelSource::GetPreviewLevel() const
{
  return this->Model && this->Model->Info().HasLevels()
           ? static_cast<int>(PreviewLevel(this->Model->Info()))
           : -1;
}

vtkIdType vtkKdModelSource::GetNumberOfModelPartitions() const
{
  return this->Model ? static_cast<vtkIdType>(this->Model->Info().partitions) : 0;
}

vtkIdType vtkKdModelSource::GetNumberOfModelPoints() const
{
  return this->Model ? static_cast<vtkIdType>(this->Model->Info().vertices) : 0;
}

vtkIdType vtkKdModelSource::GetNumberOfModelTriangles() const
{
  return this->Model ? static_cast<vtkIdType>(this->Model->Info().triangles) : 0;
}

const char* vtkKdModelSource::GetOutputTypeAsString() const
{
  return this->OutputType == PolyData ? "PolyData" : "PartitionedDataSet";
}

const char* vtkKdModelSource::GetContentAsString() const
{
  const char* const contents[] = { "Original", "Level", "Partitions", "Region", "View" };
  return contents[this->Content];
}

void vtkKdModelSource::SetCameraViewAngle(double degrees)
{
  if (!(degrees > 0 && degrees < 180))
  {
    vtkErrorMacro(<< "CameraViewAngle must be above 0 and below 180 degrees, not " << degrees
                  << ": it stays " << this->CameraViewAngle);
    return;
  }
  kdstream::SetInRange(*this, "CameraViewAngle", this->CameraViewAngle, degrees, 0, 180);
}

void vtkKdModelSource::SetPictureSize(int width, int height)
{
  if (width < 0 || height < 0)
  {
    vtkErrorMacro(<< "PictureSize must be at least 1 x 1, not " << width << " x " << height
                  << ": it stays " << this->PictureSize[0] << " x " << this->PictureSize[1]);
    return;
  }
  kdstream::SetInRange(*this, "PictureSize", this->PictureSize[0], width, 1, VTK_INT_MAX);
  kdstream::SetInRange(*this, "PictureSize", this->PictureSize[1], height, 1, VTK_INT_MAX);
}

int vtkKdModelSource::Fail(const kdstream::Error& error)
{
  const std::string name = this->ModelName();
  this->OpenAnewNextTime();
  this->SetErrorCode(name.empty() ? static_cast<unsigned long>(vtkErrorCode::NoFileNameError)
                                  : kdstream::VtkErrorCodeOf(error));
  vtkErrorMacro(<< (name.empty() ? "" : name + ": ") << error.message);
  return 0;
}

int vtkKdModelSource::FillOutputPortInformation(int, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkDataObject");
  return 1;
}

int vtkKdModelSource::RequestDataObject(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkInformation* const outInfo = outputVector->GetInformationObject(0);
  const bool whole = this->OutputType == PolyData;
  const char* const type = whole ? "vtkPolyData" : "vtkPartitionedDataSet";
  vtkDataObject* const now = vtkDataObject::GetData(outInfo);
  if (!now || !now->IsA(type))
  {
    vtkSmartPointer<vtkDataObject> output;
    if (whole)
    {
      output = vtkSmartPointer<vtkPolyData>::New();
    }
    else
    {
      output = vtkSmartPointer<vtkPartitionedDataSet>::New();
    }
    outInfo->Set(vtkDataObject::DATA_OBJECT(), output);
  }
  return 1;
}

void vtkKdModelSource::SetAbortExecute(vtkTypeBool abort)
{
  this->WasAborted = this->WasAborted || abort != 0;
  this->Superclass::SetAbortExecute(abort);
}

int vtkKdModelSource::ComputePipelineMTime(vtkInformation* request, vtkInformationVector** input,
  vtkInformationVector* output, int port, vtkMTimeType* time)
{
  ForgetAbort(*this);
  this->WasAborted = false;
  return this->Superclass::ComputePipelineMTime(request, input, output, port, time);
}

int vtkKdModelSource::RequestInformation(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  Error error;
  const Execution execution = MakeOpeningExecution(*this);
  this->Model = this->OpenModel(execution, error);
  this->WasStopped = false;
  if (!this->Model && error.code == ErrorCode::Cancelled)
  {
    return this->StopOpening();
  }
  if (!this->Model)
  {
    if (vtkDataObject* const before = vtkDataObject::GetData(outputVector))
    {
      before->Initialize();
    }
    // Not an error yet if nothing was chosen: programs with panels ask for information before that.
    // RequestData reports it.
    return this->ModelName().empty() ? 1 : this->Fail(error);
  }
  this->LevelRange[1] = this->GetFinestLevel();
  ArraySelections(*this->PointArrays, *this->CellArrays).Follow(this->Model->Info().attributes);
  vtkInformation* const outInfo = outputVector->GetInformationObject(0);
  outInfo->Set(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST(), 1);
  outInfo->Remove(vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA());
  const bool isOriginal = this->Content != Level && this->Content != View;
  if (isOriginal && this->WantsFacts() && !this->MeasureModel(execution))
  {
    return this->StopOpening();
  }
  if (isOriginal && this->OutputType == PartitionedDataSet && this->WantsBoxes() &&
      !this->TellPartitions(outInfo, execution))
  {
    return this->StopOpening();
  }
  this->TellModel(outInfo);
  return 1;
}

// Opening was cancelled. If RequestData follows, it empties the output.
int vtkKdModelSource::StopOpening()
{
  this->Model = nullptr;
  this->WasStopped = true;
  this->IsStale = true;
  return 1;
}

// Sets Facts to those of the open model, or to null if they cannot be fetched. False if cancelled.
bool vtkKdModelSource::MeasureModel(const Execution& execution)
{
  if (this->KnownFacts())
  {
    return true;
  }
  this->Facts.reset();
  auto facts = MeasureOriginal(*this->Model, execution);
  if (!facts && facts.GetError().code == ErrorCode::Cancelled)
  {
    return false;
  }
  if (!facts)
  {
    vtkWarningMacro(<< this->ModelName()
                    << ": the original cannot be measured: " << facts.GetError().message);
    return true;
  }
  this->Facts = std::make_shared<const OriginalFacts>(std::move(*facts));
  this->MeasuredDigest = this->Model->Info().digest;
  return true;
}

// The facts of the open model; null if they are not wanted, or could not be found.
const OriginalFacts* vtkKdModelSource::KnownFacts() const
{
  return this->WantsFacts() && this->Model->Info().digest == this->MeasuredDigest
           ? this->Facts.get()
           : nullptr;
}

// Puts the boxes of the partitions, and known facts about them, into the output information. False
// if cancelled.
bool vtkKdModelSource::TellPartitions(vtkInformation* outInfo, const Execution& execution)
{
  const ModelDescription& info = this->Model->Info();
  vtkNew<vtkPartitionedDataSet> reported;
  reported->SetNumberOfPartitions(static_cast<unsigned int>(info.partitions));
  const OriginalFacts* const facts = this->KnownFacts();
  const auto boxes = facts ? std::vector<Box>() : this->Model->ReadBoxes(execution);
  if (!boxes && boxes.GetError().code == ErrorCode::Cancelled)
  {
    return false;
  }
  if (!boxes)
  {
    vtkWarningMacro(<< this->ModelName() << ": the bounds of partitions cannot be determined: "
                    << boxes.GetError().message);
    return true;
  }
  for (std::uint32_t p = 0; p < info.partitions; ++p)
  {
    vtkInformation& data = *reported->GetMetaData(p);
    SetBox(data, facts ? facts->partitions[p].box : (*boxes)[NodeOfPartition(p, info.depths)],
      { vtkDataObject::BOUNDING_BOX() });
    if (facts)
    {
      data.Set(NUMBER_OF_POINTS(), static_cast<vtkIdType>(facts->partitions[p].points));
      data.Set(NUMBER_OF_CELLS(), static_cast<vtkIdType>(facts->partitions[p].cells));
    }
  }
  outInfo->Set(vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA(), reported);
  return true;
}

void vtkKdModelSource::TellModel(vtkInformation* outInfo) const
{
  const ModelDescription& info = this->Model->Info();
  SetBox(*outInfo, info.box,
    { vtkStreamingDemandDrivenPipeline::BOUNDS(), vtkDataObject::BOUNDING_BOX() });
  const bool ofLevel = this->Content == Level || this->Content == View;
  const auto level = LevelOf(info, this->LevelDepth);
  const ResolutionDescription* const whole = this->Content == Original ? &info.original
                                             : this->Content == Level && level
                                               ? &info.levels[*level]
                                               : nullptr;
  outInfo->Remove(NUMBER_OF_POINTS());
  outInfo->Remove(NUMBER_OF_CELLS());
  const bool isCloud = info.primitive == PrimitiveType::Points;
  const auto points = static_cast<vtkIdType>(whole ? whole->vertices : 0);
  const auto cells = static_cast<vtkIdType>(!whole    ? 0
                                            : isCloud ? whole->vertices
                                                      : whole->triangles);
  if (whole)
  {
    outInfo->Set(NUMBER_OF_POINTS(), points);
    outInfo->Set(NUMBER_OF_CELLS(), cells);
  }
  const OriginalFacts* const facts = this->KnownFacts();
  ArrayFacts reported;
  if (whole)
  {
    reported.points = points;
    reported.cells = cells;
  }
  reported.rangeOf = [&](const AttributeInfo& array) { return RangeOf(info, array, facts); };
  const ArraySelections selections(*this->PointArrays, *this->CellArrays);
  selections.Tell(ofLevel ? ArraysOfLevels(info.attributes) : info.attributes, reported, *outInfo);
}

// The pipeline asks again only if the source was modified: GetMTime sees to that, by IsStale.
void vtkKdModelSource::OpenAnewNextTime()
{
  this->CloseModel();
  this->IsStale = true;
}

ViewDemand vtkKdModelSource::Demand() const
{
  const auto vector = [](const double* v) { return Vec3{ v[0], v[1], v[2] }; };
  ViewDemand demand;
  demand.camera = { vector(this->CameraPosition), vector(this->CameraFocalPoint),
    vector(this->CameraViewUp), this->CameraViewAngle * std::numbers::pi / 180 };
  demand.width = std::max(this->PictureSize[0], 1);
  demand.height = std::max(this->PictureSize[1], 1);
  demand.tolerance = this->Tolerance;
  demand.triangles = static_cast<std::uint64_t>(this->NumberOfTriangles);
  return demand;
}

int vtkKdModelSource::RequestData(
  vtkInformation*, vtkInformationVector**, vtkInformationVector* outputVector)
{
  vtkDataObject* const output = vtkDataObject::GetData(outputVector);
  const auto stop = [&]
  {
    output->Initialize();
    this->SetErrorCode(vtkErrorCode::NoError);
    this->IsStale = true;
    return 1;
  };
  if (this->WasStopped || this->WasAborted)
  {
    return stop();
  }
  if (!this->Model)
  {
    Error error{ ErrorCode::NotFound, "the model is not open" };
    if (this->ModelName().empty())
    {
      this->OpenModel({}, error);
    }
    return this->Fail(error);
  }
  auto* const whole = vtkPolyData::SafeDownCast(output);
  auto* const parts = vtkPartitionedDataSet::SafeDownCast(output);
  const OutputShare share = ShareOf(*outputVector->GetInformationObject(0));
  const Execution execution = MakeReadingExecution(*this);
  const PieceOutput pieces(
    *this->Model,
    [selections = ArraySelections(*this->PointArrays, *this->CellArrays)](
      const AttributeInfo& array) { return selections.IsWanted(array); },
    execution);

  Status status;
  if (this->Content == View)
  {
    status = DrawView(*this->Model, this->Demand(), share, pieces, execution, *output);
  }
  else if (this->Content == Level)
  {
    const auto level = LevelOf(this->Model->Info(), this->LevelDepth);
    status = !level  ? Status(level.GetError())
             : whole ? pieces.DrawInto(*level, share, *whole)
                     : pieces.AddPieces(*level, share, *parts);
  }
  else
  {
    const Vec3 point{ this->RegionPoint[0], this->RegionPoint[1], this->RegionPoint[2] };
    const auto chosen = Choose(*this->Model, this->Content, this->ChosenPartitions, point,
      static_cast<unsigned>(this->Rings), execution);
    status = !chosen ? Status(chosen.GetError())
             : whole ? pieces.GlueInto(*chosen, share, *whole)
                     : pieces.AddPartitions(*chosen, share, *parts);
  }
  if (status)
  {
    this->SetErrorCode(vtkErrorCode::NoError);
    return 1;
  }
  if (status.GetError().code == ErrorCode::Cancelled)
  {
    return stop();
  }
  output->Initialize();
  return this->Fail(status.GetError());
}

void vtkKdModelSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "OutputType: " << this->GetOutputTypeAsString() << "\n";
  os << indent << "Content: " << this->GetContentAsString() << "\n";
  os << indent << "LevelDepth: " << this->LevelDepth << "\n";
  os << indent << "LevelRange: " << this->LevelRange[0] << " " << this->LevelRange[1] << "\n";
  os << indent << "Partitions:";
  for (const vtkIdType partition : this->ChosenPartitions)
  {
    os << " " << partition;
  }
  os << "\n";
  os << indent << "RegionPoint: " << this->RegionPoint[0] << " " << this->RegionPoint[1] << " "
     << this->RegionPoint[2] << "\n";
  os << indent << "Rings: " << this->Rings << "\n";
  const auto vector = [&](const char* name, const double* v)
  { os << indent << name << ": " << v[0] << " " << v[1] << " " << v[2] << "\n"; };
  vector("CameraPosition", this->CameraPosition);
  vector("CameraFocalPoint", this->CameraFocalPoint);
  vector("CameraViewUp", this->CameraViewUp);
  os << indent << "CameraViewAngle: " << this->CameraViewAngle << "\n";
  os << indent << "PictureSize: " << this->PictureSize[0] << " " << this->PictureSize[1] << "\n";
  os << indent << "Tolerance: " << this->Tolerance << "\n";
  os << indent << "NumberOfTriangles: " << this->NumberOfTriangles << "\n";
  os << indent << "PointArrays:\n";
  this->PointArrays->PrintSelf(os, indent.GetNextIndent());
  os << indent << "CellArrays:\n";
  this->CellArrays->PrintSelf(os, indent.GetNextIndent());
}
