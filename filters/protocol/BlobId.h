// SPDX-License-Identifier: BSD-3-Clause
// Names a blob of a model: a page of the tree, boxes of partitions, a piece of a level, a partition
// of the original, or the texture of a piece or a partition.
//
// Blobs are the only data of the protocol: everything else names or describes them. The names below
// are the same in URLs ("/api/models/dragon/DIGEST/levels/7/1"), error messages and logs.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <compare>
#include <cstdint>
#include <string>
#include <string_view>

namespace kdstream::protocol
{

// The largest blob that a server sends and a client accepts, in bytes.
inline constexpr std::uint32_t maximumBlobBytes = 64u << 20;

enum class BlobKind : std::uint8_t
{
  Tree = 0,
  Level = 1,
  Partition = 2,
  Boxes = 3,
  Texture = 4,
  LevelTexture = 5
};

struct BlobId
{
  BlobKind kind = BlobKind::Tree;
  std::uint8_t level = 0; // for Level and LevelTexture; 0 for other kinds
  // For a tree page, boxes, a level's piece and its texture: the node, from 1. For a partition and
  // its texture: the partition's number, from 0.
  std::uint32_t number = 1;
  auto operator<=>(const BlobId&) const = default;

  static constexpr BlobId TreePage(std::uint32_t node) { return { BlobKind::Tree, 0, node }; }
  static constexpr BlobId PartitionBoxes(std::uint32_t node)
  {
    return { BlobKind::Boxes, 0, node };
  }
  static constexpr BlobId LevelPiece(std::uint8_t depth, std::uint32_t node)
  {
    return { BlobKind::Level, depth, node };
  }
  static constexpr BlobId Partition(std::uint32_t number)
  {
    return { BlobKind::Partition, 0, number };
  }
  static constexpr BlobId Texture(std::uint32_t partition)
  {
    return { BlobKind::Texture, 0, partition };
  }
  static constexpr BlobId LevelTexture(std::uint8_t depth, std::uint32_t node)
  {
    return { BlobKind::LevelTexture, depth, node };
  }
};

// Whether the numbers are in the ranges that any model could have (the server checks whether its
// model has the blob).
bool IsValid(const BlobId& blob);

// Whether the blob is a part of the original: a partition or its texture.
constexpr bool IsOfOriginal(const BlobId& blob)
{
  return blob.kind == BlobKind::Partition || blob.kind == BlobKind::Texture;
}

// Whether the blob is a texture, of a partition or of a piece of a level.
constexpr bool IsOfTexture(const BlobId& blob)
{
  return blob.kind == BlobKind::Texture || blob.kind == BlobKind::LevelTexture;
}

// The blob's name: "tree/1", "boxes/1", "levels/7/1", "partitions/12", "textures/12" or
// "level-textures/7/1". REQUIRES: IsValid(blob).
std::string BlobName(const BlobId& blob);

// The inverse of BlobName. Strict: decimal numbers in range, without sign, leading zeros or
// surrounding characters. Errors: NotFound if the name has none of these forms; InvalidArgument,
// naming the wrong number.
Result<BlobId> ParseBlobName(std::string_view name);

}

namespace kdstream
{

// Converts a piece's id to the protocol's ("levels/12/3", "partitions/7"), and back. PieceOfBlob of
// a texture gives the textured piece. REQUIRES (PieceOfBlob): IsOfPiece(blob) or a texture; the
// partition exists in the tree.
protocol::BlobId BlobOfPiece(PieceId piece, const TreeDepths& depths);
protocol::BlobId TextureOfPiece(
  PieceId piece, const TreeDepths& depths);   // even if the piece has no texture
bool IsOfPiece(const protocol::BlobId& blob); // no tree page, no boxes, no texture
bool IsOfTree(const protocol::BlobId& blob);  // a page, or boxes
PieceId PieceOfBlob(const protocol::BlobId& blob, const TreeDepths& depths);

}
