// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreWriter.h"

#include "filters/core/SystemReason.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/files/NewFile.h"
#include "filters/store/GeometricErrorList.h"
#include "filters/store/LevelBounds.h"
#include "filters/store/ScalarStatistics.h"
#include "filters/store/Sqlite.h"
#include "filters/store/Store.h"
#include "filters/store/StoreSchema.h"

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <utility>

namespace kdstream
{

namespace
{

// geometricErrors: one or more for a piece of a level; empty for a piece of the original.
PieceFacts FactsOf(std::vector<float> geometricErrors, std::size_t bytes)
{
  if (geometricErrors.empty())
  {
    return { 0, 0, static_cast<std::uint32_t>(bytes) };
  }
  const auto at99 =
    geometricErrors.begin() + static_cast<std::ptrdiff_t>((geometricErrors.size() - 1) * 99 / 100);
  std::nth_element(geometricErrors.begin(), at99, geometricErrors.end());
  return { *at99, *std::max_element(at99, geometricErrors.end()),
    static_cast<std::uint32_t>(bytes) };
}

// The distance of a point from a box along the axis where it is largest. Not the Euclidean
// distance: squares of the largest doubles would overflow.
double DistanceFrom(const Box& box, const Vec3& point)
{
  double most = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    most = std::max({ most, box.lo[k] - point[k], point[k] - box.hi[k] });
  }
  return most;
}

Status CheckBlobSize(const std::string& name, std::size_t bytes)
{
  return bytes <= protocol::maximumBlobBytes
           ? Status{}
           : Error{
               ErrorCode::LimitExceeded,
               name + " has " + std::to_string(bytes) +
                 " bytes, more than the 64 MiB that servers send: use fewer vertices per partition"
             };
}

}

struct StoreWriter::State
{
  NewFile file;
  ModelDescription info;
  ScalarStatistics scalars{ info.attributes };
  Database database{}; // closed before the file is removed
  Statement directory{}, content{};
  std::vector<std::uint8_t> contentRow{};          // the row being filled
  std::vector<BlobPlace> directoryRow{};           // the same
  std::int64_t contentRows = 0, directoryRows = 0; // rows written
  std::uint64_t contentBytes = 0;
  std::unique_ptr<ContentDigest> digest{};
  std::unique_ptr<GeometricErrorList> geometricErrors{}; // of the resolution that is being written
  PieceTable pieces{};
  struct Extent // in the content
  {
    std::uint64_t begin = 0;
    std::size_t bytes = 0;
  };
  // Pieces, textures of the original and textures of levels, each in the order of adding.
  std::vector<Extent> pieceExtents{}, textureExtents{}, levelTextureExtents{};
  Statement contentRead{};
  std::mutex reading{};
  std::vector<std::uint8_t> preview{};
  std::uint32_t unusedParts = 0;
  double farthest = -1; // distance of the unused vertex farthest from the box, along one axis

  static Result<std::unique_ptr<State>> Begin(
    const std::filesystem::path& store, ModelDescription info);

  // Appends a blob after those already added. Errors include the name of the store.
  Status AddBlob(std::span<const std::uint8_t> data);
  // Writes the last rows. Errors: as AddBlob.
  Status FinishBlobs();
  Status WriteContentRow();
  Status WriteDirectoryRow();
  Status Insert(Statement& insert, std::int64_t part, std::span<const std::uint8_t> data) const;
  // The number of a piece within its resolution.
  static std::size_t PlaceOf(PieceId id) { return id.node - (NodeId{ 1 } << DepthOfNode(id.node)); }
  std::size_t PiecesOfLevels(unsigned end) const; // number of pieces of levels coarser than `end`
  // Returns the blob of a piece that was added. Any number of threads may call it and ReadTexture.
  // Errors include the name of the store.
  Result<std::vector<std::uint8_t>> ReadPiece(PieceId id);
  Result<std::vector<std::uint8_t>> ReadTexture(PieceId id);
  Result<std::vector<std::uint8_t>> Read(const Extent& extent);
  // Raises the geometric errors of levels to the upper bounds of their distance from the original.
  Status BoundGeometricErrors(const Execution& execution);

