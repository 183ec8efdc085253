// SPDX-License-Identifier: BSD-3-Clause
// Steps, from version 13 on:
// 1. Find the number of the blob in the order in which blobs were written.
// 2. Find its place in the row of the directory that describes this number.
// 3. Read the rows of the content from its beginning to its end.
// 4. Verify its checksum.
#include "filters/store/StoreBlobs.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/protocol/BlobId.h"
#include "filters/store/StoreSchema.h"

#include <algorithm>
#include <array>
#include <utility>

namespace kdstream
{
namespace
{

// ---- the order of all blobs

std::uint64_t NodesOfDepth(unsigned depth)
{
  return std::uint64_t{ 1 } << depth;
}

// The order of blobs, as in the digest: levels coarse to fine; partitions, each followed by its
// texture; textures of levels, fine to coarse; boxes; pages of the tree; the parts of the list of
// unused vertices.
class BlobOrder
{
public:
  explicit BlobOrder(const ModelDescription& model)
    : Depths(model.depths)
    , PerPartition(model.textures ? 2 : 1)
  {
    for (unsigned depth = 0; depth < model.levels.size(); ++depth)
    {
      this->Levels.push_back(this->Original);
      this->Original += NodesOfDepth(PieceDepth(Resolution::Level(depth), model.depths));
    }
    this->LevelTextures = this->Original + model.partitions * this->PerPartition;
    this->Boxes = this->LevelTextures;
    this->Boxes += model.textures && model.textures->levels ? this->Original : 0;
    this->Tree = this->Boxes + NodesOfDepth(DepthOfPartitionBoxes(model.depths));
    this->Unused = this->Tree + this->TreePagesAbove(model.depths.partition);
  }

  // REQUIRES: the model has the blob.
  std::uint64_t Of(const BlobRow& blob) const
  {
    const auto key = static_cast<std::uint64_t>(blob.key);
    const auto node = static_cast<NodeId>(blob.key & 0xFFFFFFFF);
    switch (blob.table)
    {
      case BlobTable::Pieces:
        return this->OfPiece(*PieceOfRow(blob.key));
      case BlobTable::Textures:
        return this->Original + 2 * key + 1;
      case BlobTable::LevelTextures:
        return this->OfLevelTexture(*PieceOfRow(blob.key));
      case BlobTable::Boxes:
        return this->Boxes + key - NodesOfDepth(DepthOfPartitionBoxes(this->Depths));
      case BlobTable::Tree:
        return node == 1 ? this->Tree
                         : this->Tree + this->TreePagesAbove(DepthOfNode(node)) + key -
                             NodesOfDepth(DepthOfNode(node));
      case BlobTable::Unused:
        break;
    }
    return this->Unused + key;
  }

private:
  std::uint64_t OfPiece(PieceId id) const
  {
    const std::uint64_t place = id.node - NodesOfDepth(PieceDepth(id.resolution, this->Depths));
    return id.resolution.IsOriginal() ? this->Original + place * this->PerPartition
                                      : this->Levels[id.resolution.Depth()] + place;
  }

  // The textures of all finer levels come first.
  std::uint64_t OfLevelTexture(PieceId id) const
  {
    const unsigned depth = PieceDepth(id.resolution, this->Depths);
    const std::uint64_t end = this->Levels[id.resolution.Depth()] + NodesOfDepth(depth);
    return this->LevelTextures + this->Original - end + (id.node - NodesOfDepth(depth));
  }

  // How many pages of the tree begin at nodes above this depth.
  std::uint64_t TreePagesAbove(unsigned depth) const
  {
    std::uint64_t pages = 1;
    for (unsigned above = 1; above < depth; ++above)
    {
      const NodeId first = NodeId{ 1 } << above;
      pages += IsTreePage(first, this->Depths) ? NodesOfDepth(above) : 0;
    }
    return pages;
  }

  TreeDepths Depths;
  std::uint64_t PerPartition;        // blobs of a partition: a piece, or a piece and its texture
  std::vector<std::uint64_t> Levels; // the number of the first piece of each level
  std::uint64_t Original = 0, LevelTextures = 0, Boxes = 0, Tree = 0, Unused = 0;
};

// ---- from version 13 on

constexpr const char* selectDirectory =
  "SELECT data FROM directory WHERE part = ? AND typeof(data) = 'blob'";
constexpr const char* selectContent =
  "SELECT data FROM content WHERE part = ? AND typeof(data) = 'blob'";

class PackedBlobs : public StoreBlobs
{
public:
  PackedBlobs(
    Database database, Statement directory, Statement content, const ModelDescription& model)
    : File(std::move(database))
    , Directory(std::move(directory))
    , Content(std::move(content))
    , Order(model)
  {
    LimitValues(this->File.get(), contentRowBytes + 100);
  }

