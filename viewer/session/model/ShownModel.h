// SPDX-License-Identifier: BSD-3-Clause
// The open model: its description, the parts of it that have arrived, and those that are shown. The
// parts of a session share it.
#pragma once

#include "filters/codec/PieceCodec.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/Picker.h"
#include "viewer/session/model/FailedBlobs.h"
#include "viewer/session/model/KnownTree.h"
#include "viewer/session/model/PieceCache.h"
#include "viewer/session/model/ShownSurface.h"
#include "viewer/session/section/ShownSection.h"
#include "viewer/session/texture/ShownTiles.h"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

namespace kdstream
{

struct ShownModel
{
  struct Opened
  {
    ModelDescription description;
    CodecContext codec;
    KnownTree tree;
    bool isClosed = false; // nearly closed: its back is hidden
  };
  std::string id;             // of the selected model
  std::optional<Opened> open; // when its description has arrived
  PieceCache pieces;
  ShownTiles tiles;
  ShownSurface surface;
  ShownSection section;
  FailedBlobs failed;

  // Limits of decoded pieces and of pictures.
  ShownModel(std::size_t cacheBytes, std::size_t pictureBytes)
    : pieces(cacheBytes)
    , tiles(pictureBytes)
  {
  }

  void Select(const std::string& model); // forgets the last model
  // treeBytes: limit for loaded pages of the tree. False if the model cannot be shown; this is then
  // reported.
  bool Open(const ModelDescription& model, std::size_t treeBytes);

  // The depths of the open model.
  const TreeDepths& Depths() const { return this->open->codec.depths; }
  PieceId Preview() const;
  protocol::BlobId PreviewBlob() const { return BlobOfPiece(this->Preview(), this->Depths()); }
  // The original counts as the finest level.
  unsigned LevelOf(Resolution resolution) const
  {
    return resolution.IsOriginal() ? this->Depths().finest : resolution.Depth();
  }
  // Triangles of a partition, on average; of a cloud, points. At least 1.
  std::uint64_t TrianglesOfPartition() const;
  PieceId Partition(std::uint32_t number) const
  {
    return { Resolution::Original(), NodeOfPartition(number, this->Depths()) };
  }

  // Takes a piece that has been decoded.
  void Add(Piece piece);
  // The bytes of all held pieces, and of textures as they arrived.
  std::size_t Bytes() const { return this->pieces.Bytes() + this->tiles.Bytes(); }
  // Allows failed blobs to be requested again.
  void Retry();

  const DrawnSurface& Drawn() const { return *this->surface.GetSurface(); }
  // The plane of the section; null without a section.
  const SectionPlane* Plane() const
  {
    return this->section.Plane() ? &*this->section.Plane() : nullptr;
  }
  // The point where a ray meets the part of the shown surface that is not cut away: see
  // PickSurface.
  std::optional<SurfaceHit> Pick(const Ray& ray, double slack = 0) const
  {
    return this->section.Pick(this->Drawn(), ray, slack);
  }
  // Updates the outline and the cap of the section for the surface that is shown now.
  void FollowSection();
};

}
