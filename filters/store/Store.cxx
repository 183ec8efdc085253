// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/Store.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/model/ModelJson.h"
#include "filters/store/Sqlite.h"
#include "filters/store/StoreFile.h"
#include "filters/store/StoreSchema.h"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>

namespace kdstream
{
namespace
{

constexpr const char* selectPiece =
  "SELECT vertices, triangles, data, checksum FROM pieces WHERE id = ?";
// What a row says of itself is under its checksum, but for these two, which its id says as well.
constexpr const char* selectMislabelled =
  "SELECT id, quote(resolution), quote(node) FROM pieces "
  "WHERE resolution IS NOT id >> 32 OR node IS NOT id & 0xFFFFFFFF";
constexpr const char* selectTreePage = "SELECT data, checksum FROM tree WHERE page = ?";
constexpr const char* selectBoxes = "SELECT data, checksum FROM boxes WHERE node = ?";
constexpr const char* selectPieceSize = "SELECT length(data) FROM pieces WHERE id = ?";
constexpr const char* selectTreePageSize = "SELECT length(data) FROM tree WHERE page = ?";
constexpr const char* selectBoxesSize = "SELECT length(data) FROM boxes WHERE node = ?";
constexpr const char* selectModel = "SELECT value, checksum FROM metadata WHERE key = 'model'";

// The statements of a connection, each with one row to find.
enum Query : std::size_t
{
  piece,
  treePage,
  boxes,
  pieceSize,
  treePageSize,
  boxesSize,
  queries
};
constexpr std::array<const char*, queries> queryTexts{ selectPiece, selectTreePage, selectBoxes,
  selectPieceSize, selectTreePageSize, selectBoxesSize };

// One connection with its statements: used by one thread at a time.
struct Reader
{
  kdstream::Database database;
  std::array<Statement, queries> statements;
};

Error Damaged(const std::string& blob, const std::string& what)
{
  return { ErrorCode::Damaged, blob + ": " + what };
}

// What readers take memory for in advance (the tree, lists of pieces) grows with the partitions,
// each of which has a row with a blob.
Status CheckCounts(const ModelDescription& info, std::uint64_t fileBytes)
{
  constexpr std::uint64_t leastRowBytes = 16;
  const std::uint64_t partitions = std::uint64_t{ 1 } << info.depths.partition;
  if (fileBytes / leastRowBytes < partitions / 2) // more than half of them are there
  {
    return Damaged("metadata", "a file of " + std::to_string(fileBytes) +
                                 " bytes has no room for partitions of depth " +
                                 std::to_string(info.depths.partition));
  }
  return {};
}

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

Result<ModelDescription> ReadInfo(sqlite3* database)
{
  const Result<std::int64_t> application = QueryInteger(database, "PRAGMA application_id");
  if (!application && application.GetError().code != ErrorCode::Damaged)
  {
    return application.GetError();
  }
  if (!application)
  {
    return Damaged("header", application.GetError().message);
  }
  if (*application != storeApplicationId)
  {
    return Error{ ErrorCode::InvalidInput, "not a KdStream store" };
  }
  const Result<std::int64_t> version = QueryInteger(database, "PRAGMA user_version");
  if (!version)
  {
    return Damaged("header", version.GetError().message);
  }
  if (*version != storeVersion)
  {
    return Error{ ErrorCode::Unsupported,
      "store version " + std::to_string(*version) + "; this program reads version " +
        std::to_string(storeVersion) + ": build the store again" };
  }
  Result<Statement> statement = Statement::Prepare(database, selectModel);
  if (!statement)
  {
    return Damaged("metadata", statement.GetError().message);
  }
  const Result<bool> row = statement->Step();
  if (!row)
  {
    return Damaged("metadata", row.GetError().message);
  }
  const std::string json = *row ? statement->Text(0) : std::string();
  if (!*row || MetadataChecksum("model", json) != statement->Integer(1))
  {
    return Damaged(
      "metadata", *row ? "row \"model\" has a wrong checksum" : "row \"model\" is missing");
  }
  return ParseStoredModel(json);
}

}

// The connections to one file: as many as threads have read at the same time.
struct Store::Connection
{
  std::unique_ptr<const StoreFile> file;
  std::string digest;
  std::mutex mutex; // for what follows
  FileState state;
  bool changed = false;
  std::vector<std::unique_ptr<Reader>> idle;

