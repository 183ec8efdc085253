// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. opens the model, and reads the tile, which has the size of the picture;
// 2. reads the piece;
// 3. outputs its triangles, with points split where they have several places in the picture;
// 4. outputs the picture, from bottom to top.
#include "vtkKdTextureReader.h"

#include "filters/adapter/ErrorCodes.h"
#include "filters/adapter/MeshPolyData.h"
#include "filters/adapter/RangedSetters.h"
#include "filters/codec/TextureTile.h"
#include "filters/core/BitCast.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/store/Store.h"
#include "filters/texture/Picture.h"
#include "viewer/sources/SourceExecution.h"
#include "viewer/sources/vtkKdModelSource.h"

#include <vtkDataObject.h>
#include <vtkDemandDrivenPipeline.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkObjectFactory.h>
#include <vtkPolyData.h>
#include <vtkStreamingDemandDrivenPipeline.h>

#include <algorithm>
#include <map>
#include <span>
#include <utility>

vtkStandardNewMacro(vtkKdTextureReader);

KDSTREAM_SET_IN_RANGE(vtkKdTextureReader, Level, int, -1, 30)
KDSTREAM_SET_IN_RANGE(vtkKdTextureReader, Partition, vtkIdType, 0, VTK_ID_MAX)

namespace
{

using namespace kdstream;

Error OfTexture(const PieceSource& model, PieceId piece, const Error& error)
{
  return { ErrorCode::Damaged,
    BlobName(TextureOfPiece(piece, model.Info().depths)) + ": " + error.message };
}

// The mesh, with a separate point for each place in the tile that a vertex has.
Mesh SplitMesh(const Piece& piece, const TextureTile& tile, ScalarType scalarType)
{
  Mesh mesh;
  mesh.scalarType = scalarType;
  Attribute places{ { "TCoords", AttributeType::Float32, AttributeAssociation::Point, 2 }, {} };
  std::vector<const Attribute*> from;
  for (const Attribute& array : piece.attributes)
  {
    const AttributeRole role = RoleOf(array);
    if (array.association == AttributeAssociation::Point && role != AttributeRole::Colors &&
        role != AttributeRole::TextureCoordinates)
    {
      from.push_back(&array);
      mesh.attributes.push_back({ array.Info(), {} });
    }
  }
  std::map<std::pair<VertexId, std::uint64_t>, VertexId> numbers;
  std::size_t points = 0;
  std::vector<std::array<float, 2>> coordinates;
  for (std::size_t t = 0; t < piece.triangles.size(); ++t)
  {
    if (!piece.Owns(piece.triangles[t]))
    {
      continue;
    }
    Triangle& triangle = mesh.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId vertex = piece.triangles[t][k];
      const TileCoordinate& at = tile.corners[t][k];
      const auto [entry, isNew] =
        numbers.try_emplace({ vertex, BitCast<std::uint64_t>(at) }, static_cast<VertexId>(points));
      triangle[k] = entry->second;
      if (!isNew)
      {
        continue;
      }
      ++points;
      mesh.points.push_back(piece.positions[vertex]);
      coordinates.push_back({ at[0] / float(tile.width), 1 - at[1] / float(tile.height) });
      for (std::size_t i = 0; i < from.size(); ++i)
      {
        mesh.attributes[i].Append(*from[i], vertex);
      }
    }
  }
  places.values.resize(points * places.TupleSize());
  for (std::size_t i = 0; i < points; ++i)
  {
    places.Set(i, 0, double(coordinates[i][0]));
    places.Set(i, 1, double(coordinates[i][1]));
  }
  mesh.attributes.push_back(std::move(places));
  return mesh;
}

// Copies the picture, last row first: VTK's rows go upwards.
void FillImage(const Picture& picture, vtkImageData& image)
{
  const int components = picture.components % 2 == 0 ? 4 : 3;
  image.SetDimensions(int(picture.width), int(picture.height), 1);
  image.AllocateScalars(VTK_UNSIGNED_CHAR, components);
  auto* to = static_cast<std::uint8_t*>(image.GetScalarPointer());
  for (std::size_t y = picture.height; y-- > 0;)
  {
    const std::uint8_t* texel = &picture.texels[y * picture.width * picture.components];
    for (std::size_t x = 0; x < picture.width; ++x, texel += picture.components)
    {
      const auto rgba = RgbaOf(texel, picture.components);
      to = std::copy_n(rgba.begin(), components, to);
    }
  }
}

Result<Picture> DecodeImage(const TextureTile& tile)
{
  Result<Picture> picture = DecodePicture(tile.image, std::uint64_t{ tile.width } * tile.height);
  if (picture && (picture->width != tile.width || picture->height != tile.height))
  {
    return Error{ ErrorCode::Damaged, "its image does not have the size that the tile states" };
  }
  return picture;
}