  // Why something could not be written, with the name of the store. For a full disk, also how much
  // space is missing.
  Error Explain(const Error& error) const;

  // The number of bytes that the store will take, estimated from the bytes written so far.
  std::uint64_t BytesInAll(std::uint64_t written) const;
};

Error StoreWriter::State::Explain(const Error& error) const
{
  const std::string store = this->file.Target().string();
  const int full = this->file.WhyFull();
  if (full == 0)
  {
    return OfFile(store, Status(error)).GetError();
  }
  std::uint64_t written = this->info.original.bytes;
  for (const ResolutionDescription& level : this->info.levels)
  {
    written += level.bytes + level.tileBytes;
  }
  written += this->info.textures ? this->info.textures->bytes : 0;
  written += this->info.unused ? this->info.unused->bytes : 0;
  const auto mebibytes = [](std::uint64_t bytes)
  { return std::to_string((bytes + (1U << 20) - 1) >> 20) + " MiB"; };
  const std::string sizes = "the store needs about " + mebibytes(this->BytesInAll(written)) +
                            ", of which about " + mebibytes(written) + " are written";
  if (full == EFBIG)
  {
    return { ErrorCode::DiskFull,
      "files cannot grow this large here: " + sizes + " (" + SystemReason(full) + ")", store };
  }
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(this->file.Folder(), unknown);
  return { ErrorCode::DiskFull,
    "the disk is too full: " + sizes + "; " +
      (unknown ? std::string("too few bytes") : mebibytes(space.available)) + " are free in " +
      this->file.Folder().string() + " (" + SystemReason(full) + ")",
    store };
}

// Estimates the bytes of all pieces from those written so far, assuming that each further vertex
// takes the same. If some vertices of the original have been written, only their size counts,
// because they have more attributes. A level that is still to come has at least one vertex in each
// cell.
std::uint64_t StoreWriter::State::BytesInAll(std::uint64_t written) const
{
  constexpr double expected = 16; // bytes of a vertex with its triangles, before any are written
  std::uint64_t made = 0, left = 0;
  for (unsigned depth = 0; depth < this->info.levels.size(); ++depth)
  {
    const ResolutionDescription& level = this->info.levels[depth];
    const std::uint64_t cells = std::uint64_t{ 1 } << depth;
    made += level.vertices;
    left += cells - std::min(cells, level.vertices);
  }
  const ResolutionDescription& original = this->info.original;
  left += this->info.vertices - std::min(this->info.vertices, original.vertices);
  const double ofVertex = original.vertices > 0 ? double(original.bytes) / double(original.vertices)
                          : made > 0            ? double(written) / double(made)
                                                : expected;
  return written + static_cast<std::uint64_t>(ofVertex * double(left));
}

StoreWriter::StoreWriter(std::unique_ptr<State> state)
  : S(std::move(state))
{
}

StoreWriter::~StoreWriter() = default;

Result<std::unique_ptr<StoreWriter::State>> StoreWriter::State::Begin(
  const std::filesystem::path& store, ModelDescription info)
{
  NewFile::RemoveLeftovers(store);
  Result<NewFile> file = NewFile::Create(store);
  KDSTREAM_TRY(file);
  auto state = std::unique_ptr<State>(new State{ std::move(*file), std::move(info) });
  state->geometricErrors = std::make_unique<GeometricErrorList>(state->file.Folder());
  state->digest = std::make_unique<ContentDigest>(state->info);
  state->pieces = PieceTable(state->info.depths, state->info.HasLevels());
  Result<Database> database = OpenEmpty(state->file.Descriptor());
  KDSTREAM_TRY(database);
  state->database = std::move(*database);
  // The file is discarded unless it is finished. So it has no journal, and one fsync at the end.
  const int version = VersionOfStore(state->info);
  const std::string setUp = "PRAGMA page_size = " + std::to_string(storePageBytes) +
                            "; PRAGMA application_id = " + std::to_string(storeApplicationId) +
                            "; PRAGMA user_version = " + std::to_string(version) + ";" +
                            SchemaOfStore(version) + "BEGIN;";
  if (Status status = Execute(state->database.get(), setUp); !status)
  {
    return state->Explain(status.GetError());
  }
  Result<Statement> directory =
    Statement::Prepare(state->database.get(), "INSERT INTO directory VALUES (?, ?)");
  Result<Statement> content =
    Statement::Prepare(state->database.get(), "INSERT INTO content VALUES (?, ?)");
  KDSTREAM_TRY(directory);
  KDSTREAM_TRY(content);
  Result<Statement> contentRead =
    Statement::Prepare(state->database.get(), "SELECT data FROM content WHERE part = ?");
  KDSTREAM_TRY(contentRead);
  state->contentRead = std::move(*contentRead);
  state->directory = std::move(*directory);
  state->content = std::move(*content);
  return state;
}