  // Whether what has just been read is of the model that was opened: whoever writes to the file
  // changes its state first. Errors: Changed; InputOutput and LimitExceeded where it cannot be
  // told.
  Status CheckUnchanged()
  {
    const std::lock_guard lock(this->mutex);
    for (int tries = 0; tries < 3 && !this->changed; ++tries)
    {
      const Result<FileState> now = this->file->State();
      KDSTREAM_TRY(now);
      if (*now == this->state)
      {
        return {};
      }
      if (!now->SameContent(this->state))
      {
        break;
      }
      const Result<std::string> digestNow = this->ReadDigest();
      const Result<FileState> after = this->file->State();
      KDSTREAM_TRY(after);
      if (*after == *now) // else once more
      {
        KDSTREAM_TRY(digestNow);
        if (*digestNow != this->digest)
        {
          break;
        }
        this->state = *now; // it has got another name or permission, no other content
        return {};
      }
    }
    this->changed = true;
    return Error{ ErrorCode::Changed, "the file was changed while it was open" };
  }

  FileState State()
  {
    const std::lock_guard lock(this->mutex);
    return this->state;
  }

  // By a connection that has kept no pages.
  Result<std::string> ReadDigest() const
  {
    const Result<kdstream::Database> database = OpenForReading(this->file->Descriptor());
    KDSTREAM_TRY(database);
    const Result<ModelDescription> info = ReadInfo(database->get());
    if (!info && IsTransient(info.GetError()))
    {
      return info.GetError();
    }
    return info ? info->digest : std::string(); // another content, damaged or not
  }

  Result<std::unique_ptr<Reader>> Take()
  {
    {
      const std::lock_guard lock(this->mutex);
      if (!this->idle.empty())
      {
        std::unique_ptr<Reader> reader = std::move(this->idle.back());
        this->idle.pop_back();
        return reader;
      }
    }
    Result<kdstream::Database> database = OpenForReading(this->file->Descriptor());
    KDSTREAM_TRY(database);
    auto reader = std::make_unique<Reader>();
    for (std::size_t query = 0; query < queries; ++query)
    {
      Result<Statement> statement = Statement::Prepare(database->get(), queryTexts[query]);
      KDSTREAM_TRY(statement);
      reader->statements[query] = std::move(*statement);
    }
    reader->database = std::move(*database);
    return reader;
  }

  // note(id, error) for each row of a piece whose other columns do not agree with its id.
  template <class Note>
  Status VisitMislabelled(const Note& note)
  {
    const Result<std::unique_ptr<Reader>> reader = this->Take();
    KDSTREAM_TRY(reader);
    Result<Statement> rows = Statement::Prepare((*reader)->database.get(), selectMislabelled);
    KDSTREAM_TRY(rows);
    Result<bool> row = rows->Step();
    for (; row && *row; row = rows->Step())
    {
      note(rows->Integer(0),
        Damaged("its row", "resolution is " + rows->Text(1) + ", node " + rows->Text(2)));
    }
    return row ? Status{} : row.GetError();
  }

  void Return(std::unique_ptr<Reader> reader)
  {
    const std::lock_guard lock(this->mutex);
    this->idle.push_back(std::move(reader));
  }

  // The blob in column `column` of row `key`, if isWhole(row, data) says that its checksum holds.
  template <class IsWhole>
  Result<std::vector<std::uint8_t>> Read(
    Query select, std::int64_t key, int column, const std::string& name, const IsWhole& isWhole)
  {
    return this->Checked(name, this->ReadRow<std::vector<std::uint8_t>>(select, key, name,
                                 [&](const Statement& row) -> Result<std::vector<std::uint8_t>>
                                 {
                                   const auto data = row.Blob(column);
                                   if (!isWhole(row, data))
                                   {
                                     return Damaged(name, "wrong checksum");
                                   }
                                   return std::vector<std::uint8_t>(data.begin(), data.end());
                                 }));
  }

  // A row of tree or boxes.
  Result<std::vector<std::uint8_t>> ReadOfNode(Query select, NodeId node, const std::string& name)
  {
    return this->Read(select, node, 0, name,
      [node](const Statement& row, std::span<const std::uint8_t> data)
      { return NodeChecksum(node, data) == row.Integer(1); });
  }