vtkIdType NumberOfPieces(const ModelDescription& info, int level)
{
  if (level < 0)
  {
    return static_cast<vtkIdType>(info.partitions);
  }
  const auto depth = static_cast<unsigned>(level);
  return depth < info.levels.size()
           ? vtkIdType{ 1 } << PieceDepth(Resolution::Level(depth), info.depths)
           : 0;
}

// The piece with this number. Errors: the model does not have it, or has no texture for it.
Result<PieceId> TexturedPieceOf(const ModelDescription& info, int level, vtkIdType wanted)
{
  if (!info.textures || (level >= 0 && !info.textures->levels))
  {
    return Error{ ErrorCode::Unsupported,
      info.textures ? "only the original has textures" : "the model has no textures" };
  }
  const vtkIdType pieces = NumberOfPieces(info, level);
  if (wanted >= pieces && level < 0)
  {
    return Error{ ErrorCode::InvalidArgument, "there is no partition " + std::to_string(wanted) +
                                                ": the model has " + std::to_string(pieces) };
  }
  if (wanted >= pieces)
  {
    return Error{ ErrorCode::InvalidArgument, "there is no piece " + std::to_string(wanted) +
                                                " of level " + std::to_string(level) +
                                                ": there are " + std::to_string(pieces) };
  }
  const Resolution resolution =
    level < 0 ? Resolution::Original() : Resolution::Level(static_cast<unsigned>(level));
  const NodeId first = NodeId{ 1 } << PieceDepth(resolution, info.depths);
  return PieceId{ resolution, first + static_cast<NodeId>(wanted) };
}

Status ReadInto(const PieceSource& model, PieceId id, const std::vector<std::uint8_t>& blob,
  const Execution& execution, vtkPolyData& surface, vtkImageData& image)
{
  const auto read = model.ReadPieces(std::span(&id, 1), execution);
  KDSTREAM_TRY(read);
  const Piece& piece = read->front();
  const Result<TextureTile> tile = DecodeTextureTile(blob, piece.triangles, piece.positions);
  if (!tile)
  {
    return OfTexture(model, id, tile.GetError());
  }
  const Result<Picture> picture = DecodeImage(*tile);
  if (!picture)
  {
    return OfTexture(model, id, picture.GetError());
  }
  FillImage(*picture, image);
  return FillPolyData(
    SplitMesh(piece, *tile, model.Info().grid.scalarType), 0,
    [](const AttributeInfo&) { return true; }, surface);
}

}

vtkKdTextureReader::vtkKdTextureReader()
{
  this->SetNumberOfInputPorts(0);
  this->SetNumberOfOutputPorts(2);
}

vtkKdTextureReader::~vtkKdTextureReader()
{
  this->SetFileName(nullptr);
}

int vtkKdTextureReader::CanReadFile(const char* name)
{
  const auto store = Store::Open(name ? name : "");
  return store && (*store)->Info().textures ? 1 : 0;
}

void vtkKdTextureReader::SetModelSource(vtkKdModelSource* source)
{
  if (this->ModelSource != source)
  {
    this->ModelSource = source;
    this->Modified();
  }
}

vtkKdModelSource* vtkKdTextureReader::GetModelSource() const
{
  return this->ModelSource;
}

vtkMTimeType vtkKdTextureReader::GetMTime()
{
  if (std::exchange(this->IsStale, false))
  {
    this->Modified(); // only now, or the pipeline would consider it read
  }
  const vtkMTimeType own = this->Superclass::GetMTime();
  return this->ModelSource ? std::max(own, this->ModelSource->GetMTime()) : own;
}

vtkIdType vtkKdTextureReader::GetNumberOfModelPartitions() const
{
  return this->Model ? NumberOfPieces(this->Model->Info(), this->Level) : 0;
}

vtkPolyData* vtkKdTextureReader::GetOutput()
{
  return vtkPolyData::SafeDownCast(this->GetOutputDataObject(0));
}

vtkImageData* vtkKdTextureReader::GetPicture()
{
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}

int vtkKdTextureReader::FillOutputPortInformation(int port, vtkInformation* info)
{
  info->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkPolyData" : "vtkImageData");
  return 1;
}

vtkTypeBool vtkKdTextureReader::ProcessRequest(
  vtkInformation* request, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_INFORMATION()))
  {
    return this->RequestInformation(outputVector);
  }
  if (request->Has(vtkDemandDrivenPipeline::REQUEST_DATA()))
  {
    return this->RequestData(outputVector);
  }
  return this->Superclass::ProcessRequest(request, inputVector, outputVector);
}

std::string vtkKdTextureReader::ModelName() const
{
  return this->ModelSource ? this->ModelSource->ModelName() : this->FileName ? this->FileName : "";
}