Result<std::unique_ptr<StoreWriter>> StoreWriter::Create(
  const std::filesystem::path& store, ModelDescription info)
{
  Result<std::unique_ptr<State>> state =
    OfFile(store.string(), State::Begin(store, std::move(info)));
  KDSTREAM_TRY(state);
  return std::unique_ptr<StoreWriter>(new StoreWriter(std::move(*state)));
}

const PieceTable& StoreWriter::Pieces() const
{
  return this->S->pieces;
}

Status StoreWriter::State::Insert(
  Statement& insert, std::int64_t part, std::span<const std::uint8_t> data) const
{
  insert.Bind(1, part);
  insert.Bind(2, data);
  const Result<bool> done = insert.Step();
  const Status status = done ? Status{} : Status{ this->Explain(done.GetError()) };
  insert.Reset();
  return status;
}

Status StoreWriter::State::WriteContentRow()
{
  KDSTREAM_TRY(this->Insert(this->content, this->contentRows++, this->contentRow));
  this->contentRow.clear();
  return {};
}

Status StoreWriter::State::WriteDirectoryRow()
{
  const auto part = static_cast<std::uint64_t>(this->directoryRows);
  KDSTREAM_TRY(this->Insert(
    this->directory, this->directoryRows++, EncodeDirectoryRow(part, this->directoryRow)));
  this->directoryRow.clear();
  return {};
}

Status StoreWriter::State::AddBlob(std::span<const std::uint8_t> data)
{
  this->directoryRow.push_back(
    { this->contentBytes, static_cast<std::uint32_t>(data.size()), BlobChecksum(data) });
  this->contentBytes += data.size();
  if (this->directoryRow.size() == blobsOfDirectoryRow)
  {
    KDSTREAM_TRY(this->WriteDirectoryRow());
  }
  while (!data.empty())
  {
    const auto part = data.first(std::min(data.size(), contentRowBytes - this->contentRow.size()));
    this->contentRow.insert(this->contentRow.end(), part.begin(), part.end());
    data = data.subspan(part.size());
    if (this->contentRow.size() == contentRowBytes)
    {
      KDSTREAM_TRY(this->WriteContentRow());
    }
  }
  return {};
}

Status StoreWriter::State::FinishBlobs()
{
  KDSTREAM_TRY(this->contentRow.empty() ? Status{} : this->WriteContentRow());
  return this->directoryRow.empty() ? Status{} : this->WriteDirectoryRow();
}

std::size_t StoreWriter::State::PiecesOfLevels(unsigned end) const
{
  std::size_t count = 0;
  for (unsigned depth = 0; depth < end; ++depth)
  {
    count += std::size_t{ 1 } << PieceDepth(Resolution::Level(depth), this->info.depths);
  }
  return count;
}

// Levels come first, coarse to fine, then the original, which may have fewer pieces than 2^P.
Result<std::vector<std::uint8_t>> StoreWriter::State::ReadPiece(PieceId id)
{
  const auto levels = static_cast<unsigned>(this->info.levels.size());
  const unsigned before = id.resolution.IsOriginal() ? levels : id.resolution.Depth();
  return this->Read(this->pieceExtents.at(this->PiecesOfLevels(before) + PlaceOf(id)));
}

