// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/Store.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TreePage.h"
#include "filters/store/StoreConnection.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/UnusedList.h"

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

using protocol::BlobId;

// Readers allocate memory in proportion to the pieces (the tree, lists of pieces). So the file must
// be large enough for them: a piece of one vertex takes some 30 bytes, and 12 in the directory.
Status CheckCounts(const ModelDescription& info, std::uint64_t fileBytes)
{
  constexpr std::uint64_t leastRowBytes = 40;
  const std::uint64_t partitions = std::uint64_t{ 1 } << info.depths.partition;
  std::uint64_t pieces =
    info.HasLevels() ? partitions : partitions / 2 + 1; // an octree has at least this number
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    pieces += std::uint64_t{ 1 } << PieceDepth(Resolution::Level(depth), info.depths);
  }
  if (fileBytes / leastRowBytes < pieces)
  {
    return DamagedBlob("metadata", "a file of " + std::to_string(fileBytes) +
                                     " bytes is too small for partitions of depth " +
                                     std::to_string(info.depths.partition));
  }
  if (fileBytes / leastRowBytes < UnusedPartCount(info))
  {
    return DamagedBlob("metadata", "a file of " + std::to_string(fileBytes) +
                                     " bytes is too small for " +
                                     std::to_string(info.unused->vertices) + " unused vertices");
  }
  return {};
}

std::string NameOfPiece(PieceId id, const TreeDepths& depths)
{
  return BlobName(BlobOfPiece(id, depths));
}

bool HaveInfos(const std::vector<Attribute>& arrays, const std::vector<AttributeInfo>& expected)
{
  return std::equal(expected.begin(), expected.end(), arrays.begin(), arrays.end(),
    [](const AttributeInfo& info, const Attribute& attribute) { return attribute.Info() == info; });
}

}

Store::Store() = default;
Store::~Store() = default;

Result<std::shared_ptr<Store>> Store::Open(const std::filesystem::path& file)
{
  Result<std::unique_ptr<const StoreFile>> opened = StoreFile::Open(file);
  KDSTREAM_TRY(opened);
  const Result<FileState> state = (*opened)->State();
  KDSTREAM_TRY(state);
  Result<ModelDescription> info = ReadStoredModel((*opened)->Descriptor());
  const Result<FileState> after = (*opened)->State();
  KDSTREAM_TRY(after);
  if (!(*after == *state))
  {
    return Error{ ErrorCode::InputOutput, "is being written" };
  }
  KDSTREAM_TRY(info);
  KDSTREAM_TRY(CheckCounts(*info, static_cast<std::uint64_t>(state->size)));
  std::shared_ptr<Store> store(new Store);
  store->Information = std::move(*info);
  store->Database = std::make_unique<Connection>(std::move(*opened), *state, store->Information);
  return store;
}

Status Store::CheckUnchanged() const
{
  return this->Database->CheckUnchanged();
}

std::optional<bool> Store::LooksUnchanged() const
{
  return this->Database->LooksUnchanged();
}

FileState Store::State() const
{
  return this->Database->State();
}

bool Store::IsFile(const std::filesystem::path& file) const
{
  return this->Database->CheckUnchanged() && FileState::Of(file) == this->Database->State();
}

std::string Store::NameOfRow(std::int64_t row) const
{
  const std::optional<PieceId> id = PieceOfRow(row);
  return id && this->Information.HasPiece(*id) ? NameOfPiece(*id, this->Information.depths)
                                               : "pieces/" + std::to_string(row);
}

std::string Store::UnusedName(std::uint32_t part)
{
  return "unused/" + std::to_string(part);
}

// Where a blob is. Errors: NotFound if the model has no such blob.
Result<BlobRow> Store::RowOf(const BlobId& blob) const
{
  const ModelDescription& info = this->Information;
  if (!protocol::IsValid(blob))
  {
    return Error{ ErrorCode::NotFound, "there is no blob of this kind" };
  }
  const bool isOfPartition = protocol::IsOfOriginal(blob) && blob.number < info.partitions;
  BlobRow row{ BlobTable::Pieces, blob.number, BlobName(blob) };
  bool has = false;
  switch (blob.kind)
  {
    case protocol::BlobKind::Tree:
      row.table = BlobTable::Tree;
      has = IsTreePage(blob.number, info.depths);
      break;
    case protocol::BlobKind::Boxes:
      row.table = BlobTable::Boxes;
      has = HasPartitionBoxes(blob.number, info.depths);
      break;
    case protocol::BlobKind::Level:
      has = info.HasPiece(PieceOfBlob(blob, info.depths));
      break;
    case protocol::BlobKind::Partition:
      has = isOfPartition;
      break;
    case protocol::BlobKind::Texture:
      row.table = BlobTable::Textures;
      has = isOfPartition && info.textures;
      break;
    case protocol::BlobKind::LevelTexture:
      row.table = BlobTable::LevelTextures;
      row.key = PieceRow(PieceOfBlob(blob, info.depths));
      has = info.textures && info.textures->levels && info.HasPiece(PieceOfBlob(blob, info.depths));
      break;
  }
  if (!has)
  {
    return Error{ ErrorCode::NotFound, "the model has no " + row.name };
  }
  if (row.table == BlobTable::Pieces)
  {
    row.key = PieceRow(PieceOfBlob(blob, info.depths));
  }
  return row;
}

Result<std::vector<std::uint8_t>> Store::Read(const BlobId& blob, const Execution&) const
{
  const Result<BlobRow> row = this->RowOf(blob);
  KDSTREAM_TRY(row);
  return this->Database->Read(*row);
}