  // The number in the only column of row `key`.
  Result<std::uint64_t> ReadNumber(Query select, std::int64_t key, const std::string& name)
  {
    return this->Checked(
      name, this->ReadRow<std::uint64_t>(select, key, name,
              [](const Statement& row) { return static_cast<std::uint64_t>(row.Integer(0)); }));
  }

private:
  // What was read, unless the file is another one by now.
  template <class Value>
  Result<Value> Checked(const std::string& name, Result<Value> read)
  {
    const Status unchanged = this->CheckUnchanged();
    if (!unchanged)
    {
      return Error{ unchanged.GetError().code, name + ": " + unchanged.GetError().message };
    }
    return read;
  }

  // What `take` makes of the row `key`.
  template <class Value, class Take>
  Result<Value> ReadRow(Query select, std::int64_t key, const std::string& name, const Take& take)
  {
    Result<std::unique_ptr<Reader>> reader = this->Take();
    if (!reader)
    {
      return OfBlob(name, reader.GetError());
    }
    Statement& statement = (*reader)->statements[select];
    statement.Bind(1, key);
    const Result<bool> row = statement.Step();
    Result<Value> result = row ? Damaged(name, "row is missing") : OfBlob(name, row.GetError());
    if (row && *row)
    {
      result = take(statement);
    }
    statement.Reset();
    this->Return(std::move(*reader));
    return result;
  }
};

Store::Store() = default;
Store::~Store() = default;

Result<std::shared_ptr<Store>> Store::Open(const std::filesystem::path& file)
{
  Result<std::unique_ptr<const StoreFile>> opened = StoreFile::Open(file);
  KDSTREAM_TRY(opened);
  const Result<FileState> state = (*opened)->State();
  KDSTREAM_TRY(state);
  Result<kdstream::Database> database = OpenForReading((*opened)->Descriptor());
  KDSTREAM_TRY(database);
  Result<ModelDescription> info = ReadInfo(database->get());
  const Result<FileState> after = (*opened)->State();
  KDSTREAM_TRY(after);
  if (!(*after == *state))
  {
    return Error{ ErrorCode::InputOutput, "is being written" };
  }
  KDSTREAM_TRY(info);
  KDSTREAM_TRY(CheckCounts(*info, static_cast<std::uint64_t>(state->size)));
  database->reset(); // before the file is closed, should there be no memory for the store
  std::shared_ptr<Store> store(new Store);
  store->Information = std::move(*info);
  store->Database = std::make_unique<Connection>();
  store->Database->digest = store->Information.digest;
  store->Database->state = *state;
  store->Database->file = std::move(*opened);
  return store;
}

Status Store::CheckUnchanged() const
{
  return this->Database->CheckUnchanged();
}

bool Store::IsFile(const std::filesystem::path& file) const
{
  return this->Database->CheckUnchanged() && FileState::Of(file) == this->Database->State();
}

std::string Store::BlobName(PieceId id, const TreeDepths& depths)
{
  if (id.resolution.IsOriginal())
  {
    return "partitions/" + std::to_string(id.node - (NodeId{ 1 } << depths.partition));
  }
  return "levels/" + std::to_string(id.resolution.Depth()) + "/" + std::to_string(id.node);
}

std::string Store::NameOfRow(std::int64_t row) const
{
  const std::optional<PieceId> id = PieceOfRow(row);
  return id && this->Information.HasPiece(*id) ? BlobName(*id, this->Information.depths)
                                               : "pieces/" + std::to_string(row);
}

std::string Store::TreePageName(NodeId page)
{
  return "tree/" + std::to_string(page);
}

std::string Store::BoxesName(NodeId node)
{
  return "boxes/" + std::to_string(node);
}

Result<std::vector<std::uint8_t>> Store::ReadPieceBlob(PieceId id) const
{
  const TreeDepths& depths = this->Information.depths;
  if (!this->Information.HasPiece(id))
  {
    return Error{ ErrorCode::NotFound, "the model has no such piece" };
  }
  return this->Database->Read(Query::piece, PieceRow(id), 2, BlobName(id, depths),
    [id](const Statement& row, std::span<const std::uint8_t> data)
    {
      const auto vertices = static_cast<std::uint64_t>(row.Integer(0));
      const auto triangles = static_cast<std::uint64_t>(row.Integer(1));
      return PieceChecksum(id, vertices, triangles, data) == row.Integer(3);
    });
}

Result<std::vector<std::uint8_t>> Store::ReadTreePageBlob(NodeId page) const
{
  if (!IsTreePage(page, this->Information.depths))
  {
    return Error{ ErrorCode::NotFound, "the model has no such tree page" };
  }
  return this->Database->ReadOfNode(Query::treePage, page, TreePageName(page));
}

Result<std::vector<std::uint8_t>> Store::ReadBoxesBlob(NodeId node) const
{
  if (!HasPartitionBoxes(node, this->Information.depths))
  {
    return Error{ ErrorCode::NotFound, "the model has no such boxes" };
  }
  return this->Database->ReadOfNode(Query::boxes, node, BoxesName(node));
}

Result<std::uint64_t> Store::PieceBlobSize(PieceId id) const
{
  if (!this->Information.HasPiece(id))
  {
    return Error{ ErrorCode::NotFound, "the model has no such piece" };
  }
  return this->Database->ReadNumber(
    Query::pieceSize, PieceRow(id), BlobName(id, this->Information.depths));
}

Result<std::uint64_t> Store::TreePageBlobSize(NodeId page) const
{
  if (!IsTreePage(page, this->Information.depths))
  {
    return Error{ ErrorCode::NotFound, "the model has no such tree page" };
  }
  return this->Database->ReadNumber(Query::treePageSize, page, TreePageName(page));
}

Result<std::uint64_t> Store::BoxesBlobSize(NodeId node) const
{
  if (!HasPartitionBoxes(node, this->Information.depths))
  {
    return Error{ ErrorCode::NotFound, "the model has no such boxes" };
  }
  return this->Database->ReadNumber(Query::boxesSize, node, BoxesName(node));
}

Result<Piece> Store::ReadPiece(PieceId id) const
{
  const auto blob = this->ReadPieceBlob(id);
  KDSTREAM_TRY(blob);
  return this->Decode(*blob, id);
}

Result<Piece> Store::Decode(std::span<const std::uint8_t> blob, PieceId id) const
{
  Result<Piece> piece = DecodePiece(blob, id, this->Information.Codec());
  if (piece && !this->AttributesFit(*piece))
  {
    return Error{ ErrorCode::Damaged,
      BlobName(id, this->Information.depths) + ": its attributes are not those of the metadata" };
  }
  return piece;
}

// The original has them all; levels those whose mean says something.
bool Store::AttributesFit(const Piece& piece) const
{
  std::vector<AttributeInfo> expected = this->Information.attributes;
  if (!piece.id.resolution.IsOriginal())
  {
    std::erase_if(expected, [](const AttributeInfo& info) { return !IsInLevels(info); });
  }
  return std::equal(expected.begin(), expected.end(), piece.attributes.begin(),
    piece.attributes.end(),
    [](const AttributeInfo& info, const Attribute& attribute) { return attribute.Info() == info; });
}

Result<std::vector<Box>> Store::ReadBoxes() const
{
  const TreeDepths& depths = this->Information.depths;
  std::vector<Box> all(std::size_t{ 2 } << depths.partition);
  for (const NodeId node : AllPartitionBoxes(depths))
  {
    const auto blob = this->ReadBoxesBlob(node);
    KDSTREAM_TRY(blob);
    KDSTREAM_TRY(this->DecodeBoxes(*blob, node, all));
  }
  UniteBoxes(all);
  return all;
}

Status Store::DecodeBoxes(std::span<const std::uint8_t> blob, NodeId node, std::span<Box> all) const
{
  const TreeDepths& depths = this->Information.depths;
  const auto told = DecodePartitionBoxes(blob, node, depths);
  KDSTREAM_TRY(told);
  const NodeId first = node << (depths.partition - DepthOfNode(node));
  std::copy(told->begin(), told->end(), all.begin() + first);
  return {};
}

Result<PieceTable> Store::ReadPieceTable(std::span<const Box> boxes) const
{
  PieceTable pieces(this->Information.depths, this->Information.HasLevels());
  for (const NodeId page : TreePages(this->Information.depths))
  {
    const auto blob = this->ReadTreePageBlob(page);
    KDSTREAM_TRY(blob);
    KDSTREAM_TRY(this->DecodePage(*blob, page, boxes, pieces));
  }
  return pieces;
}

Status Store::DecodePage(std::span<const std::uint8_t> blob, NodeId page,
  std::span<const Box> boxes, PieceTable& pieces) const
{
  const TreeDepths& depths = this->Information.depths;
  const auto told =
    DecodeTreePage(blob, page, RoundedBoxOf(boxes, page), depths, this->Information.HasLevels());
  KDSTREAM_TRY(told);
  if (told->boxes != RoundTreePage(boxes, page, depths, pieces).boxes)
  {
    return Damaged(TreePageName(page), "its boxes are not those of the partitions");
  }
  const std::vector<PieceId> ids = PiecesOfTreePage(page, depths, this->Information.HasLevels());
  for (std::size_t i = 0; i < ids.size(); ++i)
  {
    pieces.At(ids[i]) = told->facts[i];
  }
  return {};
}

std::vector<PieceId> Store::PieceIds() const
{
  std::vector<PieceId> ids;
  const ModelDescription& info = this->Information;
  const auto add = [&](Resolution resolution, std::uint64_t count)
  {
    const unsigned depth = PieceDepth(resolution, info.depths);
    for (NodeId i = 0; i < count; ++i)
    {
      ids.push_back({ resolution, (NodeId{ 1 } << depth) + i });
    }
  };
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    const Resolution level = Resolution::Level(depth);
    add(level, std::uint64_t{ 1 } << PieceDepth(level, info.depths));
  }
  add(Resolution::Original(), info.partitions);
  return ids;
}