Result<std::vector<std::uint8_t>> StoreWriter::State::ReadTexture(PieceId id)
{
  if (id.resolution.IsOriginal())
  {
    return this->Read(this->textureExtents.at(PlaceOf(id)));
  }
  const auto levels = static_cast<unsigned>(this->info.levels.size());
  const std::size_t finer =
    this->PiecesOfLevels(levels) - this->PiecesOfLevels(id.resolution.Depth() + 1U);
  return this->Read(this->levelTextureExtents.at(finer + PlaceOf(id)));
}

Result<std::vector<std::uint8_t>> StoreWriter::State::Read(const Extent& extent)
{
  std::uint64_t begin = extent.begin;
  std::vector<std::uint8_t> data;
  data.reserve(extent.bytes);
  const std::lock_guard<std::mutex> lock(this->reading);
  while (data.size() < extent.bytes)
  {
    const auto row = static_cast<std::int64_t>(begin / contentRowBytes);
    const auto offset = static_cast<std::size_t>(begin % contentRowBytes);
    std::span<const std::uint8_t> part = this->contentRow; // if the row has not been written yet
    if (row < this->contentRows)
    {
      this->contentRead.Bind(1, row);
      const Result<bool> found = this->contentRead.Step();
      if (!found)
      {
        return this->Explain(found.GetError());
      }
      part = *found ? this->contentRead.Blob(0) : std::span<const std::uint8_t>{};
    }
    if (part.size() <= offset)
    {
      return this->Explain({ ErrorCode::InputOutput,
        "row " + std::to_string(row) + " cannot be read back: is the disk sound?" });
    }
    part = part.subspan(offset);
    part = part.first(std::min(part.size(), extent.bytes - data.size()));
    data.insert(data.end(), part.begin(), part.end());
    begin += part.size();
    this->contentRead.Reset();
  }
  return data;
}

Status StoreWriter::State::BoundGeometricErrors(const Execution& execution)
{
  const Result<std::vector<double>> bounds = BoundLevels(
    this->info, [&](PieceId id) { return this->ReadPiece(id); }, execution);
  KDSTREAM_TRY(bounds);
  for (std::size_t depth = 0; depth < bounds->size(); ++depth)
  {
    double& reported = this->info.levels[depth].geometricError;
    reported = std::max(reported, (*bounds)[depth]);
  }
  return {};
}

Status StoreWriter::AddBoxes(NodeId node, std::span<const std::uint8_t> data)
{
  this->S->digest->AddBoxes(node, data);
  return this->S->AddBlob(data);
}

Status StoreWriter::AddTreePage(NodeId page, std::span<const std::uint8_t> data)
{
  this->S->digest->AddTreePage(page, data);
  return this->S->AddBlob(data);
}

Status StoreWriter::AddTexture(
  std::uint32_t partition, std::span<const std::uint8_t> data, std::uint64_t texels)
{
  KDSTREAM_TRY(CheckBlobSize(BlobName(protocol::BlobId::Texture(partition)), data.size()));
  this->S->info.textures->bytes += data.size();
  this->S->info.textures->texels += texels;
  this->S->digest->AddTexture(partition, data);
  this->S->textureExtents.push_back({ this->S->contentBytes, data.size() });
  return this->S->AddBlob(data);
}

Status StoreWriter::AddLevelTexture(
  PieceId piece, std::span<const std::uint8_t> data, std::uint64_t texels)
{
  ModelDescription& info = this->S->info;
  KDSTREAM_TRY(CheckBlobSize(BlobName(TextureOfPiece(piece, info.depths)), data.size()));
  ResolutionDescription& level = info.levels[piece.resolution.Depth()];
  level.tileBytes += data.size();
  level.texels += texels;
  this->S->digest->AddLevelTexture(piece, data);
  this->S->levelTextureExtents.push_back({ this->S->contentBytes, data.size() });
  return this->S->AddBlob(data);
}

Result<std::vector<std::uint8_t>> StoreWriter::ReadPiece(PieceId piece) const
{
  return this->S->ReadPiece(piece);
}

Result<std::vector<std::uint8_t>> StoreWriter::ReadTexture(PieceId piece) const
{
  return this->S->ReadTexture(piece);
}

