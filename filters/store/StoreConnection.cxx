// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreConnection.h"

#include "filters/core/SystemReason.h"
#include "filters/model/ModelJson.h"
#include "filters/store/StoreHead.h"
#include "filters/store/StoreSchema.h"

#include <utility>

namespace kdstream
{
namespace
{

constexpr const char* selectModel = "SELECT value, checksum FROM metadata WHERE key = 'model'";

Error WasChanged()
{
  return { ErrorCode::Changed, "the file was changed while it was open" };
}

}

Result<ModelDescription> ReadStoredModel(int descriptor)
{
  const Result<int> version = CheckStoreHead(descriptor);
  KDSTREAM_TRY(version);
  const Result<Database> database = OpenForReading(descriptor);
  KDSTREAM_TRY(database);
  LimitValues(database->get(), mostMetadataBytes + 100); // with its key and checksum
  Result<Statement> statement = Statement::Prepare(database->get(), selectModel);
  if (!statement)
  {
    return DamagedBlob("metadata", statement.GetError().message);
  }
  const Result<bool> row = statement->Step();
  if (!row)
  {
    return DamagedBlob("metadata", row.GetError().message);
  }
  const std::string json = *row ? statement->Text(0) : std::string();
  if (!*row || MetadataChecksum("model", json) != statement->Integer(1))
  {
    return DamagedBlob(
      "metadata", *row ? "row \"model\" has a wrong checksum" : "row \"model\" is missing");
  }
  Result<ModelDescription> model =
    ParseStoredModel(json, HasRowsOfBlobs(*version) ? StoredForm::Earlier : StoredForm::Present);
  const bool isReported = model && HasRowsOfBlobs(*version); // such a version reports them
  if (isReported && model->textures.has_value() != HasTextures(*version))
  {
    return DamagedBlob("metadata", "its textures do not fit the store's version");
  }
  const bool hasTexturedLevels = model && model->textures && model->textures->levels;
  if (model && hasTexturedLevels != HasTexturedLevels(*version))
  {
    return DamagedBlob("metadata", "its textures do not fit the store's version");
  }
  if (isReported && model->unused.has_value() != HasUnused(*version))
  {
    return DamagedBlob("metadata", "its unused vertices do not fit the store's version");
  }
  return model;
}

Store::Connection::Connection(
  std::unique_ptr<const StoreFile> file, const FileState& state, const ModelDescription& model)
  : File(std::move(file))
  , Model(model)
  , LastState(state)
{
}

Store::Connection::~Connection() = default;

Status Store::Connection::CheckUnchanged()
{
  for (int tries = 0; tries < 3; ++tries)
  {
    const Result<FileState> now = this->File->State();
    KDSTREAM_TRY(now);
    if (const std::optional<bool> same = this->Compare(*now))
    {
      return *same ? Status() : WasChanged();
    }
    const Result<std::string> digestNow = this->ReadDigest();
    const Result<FileState> after = this->File->State();
    KDSTREAM_TRY(after);
    if (*after == *now) // otherwise try again
    {
      KDSTREAM_TRY(digestNow);
      if (*digestNow != this->Model.digest)
      {
        break;
      }
      const std::lock_guard lock(this->Mutex);
      this->LastState = *now; // only the name or permissions changed, not the content
      return this->Changed ? WasChanged() : Status();
    }
  }
  const std::lock_guard lock(this->Mutex);
  this->Changed = true;
  return WasChanged();
}

std::optional<bool> Store::Connection::LooksUnchanged()
{
  const Result<FileState> now = this->File->KnownState();
  return now ? this->Compare(*now) : std::nullopt;
}

// Whether the file is unchanged; nothing if its state alone does not show that.
std::optional<bool> Store::Connection::Compare(const FileState& now)
{
  const std::lock_guard lock(this->Mutex);
  this->Changed = this->Changed || !now.SameContent(this->LastState);
  if (this->Changed)
  {
    return false;
  }
  return now == this->LastState ? std::optional(true) : std::nullopt;
}

FileState Store::Connection::State()
{
  const std::lock_guard lock(this->Mutex);
  return this->LastState;
}

// Reads the digest with a new connection, which has no pages in memory.
Result<std::string> Store::Connection::ReadDigest() const
{
  const Result<ModelDescription> info = ReadStoredModel(this->File->Descriptor());
  if (!info && IsTransient(info.GetError()))
  {
    return info.GetError();
  }
  return info ? info->digest : std::string(); // other content, damaged or not
}

Result<std::unique_ptr<StoreBlobs>> Store::Connection::Take()
{
  {
    const std::lock_guard lock(this->Mutex);
    if (!this->Idle.empty())
    {
      std::unique_ptr<StoreBlobs> blobs = std::move(this->Idle.back());
      this->Idle.pop_back();
      return blobs;
    }
  }
  // The file may have been written to since.
  const Result<int> version = CheckStoreHead(this->File->Descriptor());
  KDSTREAM_TRY(version);
  Result<kdstream::Database> database = OpenForReading(this->File->Descriptor());
  KDSTREAM_TRY(database);
  return StoreBlobs::Open(std::move(*database), *version, this->Model);
}

void Store::Connection::Return(std::unique_ptr<StoreBlobs> blobs)
{
  if (!blobs->Failed())
  {
    const std::lock_guard lock(this->Mutex);
    this->Idle.push_back(std::move(blobs));
  }
}

// Returns the result of `read`, unless the file has changed.
template <class Value, class ReadBlob>
Result<Value> Store::Connection::ReadUnchanged(const BlobRow& blob, const ReadBlob& read)
{
  Result<std::unique_ptr<StoreBlobs>> blobs = this->Take();
  Result<Value> result =
    blobs ? read(**blobs)
          : Error{ IsTransient(blobs.GetError()) ? blobs.GetError().code : ErrorCode::Damaged,
              blob.name + ": " + blobs.GetError().message };
  if (blobs)
  {
    this->Return(std::move(*blobs));
  }
  const Status unchanged = this->CheckUnchanged();
  return unchanged
           ? std::move(result)
           : Error{ unchanged.GetError().code, blob.name + ": " + unchanged.GetError().message };
}

Result<std::vector<std::uint8_t>> Store::Connection::Read(const BlobRow& blob)
{
  return this->ReadUnchanged<std::vector<std::uint8_t>>(blob,
    [&](StoreBlobs& blobs)
    {
      std::uint64_t bytes = 0;
      Result<std::vector<std::uint8_t>> data = blobs.Read(blob, bytes);
      this->Bytes += bytes;
      return data;
    });
}

Result<std::uint64_t> Store::Connection::Size(const BlobRow& blob)
{
  return this->ReadUnchanged<std::uint64_t>(
    blob, [&blob](StoreBlobs& blobs) { return blobs.Size(blob); });
}

Status Store::Connection::VisitMislabelled(
  const std::function<bool(std::int64_t row, const Error& error)>& note)
{
  const Result<std::unique_ptr<StoreBlobs>> blobs = this->Take();
  KDSTREAM_TRY(blobs);
  return (*blobs)->VisitMislabelled(note);
}

}