// Reads all that a store has, in the order of its digest, and notes what is wrong.
class Store::Verification
{
public:
  Verification(const Store& store, const Execution& execution)
    : Whole(store)
    , Progress(execution)
    , Digest(store.Information)
  {
  }

  std::vector<Error> Run()
  {
    const Status labels =
      this->Whole.Database->VisitMislabelled([this](std::int64_t row, const Error& error)
        { this->Note(this->Whole.NameOfRow(row), error); });
    this->Note("pieces", labels);
    if (const Status pieces = this->CheckPieces(); !pieces)
    {
      this->Found.push_back(pieces.GetError()); // cancelled
      return std::move(this->Found);
    }
    this->CheckTree();
    if (this->Found.empty() && this->Digest.Hexadecimal() != this->Whole.Information.digest)
    {
      this->Found.push_back(Damaged("metadata", "the digest does not match the content"));
    }
    return std::move(this->Found);
  }

private:
  void Note(const std::string& name, const Status& status)
  {
    if (!status)
    {
      const Error& error = status.GetError();
      const bool named = error.message.rfind(name, 0) == 0;
      this->Found.push_back({ error.code, named ? error.message : name + ": " + error.message });
    }
  }

  Status CheckPieces()
  {
    const std::vector<PieceId> ids = this->Whole.PieceIds();
    for (std::size_t i = 0; i < ids.size(); ++i)
    {
      const std::string name = BlobName(ids[i], this->Whole.Information.depths);
      const auto blob = this->Whole.ReadPieceBlob(ids[i]);
      this->Note(name, OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddPiece(ids[i], *blob);
        this->Note(name, OnlyStatus(this->Whole.Decode(*blob, ids[i])));
      }
      KDSTREAM_TRY(this->Progress.Report("verify", double(i + 1) / double(ids.size())));
    }
    return {};
  }