// Reports an error; the next Update opens the model again.
int vtkKdTextureReader::Fail(const kdstream::Error& error)
{
  const std::string name = this->ModelName();
  if (this->ModelSource)
  {
    this->ModelSource->OpenAnewNextTime();
  }
  this->IsStale = true;
  for (vtkDataObject* const output : { this->GetOutputDataObject(0), this->GetOutputDataObject(1) })
  {
    if (output)
    {
      output->Initialize();
    }
  }
  this->SetErrorCode(name.empty() ? static_cast<unsigned long>(vtkErrorCode::NoFileNameError)
                                  : kdstream::VtkErrorCodeOf(error));
  vtkErrorMacro(<< (name.empty() ? "" : name + ": ") << error.message);
  return 0;
}

bool vtkKdTextureReader::OpenModel(const Execution& execution, Error& error)
{
  this->Model = nullptr;
  if (this->ModelSource)
  {
    this->Model = this->ModelSource->OpenModel(execution, error);
  }
  else if (!this->FileName || !*this->FileName)
  {
    error = { ErrorCode::NotFound, "no FileName is set" };
  }
  else
  {
    auto store = Store::Open(this->FileName);
    error = store ? Error() : store.GetError();
    this->Model = store ? *store : nullptr;
  }
  return this->Model != nullptr;
}

void vtkKdTextureReader::SetAbortExecute(vtkTypeBool abort)
{
  this->WasAborted = this->WasAborted || abort != 0;
  this->Superclass::SetAbortExecute(abort);
}

int vtkKdTextureReader::ComputePipelineMTime(vtkInformation* request, vtkInformationVector** input,
  vtkInformationVector* output, int port, vtkMTimeType* time)
{
  ForgetAbort(*this);
  this->WasAborted = false;
  return this->Superclass::ComputePipelineMTime(request, input, output, port, time);
}

int vtkKdTextureReader::RequestInformation(vtkInformationVector* outputVector)
{
  const Execution execution = MakeOpeningExecution(*this);
  Error error;
  Result<std::vector<std::uint8_t>> tile = error;
  Result<PieceId> piece = error;
  if (this->OpenModel(execution, error))
  {
    piece = TexturedPieceOf(this->Model->Info(), this->Level, this->Partition);
    tile = piece ? this->Model->Read(TextureOfPiece(*piece, this->Model->Info().depths), execution)
                 : Result<std::vector<std::uint8_t>>(piece.GetError());
    error = tile ? Error() : tile.GetError();
  }
  this->WasStopped = !tile && error.code == ErrorCode::Cancelled;
  if (this->WasStopped)
  {
    this->IsStale = true;
    return 1; // if RequestData follows, it empties the outputs
  }
  if (!tile)
  {
    return this->Fail(error);
  }
  const auto head = ReadTextureTileHead(*tile);
  if (!head)
  {
    return this->Fail(OfTexture(*this->Model, *piece, head.GetError()));
  }
  this->Tile = std::move(*tile);
  vtkInformation* const outInfo = outputVector->GetInformationObject(1);
  const int extent[6] = { 0, static_cast<int>(head->width) - 1, 0,
    static_cast<int>(head->height) - 1, 0, 0 };
  outInfo->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent, 6);
  vtkDataObject::SetPointDataActiveScalarInfo(outInfo, VTK_UNSIGNED_CHAR, -1);
  return 1;
}

int vtkKdTextureReader::RequestData(vtkInformationVector* outputVector)
{
  auto* const surface = vtkPolyData::GetData(outputVector, 0);
  auto* const image = vtkImageData::GetData(outputVector, 1);
  Status read = Error{ ErrorCode::Cancelled, "" };
  if (!this->WasStopped && !this->WasAborted)
  {
    if (!this->Model)
    {
      return this->Fail({ ErrorCode::NotFound, "the model is not open" });
    }
    const auto piece = TexturedPieceOf(this->Model->Info(), this->Level, this->Partition);
    read = piece ? ReadInto(*this->Model, *piece, this->Tile, MakeReadingExecution(*this), *surface,
                     *image)
                 : Status{ piece.GetError() };
  }
  if (read)
  {
    this->SetErrorCode(vtkErrorCode::NoError);
    return 1;
  }
  if (read.GetError().code != ErrorCode::Cancelled)
  {
    return this->Fail(read.GetError());
  }
  surface->Initialize();
  image->Initialize();
  this->SetErrorCode(vtkErrorCode::NoError);
  this->IsStale = true;
  return 1;
}

void vtkKdTextureReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "ModelSource: " << this->ModelSource.Get() << "\n";
  os << indent << "Level: " << this->Level << "\n";
  os << indent << "Partition: " << this->Partition << "\n";
}