  Result<std::vector<std::uint8_t>> Read(const BlobRow& blob, std::uint64_t& bytesRead) override
  {
    const Result<BlobPlace> place = this->PlaceOf(blob);
    KDSTREAM_TRY(place);
    Result<std::vector<std::uint8_t>> data = this->Gather(blob, *place);
    KDSTREAM_TRY(data);
    bytesRead += data->size();
    return BlobChecksum(*data) == place->checksum ? std::move(data)
                                                  : DamagedBlob(blob.name, "wrong checksum");
  }

  Result<std::uint64_t> Size(const BlobRow& blob) override
  {
    const Result<BlobPlace> place = this->PlaceOf(blob);
    KDSTREAM_TRY(place);
    return std::uint64_t{ place->bytes };
  }

  Status VisitMislabelled(const std::function<bool(std::int64_t, const Error&)>&) override
  {
    return {};
  }

private:
  Result<BlobPlace> PlaceOf(const BlobRow& blob)
  {
    constexpr std::uint64_t mostContent = std::uint64_t{ 1 } << 62;
    const std::uint64_t number = this->Order.Of(blob), part = number / blobsOfDirectoryRow,
                        at = number % blobsOfDirectoryRow;
    this->Directory.Bind(1, static_cast<std::int64_t>(part));
    const Result<bool> row = this->Directory.Step();
    auto places = row && *row ? DecodeDirectoryRow(part, this->Directory.Blob(0)) : std::nullopt;
    this->Directory.Reset();
    if (!row)
    {
      return this->Fail(blob, row.GetError());
    }
    if (!places || at >= places->size())
    {
      return DamagedBlob(
        blob.name, *row && !places ? "the directory is damaged" : "row is missing");
    }
    const BlobPlace& place = (*places)[at];
    return place.bytes <= protocol::maximumBlobBytes && place.begin < mostContent
             ? Result<BlobPlace>(place)
             : DamagedBlob(blob.name, "the directory is damaged");
  }

  // Rows are read one by one, so that no memory is allocated for sizes that are only claimed.
  Result<std::vector<std::uint8_t>> Gather(const BlobRow& blob, const BlobPlace& place)
  {
    std::vector<std::uint8_t> data;
    data.reserve(std::min<std::size_t>(place.bytes, 8 * contentRowBytes));
    while (data.size() < place.bytes)
    {
      const std::uint64_t at = place.begin + data.size();
      const Status taken = this->TakeRow(blob, static_cast<std::int64_t>(at / contentRowBytes),
        at % contentRowBytes, place.bytes - data.size(), data);
      this->Content.Reset();
      KDSTREAM_TRY(taken);
    }
    return data;
  }

  // Appends the bytes of a row from offset `from` on, at most `most` bytes.
  Status TakeRow(const BlobRow& blob, std::int64_t part, std::size_t from, std::size_t most,
    std::vector<std::uint8_t>& data)
  {
    this->Content.Bind(1, part);
    const Result<bool> row = this->Content.Step();
    if (!row)
    {
      return this->Fail(blob, row.GetError());
    }
    if (!*row)
    {
      return DamagedBlob(blob.name, "row is missing");
    }
    const auto bytes = this->Content.Blob(0);
    const std::size_t to = std::min(contentRowBytes, from + most);
    if (bytes.size() < to)
    {
      return DamagedBlob(blob.name, "its row is too short");
    }
    data.insert(data.end(), bytes.begin() + static_cast<std::ptrdiff_t>(from),
      bytes.begin() + static_cast<std::ptrdiff_t>(to));
    return {};
  }