  void CheckTree()
  {
    const TreeDepths& depths = this->Whole.Information.depths;
    std::vector<Box> boxes(std::size_t{ 2 } << depths.partition);
    const std::size_t before = this->Found.size();
    for (const NodeId node : AllPartitionBoxes(depths))
    {
      const auto blob = this->Whole.ReadBoxesBlob(node);
      this->Note(
        BoxesName(node), blob ? this->Whole.DecodeBoxes(*blob, node, boxes) : OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddBoxes(node, *blob);
      }
    }
    UniteBoxes(boxes);
    const bool boxesKnown = this->Found.size() == before; // pages are told within them
    PieceTable pieces(depths, this->Whole.Information.HasLevels());
    for (const NodeId page : TreePages(depths))
    {
      const auto blob = this->Whole.ReadTreePageBlob(page);
      this->Note(TreePageName(page),
        blob && boxesKnown ? this->Whole.DecodePage(*blob, page, boxes, pieces) : OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddTreePage(page, *blob);
      }
    }
  }

  template <class Value>
  static Status OnlyStatus(const Result<Value>& result)
  {
    return result ? Status{} : Status{ result.GetError() };
  }

  const Store& Whole;
  const Execution& Progress;
  ContentDigest Digest;
  std::vector<Error> Found;
};

std::vector<Error> Store::Verify(const Execution& execution) const
{
  return Verification(*this, execution).Run();
}

}
