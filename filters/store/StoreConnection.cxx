// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/StoreConnection.h"

#include "filters/model/ModelJson.h"
#include "filters/store/StoreHead.h"
#include "filters/store/StoreSchema.h"

#include <array>
#include <utility>

namespace kdstream
{
namespace
{

// In the order of BlobTable: blobs, and how many bytes they have. SQLite would take a text for a
// blob, of which it tells the characters as its length, and not the bytes.
constexpr std::size_t tableCount = 5;
constexpr std::array<const char*, 2 * tableCount> queryTexts{
  "SELECT data, checksum, vertices, triangles FROM pieces WHERE id = ? AND typeof(data) = 'blob'",
  "SELECT data, checksum FROM tree WHERE page = ? AND typeof(data) = 'blob'",
  "SELECT data, checksum FROM boxes WHERE node = ? AND typeof(data) = 'blob'",
  "SELECT data, checksum FROM textures WHERE partition = ? AND typeof(data) = 'blob'",
  "SELECT data, checksum FROM unused WHERE part = ? AND typeof(data) = 'blob'",
  "SELECT length(data) FROM pieces WHERE id = ? AND typeof(data) = 'blob'",
  "SELECT length(data) FROM tree WHERE page = ? AND typeof(data) = 'blob'",
  "SELECT length(data) FROM boxes WHERE node = ? AND typeof(data) = 'blob'",
  "SELECT length(data) FROM textures WHERE partition = ? AND typeof(data) = 'blob'",
  "SELECT length(data) FROM unused WHERE part = ? AND typeof(data) = 'blob'",
};
// What a row says of itself is under its checksum, but for these two, which its id says as well.
constexpr const char* selectMislabelled =
  "SELECT id, quote(resolution), quote(node) FROM pieces "
  "WHERE resolution IS NOT id >> 32 OR node IS NOT id & 0xFFFFFFFF";
constexpr const char* selectModel = "SELECT value, checksum FROM metadata WHERE key = 'model'";

// Whether the same may succeed later.
bool IsTransient(const Error& error)
{
  return error.code == ErrorCode::InputOutput || error.code == ErrorCode::LimitExceeded;
}

// What has failed on the way to a blob: what may pass stays what it is, all else is damage.
Error OfBlob(const std::string& blob, const Error& error)
{
  return { IsTransient(error) ? error.code : ErrorCode::Damaged, blob + ": " + error.message };
}

Error WasChanged()
{
  return { ErrorCode::Changed, "the file was changed while it was open" };
}

std::int64_t ChecksumOf(
  const BlobRow& blob, const Statement& row, std::span<const std::uint8_t> data)
{
  return blob.table == BlobTable::Pieces
           ? PieceChecksum(*PieceOfRow(blob.key), static_cast<std::uint64_t>(row.Integer(2)),
               static_cast<std::uint64_t>(row.Integer(3)), data)
           : NodeChecksum(static_cast<NodeId>(blob.key), data);
}

}

Error DamagedBlob(const std::string& blob, const std::string& what)
{
  return { ErrorCode::Damaged, blob + ": " + what };
}

Result<ModelDescription> ReadStoredModel(int descriptor)
{
  const Result<int> version = CheckStoreHead(descriptor);
  KDSTREAM_TRY(version);
  const Result<Database> database = OpenForReading(descriptor);
  KDSTREAM_TRY(database);
  LimitValues(database->get(), mostMetadataBytes + 100); // with its key and its checksum
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
  Result<ModelDescription> model = ParseStoredModel(json);
  if (model && model->textures.has_value() != HasTextures(*version))
  {
    return DamagedBlob("metadata", "what it says of textures is not of the store's version");
  }
  if (model && model->unused.has_value() != HasUnused(*version))
  {
    return DamagedBlob("metadata", "what it says of unused vertices is not of the store's version");
  }
  return model;
}

// One connection with its statements: used by one thread at a time.
struct Store::Connection::Reader
{
  kdstream::Database database;
  std::array<Statement, queryTexts.size()> statements;
};

Store::Connection::Connection(
  std::unique_ptr<const StoreFile> file, const FileState& state, const ModelDescription& model)
  : File(std::move(file))
  , Digest(model.digest)
  , Textured(model.textures.has_value())
  , WithUnused(model.unused.has_value())
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
    if (*after == *now) // else once more
    {
      KDSTREAM_TRY(digestNow);
      if (*digestNow != this->Digest)
      {
        break;
      }
      const std::lock_guard lock(this->Mutex);
      this->LastState = *now; // it has got another name or permission, no other content
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

// Whether the file is what it was, where its state alone tells that.
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

// By a connection that has kept no pages.
Result<std::string> Store::Connection::ReadDigest() const
{
  const Result<ModelDescription> info = ReadStoredModel(this->File->Descriptor());
  if (!info && IsTransient(info.GetError()))
  {
    return info.GetError();
  }
  return info ? info->digest : std::string(); // another content, damaged or not
}

Result<std::unique_ptr<Store::Connection::Reader>> Store::Connection::Take()
{
  {
    const std::lock_guard lock(this->Mutex);
    if (!this->Idle.empty())
    {
      std::unique_ptr<Reader> reader = std::move(this->Idle.back());
      this->Idle.pop_back();
      return reader;
    }
  }
  KDSTREAM_TRY(CheckStoreHead(this->File->Descriptor())); // it may have been written to
  Result<kdstream::Database> database = OpenForReading(this->File->Descriptor());
  KDSTREAM_TRY(database);
  auto reader = std::make_unique<Reader>();
  for (std::size_t query = 0; query < queryTexts.size(); ++query)
  {
    if (!this->HasTable(query % tableCount))
    {
      continue;
    }
    Result<Statement> statement = Statement::Prepare(database->get(), queryTexts[query]);
    KDSTREAM_TRY(statement);
    reader->statements[query] = std::move(*statement);
  }
  reader->database = std::move(*database);
  return reader;
}

void Store::Connection::Return(std::unique_ptr<Reader> reader)
{
  const std::lock_guard lock(this->Mutex);
  this->Idle.push_back(std::move(reader));
}

bool Store::Connection::HasTable(std::size_t table) const
{
  return table == static_cast<std::size_t>(BlobTable::Textures) ? this->Textured
         : table == static_cast<std::size_t>(BlobTable::Unused) ? this->WithUnused
                                                                : true;
}

// What `take` makes of the row, unless the file is another one by now.
template <class Value, class TakeRow>
Result<Value> Store::Connection::ReadRow(const BlobRow& blob, bool sizeOnly, const TakeRow& take)
{
  Result<std::unique_ptr<Reader>> reader = this->Take();
  Result<Value> result =
    reader ? DamagedBlob(blob.name, "row is missing") : OfBlob(blob.name, reader.GetError());
  if (reader)
  {
    Statement& statement =
      (*reader)->statements[static_cast<std::size_t>(blob.table) + (sizeOnly ? tableCount : 0)];
    statement.Bind(1, blob.key);
    const Result<bool> row = statement.Step();
    if (!row)
    {
      result = OfBlob(blob.name, row.GetError());
    }
    else if (*row)
    {
      result = take(statement);
    }
    statement.Reset();
    if (row) // SQLite reports a damaged page once: a connection that has it in memory uses it
    {
      this->Return(std::move(*reader));
    }
  }
  const Status unchanged = this->CheckUnchanged();
  return unchanged
           ? std::move(result)
           : Error{ unchanged.GetError().code, blob.name + ": " + unchanged.GetError().message };
}

Result<std::vector<std::uint8_t>> Store::Connection::Read(const BlobRow& blob)
{
  return this->ReadRow<std::vector<std::uint8_t>>(blob, false,
    [&](const Statement& row) -> Result<std::vector<std::uint8_t>>
    {
      const auto data = row.Blob(0);
      this->Bytes += data.size();
      if (ChecksumOf(blob, row, data) != row.Integer(1))
      {
        return DamagedBlob(blob.name, "wrong checksum");
      }
      return std::vector<std::uint8_t>(data.begin(), data.end());
    });
}

Result<std::uint64_t> Store::Connection::Size(const BlobRow& blob)
{
  return this->ReadRow<std::uint64_t>(
    blob, true, [](const Statement& row) { return static_cast<std::uint64_t>(row.Integer(0)); });
}

Status Store::Connection::VisitMislabelled(
  const std::function<bool(std::int64_t id, const Error& error)>& note)
{
  const Result<std::unique_ptr<Reader>> reader = this->Take();
  KDSTREAM_TRY(reader);
  Result<Statement> rows = Statement::Prepare((*reader)->database.get(), selectMislabelled);
  KDSTREAM_TRY(rows);
  Result<bool> row = rows->Step();
  for (; row && *row; row = rows->Step())
  {
    if (!note(rows->Integer(0),
          DamagedBlob("its row", "resolution is " + rows->Text(1) + ", node " + rows->Text(2))))
    {
      break;
    }
  }
  return row ? Status{} : row.GetError();
}

}