  Database File; // closed after the statements
  Statement Directory, Content;
  const BlobOrder Order;
};

// ---- before version 13

// First the queries of blobs, in the order of BlobTable; then those of their sizes. Without the
// check of the type, SQLite would accept a text as a blob, and return the number of its characters
// instead of bytes.
constexpr std::size_t tableCount = 5;
constexpr std::array<const char*, 2 * tableCount> rowQueries{
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
// Finds rows whose resolution or node contradicts their id. The checksum covers all other columns.
constexpr const char* selectMislabelled =
  "SELECT id, quote(resolution), quote(node) FROM pieces "
  "WHERE resolution IS NOT id >> 32 OR node IS NOT id & 0xFFFFFFFF";

std::int64_t ChecksumOf(
  const BlobRow& blob, const Statement& row, std::span<const std::uint8_t> data)
{
  return blob.table == BlobTable::Pieces
           ? PieceChecksum(*PieceOfRow(blob.key), static_cast<std::uint64_t>(row.Integer(2)),
               static_cast<std::uint64_t>(row.Integer(3)), data)
           : NodeChecksum(static_cast<NodeId>(blob.key), data);
}

class RowsOfBlobs : public StoreBlobs
{
public:
  using Statements = std::array<Statement, rowQueries.size()>;

  RowsOfBlobs(Database database, Statements statements)
    : File(std::move(database))
    , Queries(std::move(statements))
  {
  }

  static Result<Statements> Prepare(sqlite3* database, int version)
  {
    const auto hasTable = [version](BlobTable table)
    {
      return table == BlobTable::Textures ? HasTextures(version)
             : table == BlobTable::Unused ? HasUnused(version)
                                          : true;
    };
    Statements statements;
    for (std::size_t query = 0; query < rowQueries.size(); ++query)
    {
      if (hasTable(static_cast<BlobTable>(query % tableCount)))
      {
        Result<Statement> statement = Statement::Prepare(database, rowQueries[query]);
        KDSTREAM_TRY(statement);
        statements[query] = std::move(*statement);
      }
    }
    return statements;
  }

  Result<std::vector<std::uint8_t>> Read(const BlobRow& blob, std::uint64_t& bytesRead) override
  {
    return this->ReadRow<std::vector<std::uint8_t>>(blob, 0,
      [&](const Statement& row) -> Result<std::vector<std::uint8_t>>
      {
        const auto data = row.Blob(0);
        bytesRead += data.size();
        if (ChecksumOf(blob, row, data) != row.Integer(1))
        {
          return DamagedBlob(blob.name, "wrong checksum");
        }
        return std::vector<std::uint8_t>(data.begin(), data.end());
      });
  }

  Result<std::uint64_t> Size(const BlobRow& blob) override
  {
    return this->ReadRow<std::uint64_t>(blob, tableCount,
      [](const Statement& row) { return static_cast<std::uint64_t>(row.Integer(0)); });
  }

  Status VisitMislabelled(const std::function<bool(std::int64_t, const Error&)>& note) override
  {
    Result<Statement> rows = Statement::Prepare(this->File.get(), selectMislabelled);
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

private:
  // Returns what `take` makes of the row. first: the number of the first query of this kind.
  template <class Value, class TakeRow>
  Result<Value> ReadRow(const BlobRow& blob, std::size_t first, const TakeRow& take)
  {
    Statement& statement = this->Queries[static_cast<std::size_t>(blob.table) + first];
    statement.Bind(1, blob.key);
    const Result<bool> row = statement.Step();
    Result<Value> result = !row    ? this->Fail(blob, row.GetError())
                           : !*row ? Result<Value>(DamagedBlob(blob.name, "row is missing"))
                                   : Result<Value>(take(statement));
    statement.Reset();
    return result;
  }

  Database File; // closed after the statements
  Statements Queries;
};

}

Error DamagedBlob(const std::string& blob, const std::string& what)
{
  return { ErrorCode::Damaged, blob + ": " + what };
}

// Temporary errors stay as they are; all others count as damage.
Error StoreBlobs::Fail(const BlobRow& blob, const Error& error)
{
  this->HasFailed = true;
  const bool mayPass =
    error.code == ErrorCode::InputOutput || error.code == ErrorCode::LimitExceeded;
  return { mayPass ? error.code : ErrorCode::Damaged, blob.name + ": " + error.message };
}

Result<std::unique_ptr<StoreBlobs>> StoreBlobs::Open(
  Database database, int version, const ModelDescription& model)
{
  if (HasRowsOfBlobs(version))
  {
    Result<RowsOfBlobs::Statements> statements = RowsOfBlobs::Prepare(database.get(), version);
    KDSTREAM_TRY(statements);
    return std::unique_ptr<StoreBlobs>(
      std::make_unique<RowsOfBlobs>(std::move(database), std::move(*statements)));
  }
  Result<Statement> directory = Statement::Prepare(database.get(), selectDirectory);
  KDSTREAM_TRY(directory);
  Result<Statement> content = Statement::Prepare(database.get(), selectContent);
  KDSTREAM_TRY(content);
  return std::unique_ptr<StoreBlobs>(std::make_unique<PackedBlobs>(
    std::move(database), std::move(*directory), std::move(*content), model));
}

}