Status StoreWriter::AddUnused(const Piece& part, std::span<const std::uint8_t> data)
{
  State& state = *this->S;
  const std::uint32_t number = state.unusedParts++;
  KDSTREAM_TRY(CheckBlobSize(Store::UnusedName(number), data.size()));
  UnusedDescription& reported = *state.info.unused;
  reported.bytes += data.size();
  for (const Vec3& point : part.positions)
  {
    const double distance = DistanceFrom(state.info.box, point);
    if (distance > state.farthest)
    {
      state.farthest = distance;
      reported.farthest = point;
    }
  }
  state.digest->AddUnused(number, data);
  return state.AddBlob(data);
}

Status StoreWriter::AddPiece(const Piece& piece, std::span<const std::uint8_t> data)
{
  ModelDescription& info = this->S->info;
  KDSTREAM_TRY(CheckBlobSize(BlobName(BlobOfPiece(piece.id, info.depths)), data.size()));
  ResolutionDescription& resolution =
    piece.id.resolution.IsOriginal() ? info.original : info.levels[piece.id.resolution.Depth()];
  resolution.vertices += piece.ownVertices;
  resolution.bytes += data.size();
  ++resolution.pieces;
  if (piece.id.resolution.IsOriginal())
  {
    this->S->scalars.Add(piece);
  }
  if (Status status = this->S->geometricErrors->Add(piece.geometricErrors); !status)
  {
    return this->S->Explain(status.GetError());
  }
  this->S->pieces.At(piece.id) = FactsOf(piece.geometricErrors, data.size());
  this->S->pieceExtents.push_back({ this->S->contentBytes, data.size() });
  this->S->digest->AddPiece(piece.id, data);
  if (piece.id == PieceId{ Resolution::Level(PreviewLevel(info)), 1 })
  {
    this->S->preview.assign(data.begin(), data.end());
  }
  return this->S->AddBlob(data);
}

const std::vector<std::uint8_t>& StoreWriter::Preview() const
{
  return this->S->preview;
}

void StoreWriter::SetHomeView(const HomeView& homeView)
{
  this->S->info.homeView = homeView;
}

Status StoreWriter::FinishResolution(
  Resolution resolution, std::uint64_t triangles, const Execution& execution)
{
  ModelDescription& info = this->S->info;
  ResolutionDescription& finished =
    resolution.IsOriginal() ? info.original : info.levels[resolution.Depth()];
  finished.triangles = triangles;
  const Result<GeometricErrorList::Summary> geometricErrors =
    OfFile(this->S->file.Target().string(), this->S->geometricErrors->Finish());
  KDSTREAM_TRY(geometricErrors);
  finished.geometricError99 = geometricErrors->at99;
  finished.geometricError = geometricErrors->largest;
  return resolution.IsOriginal() ? this->S->BoundGeometricErrors(execution) : Status{};
}

Result<ModelDescription> StoreWriter::Finish()
{
  State& state = *this->S;
  state.info.digest = state.digest->Hexadecimal();
  state.info.scalars = state.scalars.Describe();
  const std::string json = WriteStoredModel(state.info);
  KDSTREAM_TRY(OfFile(state.file.Target().string(), CheckMetadataSize(json)));
  KDSTREAM_TRY(state.FinishBlobs());
  {
    Result<Statement> insert =
      Statement::Prepare(state.database.get(), "INSERT INTO metadata VALUES ('model', ?, ?)");
    KDSTREAM_TRY(insert);
    insert->Bind(1, json);
    insert->Bind(2, MetadataChecksum("model", json));
    if (const Result<bool> done = insert->Step(); !done)
    {
      return state.Explain(done.GetError());
    }
  }
  if (Status status = Execute(state.database.get(), "COMMIT"); !status)
  {
    return state.Explain(status.GetError());
  }
  state.directory = {};
  state.content = {};
  state.contentRead = {};
  state.database.reset();
  KDSTREAM_TRY(OfFile(state.file.Target().string(), state.file.Finish()));
  return state.info;
}

}