Result<std::uint64_t> Store::Size(const BlobId& blob) const
{
  const Result<BlobRow> row = this->RowOf(blob);
  KDSTREAM_TRY(row);
  return this->Database->Size(*row);
}

Result<std::vector<std::uint8_t>> Store::ReadUnusedBlob(std::uint32_t part) const
{
  if (part >= UnusedPartCount(this->Information))
  {
    return Error{ ErrorCode::NotFound, "the model does not have this part of unused vertices" };
  }
  return this->Database->Read({ BlobTable::Unused, part, UnusedName(part) });
}

Result<Piece> Store::ReadUnused(std::uint32_t part) const
{
  const auto blob = this->ReadUnusedBlob(part);
  KDSTREAM_TRY(blob);
  return this->DecodeUnused(*blob, part);
}

Result<Piece> Store::DecodeUnused(std::span<const std::uint8_t> blob, std::uint32_t part) const
{
  const ModelDescription& model = this->Information;
  Result<Piece> piece = DecodePiece(blob, UnusedPartId(), UnusedCodec(model.grid.scalarType));
  if (!piece)
  {
    return Error{ piece.GetError().code, UnusedName(part) + ": " + piece.GetError().message };
  }
  if (piece->ownVertices != SizeOfUnusedPart(model, part) || piece->GhostCount() > 0 ||
      !piece->triangles.empty())
  {
    return DamagedBlob(UnusedName(part), "its number of vertices differs from the metadata");
  }
  std::vector<AttributeInfo> expected = model.attributes;
  std::erase_if(expected,
    [](const AttributeInfo& info) { return info.association != AttributeAssociation::Point; });
  return HaveInfos(piece->attributes, expected)
           ? std::move(piece)
           : DamagedBlob(UnusedName(part), "its attributes differ from the metadata");
}

Result<Piece> Store::ReadPiece(PieceId id) const
{
  const auto blob = this->Read(BlobOfPiece(id, this->Information.depths));
  KDSTREAM_TRY(blob);
  return this->Decode(*blob, id);
}

Result<Piece> Store::Decode(std::span<const std::uint8_t> blob, PieceId id) const
{
  Result<Piece> piece = DecodePiece(blob, id, this->Information.Codec());
  if (piece && !this->AttributesFit(*piece))
  {
    return Error{ ErrorCode::Damaged,
      NameOfPiece(id, this->Information.depths) + ": its attributes differ from the metadata" };
  }
  return piece;
}

// Whether a piece has the right attributes. The original has all of them; levels have those that
// viewers use. Of the arrays of numbers, levels have those whose range is in the metadata: earlier
// builds stored numbers only for the original.
bool Store::AttributesFit(const Piece& piece) const
{
  const ModelDescription& model = this->Information;
  std::vector<AttributeInfo> expected = model.attributes;
  if (!piece.id.resolution.IsOriginal())
  {
    expected = ArraysOfLevels(model.attributes);
    std::erase_if(expected, [&model](const AttributeInfo& info)
      { return IsScalar(info) && !model.scalars.Find(info.name); });
  }
  return HaveInfos(piece.attributes, expected);
}

Result<std::vector<Piece>> Store::ReadPieces(
  std::span<const PieceId> ids, const Execution& execution) const
{
  std::vector<Piece> pieces;
  for (const PieceId id : ids)
  {
    KDSTREAM_TRY(execution.Report(
      "pieces", static_cast<double>(pieces.size()) / static_cast<double>(ids.size())));
    Result<Piece> piece = this->ReadPiece(id);
    KDSTREAM_TRY(piece);
    pieces.push_back(std::move(*piece));
  }
  return pieces;
}

Result<std::vector<Box>> Store::ReadBoxes(const Execution& execution) const
{
  const TreeDepths& depths = this->Information.depths;
  const NodeId first = NodeId{ 1 } << DepthOfPartitionBoxes(depths);
  for (NodeId node = first; node < 2 * first; ++node) // reserve no memory for a count that is only
                                                      // claimed
  {
    KDSTREAM_TRY(this->Size(BlobId::PartitionBoxes(node)));
  }
  std::vector<Box> boxes(std::size_t{ 2 } << depths.partition);
  auto partition = boxes.begin() + (std::ptrdiff_t{ 1 } << depths.partition);
  for (NodeId node = first; node < 2 * first; ++node)
  {
    KDSTREAM_TRY(execution.Report("boxes", static_cast<double>(node) / first - 1));
    const auto blob = this->Read(BlobId::PartitionBoxes(node));
    KDSTREAM_TRY(blob);
    const auto decoded = DecodePartitionBoxes(*blob, node, depths);
    KDSTREAM_TRY(decoded);
    partition = std::copy(decoded->begin(), decoded->end(), partition);
  }
  UniteBoxes(boxes);
  return boxes;
}

std::vector<PieceId> Store::PieceIds() const
{
  std::vector<PieceId> ids;
  (void)this->VisitPieceIds(
    [&ids](PieceId id)
    {
      ids.push_back(id);
      return Status{};
    });
  return ids;
}

Status Store::VisitPieceIds(const std::function<Status(PieceId)>& visit) const
{
  const ModelDescription& info = this->Information;
  const auto visitAll = [&](Resolution resolution, std::uint64_t count) -> Status
  {
    const unsigned depth = PieceDepth(resolution, info.depths);
    for (NodeId i = 0; i < count; ++i)
    {
      KDSTREAM_TRY(visit({ resolution, (NodeId{ 1 } << depth) + i }));
    }
    return {};
  };
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    const Resolution level = Resolution::Level(depth);
    KDSTREAM_TRY(visitAll(level, std::uint64_t{ 1 } << PieceDepth(level, info.depths)));
  }
  return visitAll(Resolution::Original(), info.partitions);
}

}
