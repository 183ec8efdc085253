// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/BlobId.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"
#include "filters/protocol/TextParts.h"

namespace kdstream::protocol
{

namespace
{
constexpr std::uint32_t nodeEnd = std::uint32_t{ 1 } << (maximumDepth + 1);
constexpr std::uint32_t partitionEnd = std::uint32_t{ 1 } << maximumDepth;
}

bool IsValid(const BlobId& blob)
{
  switch (blob.kind)
  {
    case BlobKind::Tree:
    case BlobKind::Boxes:
      return blob.level == 0 && blob.number >= 1 && blob.number < nodeEnd;
    case BlobKind::Level:
    case BlobKind::LevelTexture:
      return blob.level <= maximumDepth && blob.number >= 1 && blob.number < nodeEnd;
    case BlobKind::Partition:
    case BlobKind::Texture:
      return blob.level == 0 && blob.number < partitionEnd;
  }
  return false;
}

std::string BlobName(const BlobId& blob)
{
  switch (blob.kind)
  {
    case BlobKind::Tree:
      return "tree/" + std::to_string(blob.number);
    case BlobKind::Boxes:
      return "boxes/" + std::to_string(blob.number);
    case BlobKind::Level:
      return "levels/" + std::to_string(blob.level) + "/" + std::to_string(blob.number);
    case BlobKind::Partition:
      return "partitions/" + std::to_string(blob.number);
    case BlobKind::Texture:
      return "textures/" + std::to_string(blob.number);
    case BlobKind::LevelTexture:
      return "level-textures/" + std::to_string(blob.level) + "/" + std::to_string(blob.number);
  }
  return {};
}

Result<BlobId> ParseBlobName(std::string_view name)
{
  const auto parts = SplitPath(name);
  const auto bad = [](std::string_view what, std::string_view text) {
    return Error{ ErrorCode::InvalidArgument, std::string(what) + " " + Quoted(text) };
  };

  if (parts.size() == 2 && (parts[0] == "tree" || parts[0] == "boxes"))
  {
    const BlobKind kind = parts[0] == "tree" ? BlobKind::Tree : BlobKind::Boxes;
    const auto node = ParseDecimal(parts[1], 1, nodeEnd - 1);
    return node ? Result<BlobId>(BlobId{ kind, 0, *node }) : bad("not a tree node", parts[1]);
  }
  if (parts.size() == 3 && (parts[0] == "levels" || parts[0] == "level-textures"))
  {
    const auto depth = ParseDecimal(parts[1], 0, maximumDepth);
    if (!depth)
    {
      return bad("no level", parts[1]);
    }
    const BlobKind kind = parts[0] == "levels" ? BlobKind::Level : BlobKind::LevelTexture;
    const auto node = ParseDecimal(parts[2], 1, nodeEnd - 1);
    return node ? Result<BlobId>(BlobId{ kind, static_cast<std::uint8_t>(*depth), *node })
                : bad("not a tree node", parts[2]);
  }
  if (parts.size() == 2 && (parts[0] == "partitions" || parts[0] == "textures"))
  {
    const BlobKind kind = parts[0] == "textures" ? BlobKind::Texture : BlobKind::Partition;
    const auto partition = ParseDecimal(parts[1], 0, partitionEnd - 1);
    return partition ? Result<BlobId>(BlobId{ kind, 0, *partition })
                     : bad("no partition", parts[1]);
  }
  return Error{ ErrorCode::NotFound, "there is no blob named " + Quoted(name) };
}

}

namespace kdstream
{

protocol::BlobId BlobOfPiece(PieceId piece, const TreeDepths& depths)
{
  if (piece.resolution.IsOriginal())
  {
    return protocol::BlobId::Partition(piece.node - (NodeId{ 1 } << depths.partition));
  }
  return protocol::BlobId::LevelPiece(
    static_cast<std::uint8_t>(piece.resolution.Depth()), piece.node);
}

protocol::BlobId TextureOfPiece(PieceId piece, const TreeDepths& depths)
{
  protocol::BlobId blob = BlobOfPiece(piece, depths);
  blob.kind =
    piece.resolution.IsOriginal() ? protocol::BlobKind::Texture : protocol::BlobKind::LevelTexture;
  return blob;
}

bool IsOfPiece(const protocol::BlobId& blob)
{
  return blob.kind == protocol::BlobKind::Level || blob.kind == protocol::BlobKind::Partition;
}

bool IsOfTree(const protocol::BlobId& blob)
{
  return blob.kind == protocol::BlobKind::Tree || blob.kind == protocol::BlobKind::Boxes;
}

PieceId PieceOfBlob(const protocol::BlobId& blob, const TreeDepths& depths)
{
  if (blob.kind != protocol::BlobKind::Level && blob.kind != protocol::BlobKind::LevelTexture)
  {
    return { Resolution::Original(), NodeOfPartition(blob.number, depths) };
  }
  return { Resolution::Level(blob.level), blob.number };
}

}
