// SPDX-License-Identifier: BSD-3-Clause
// Checks whether a store is whole: Store::Verify.
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/TextureTile.h"
#include "filters/codec/TreePage.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/store/Store.h"
#include "filters/store/StoreConnection.h"
#include "filters/store/StoreSchema.h"
#include "filters/store/UnusedList.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace kdstream
{

using protocol::BlobId;

// Reads everything in a store, in the order of its digest, and notes the errors.
class Store::Verification
{
public:
  Verification(const Store& store, const Execution& execution)
    : Whole(store)
    , ReadBefore(store.Database->BytesRead())
    , Progress(execution)
    , Digest(store.Information)
  {
  }

  std::vector<Error> Run()
  {
    const Status labels = this->Whole.Database->VisitMislabelled(
      [this](std::int64_t row, const Error& error)
      {
        this->Note(this->Whole.NameOfRow(row), error);
        return bool(this->EndWhereMuchIsWrong());
      });
    this->Note("pieces", labels);
    Status ended = this->EndWhereMuchIsWrong();
    ended = ended ? this->CheckPieces() : ended;
    ended = ended ? this->CheckLevelTextures() : ended;
    ended = ended ? this->CheckTree() : ended;
    ended = ended ? this->CheckUnused() : ended;
    if (!ended)
    {
      this->Found.push_back(ended.GetError()); // cancelled, or too many errors
      return std::move(this->Found);
    }
    if (this->Found.empty() && this->Digest.Hexadecimal() != this->Whole.Information.digest)
    {
      this->Found.push_back(DamagedBlob("metadata", "the digest does not match the content"));
    }
    return std::move(this->Found);
  }

private:
  static constexpr std::size_t mostFound = 1000;

  void Note(const std::string& name, const Status& status)
  {
    if (!status)
    {
      const Error& error = status.GetError();
      const bool named = error.message.rfind(name, 0) == 0;
      this->Found.push_back({ error.code, named ? error.message : name + ": " + error.message });
    }
  }

  // Allocates no memory in proportion to the number of pieces that the store claims.
  Status CheckPieces()
  {
    const double all = this->CountPieces();
    double done = 0;
    return this->Whole.VisitPieceIds(
      [&](PieceId id) -> Status
      {
        const BlobId piece = BlobOfPiece(id, this->Whole.Information.depths);
        const std::string name = BlobName(piece);
        const auto blob = this->Whole.Read(piece);
        this->Note(name, OnlyStatus(blob));
        if (blob)
        {
          this->Digest.AddPiece(id, *blob);
          const auto decoded = this->Whole.Decode(*blob, id);
          this->Note(name, OnlyStatus(decoded));
          this->CheckTexture(id, decoded ? &*decoded : nullptr);
        }
        KDSTREAM_TRY(this->EndWhereMuchIsWrong());
        return this->Progress.Report("verify", ++done / all);
      });
  }

  // Fine to coarse, in the order in which textures were made.
  Status CheckLevelTextures()
  {
    const ModelDescription& info = this->Whole.Information;
    for (auto depth = static_cast<unsigned>(info.levels.size());
         info.textures && info.textures->levels && depth-- > 0;)
    {
      const Resolution level = Resolution::Level(depth);
      const NodeId first = NodeId{ 1 } << PieceDepth(level, info.depths);
      for (NodeId node = first; node < 2 * first; ++node)
      {
        const PieceId id{ level, node };
        const BlobId texture = TextureOfPiece(id, info.depths);
        const auto blob = this->Whole.Read(texture);
        this->Note(BlobName(texture), OnlyStatus(blob));
        if (blob)
        {
          this->Digest.AddLevelTexture(id, *blob);
        }
        const auto bytes = this->Whole.Read(BlobOfPiece(id, info.depths));
        this->ReadAgain += bytes ? bytes->size() : 0;
        const auto piece = bytes ? this->Whole.Decode(*bytes, id) : Result<Piece>(bytes.GetError());
        if (blob && piece) // errors of the piece have been noted already
        {
          this->Note(BlobName(texture),
            OnlyStatus(DecodeTextureTile(*blob, piece->triangles, piece->positions)));
        }
        KDSTREAM_TRY(this->EndWhereMuchIsWrong());
      }
    }
    return {};
  }

  // Checks the texture of a partition. piece: null if it is damaged.
  void CheckTexture(PieceId id, const Piece* piece)
  {
    const ModelDescription& info = this->Whole.Information;
    if (!info.textures || !id.resolution.IsOriginal())
    {
      return;
    }
    const std::uint32_t partition = id.node - (NodeId{ 1 } << info.depths.partition);
    const BlobId texture = BlobId::Texture(partition);
    const auto blob = this->Whole.Read(texture);
    this->Note(BlobName(texture), OnlyStatus(blob));
    if (blob)
    {
      this->Digest.AddTexture(partition, *blob);
    }
    if (blob && piece)
    {
      this->Note(BlobName(texture),
        OnlyStatus(DecodeTextureTile(*blob, piece->triangles, piece->positions)));
    }
  }

  double CountPieces() const
  {
    const ModelDescription& info = this->Whole.Information;
    auto count = static_cast<double>(info.partitions);
    for (unsigned depth = 0; depth < info.levels.size(); ++depth)
    {
      count += std::ldexp(1.0, static_cast<int>(PieceDepth(Resolution::Level(depth), info.depths)));
    }
    return count;
  }

  // Ends the check if there are too many errors, or if blobs overlap. Each blob is read once,
  // except those that are counted in ReadAgain. So if more bytes were read than the file has, blobs
  // overlap.
  Status EndWhereMuchIsWrong() const
  {
    Connection& database = *this->Whole.Database;
    if (database.BytesRead() - this->ReadBefore >
        static_cast<std::uint64_t>(database.State().size) + this->ReadAgain)
    {
      return Error{ ErrorCode::Damaged,
        "its blobs overlap: together they are larger than the file" };
    }
    return this->Found.size() < mostFound ? Status{}
                                          : Status{ Error{ ErrorCode::Damaged,
                                              "there are more errors; the rest is not checked" } };
  }

  Status CheckTree()
  {
    const auto boxes = this->CheckBoxes();
    KDSTREAM_TRY(boxes);
    for (const NodeId page : TreePages(this->Whole.Information.depths))
    {
      const auto blob = this->Whole.Read(BlobId::TreePage(page));
      const bool isDecoded = blob && !boxes->empty(); // pages are relative to the boxes
      this->Note(BlobName(BlobId::TreePage(page)),
        isDecoded ? this->CheckPage(*blob, page, *boxes) : OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddTreePage(page, *blob);
      }
      KDSTREAM_TRY(this->EndWhereMuchIsWrong());
    }
    return {};
  }

  Status CheckPage(
    std::span<const std::uint8_t> blob, NodeId page, std::span<const Box> boxes) const
  {
    const TreeDepths& depths = this->Whole.Information.depths;
    const auto reported = DecodeTreePage(
      blob, page, RoundedBoxOf(boxes, page), depths, this->Whole.Information.HasLevels());
    KDSTREAM_TRY(reported);
    return reported->boxes == RoundTreePageBoxes(boxes, page, depths)
             ? Status{}
             : DamagedBlob(
                 BlobName(BlobId::TreePage(page)), "its boxes differ from those of the partitions");
  }

  // Store::Open has checked that the file is large enough for this number of parts.
  Status CheckUnused()
  {
    const std::uint64_t parts = UnusedPartCount(this->Whole.Information);
    for (std::uint32_t part = 0; part < parts; ++part)
    {
      const std::string name = UnusedName(part);
      const auto blob = this->Whole.ReadUnusedBlob(part);
      this->Note(name, blob ? OnlyStatus(this->Whole.DecodeUnused(*blob, part)) : OnlyStatus(blob));
      if (blob)
      {
        this->Digest.AddUnused(part, *blob);
      }
      KDSTREAM_TRY(this->EndWhereMuchIsWrong());
    }
    return {};
  }

  // The boxes of the tree; empty if any is damaged.
  Result<std::vector<Box>> CheckBoxes()
  {
    const TreeDepths& depths = this->Whole.Information.depths;
    const std::size_t before = this->Found.size();
    const NodeId first = NodeId{ 1 } << DepthOfPartitionBoxes(depths);
    // Whether all blobs exist: no memory is allocated for blobs that are only claimed.
    bool isThere = true;
    for (NodeId node = first; isThere && node < 2 * first; ++node)
    {
      isThere = this->Whole.Size(BlobId::PartitionBoxes(node)).HasValue();
    }
    std::vector<Box> boxes(isThere ? std::size_t{ 2 } << depths.partition : 0);
    auto partition = boxes.begin() + static_cast<std::ptrdiff_t>(boxes.size() / 2);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      const auto blob = this->Whole.Read(BlobId::PartitionBoxes(node));
      const auto reported = blob ? DecodePartitionBoxes(*blob, node, depths) : blob.GetError();
      this->Note(BlobName(BlobId::PartitionBoxes(node)), OnlyStatus(reported));
      if (blob)
      {
        this->Digest.AddBoxes(node, *blob);
      }
      if (reported && isThere)
      {
        partition = std::copy(reported->begin(), reported->end(), partition);
      }
      KDSTREAM_TRY(this->EndWhereMuchIsWrong());
    }
    if (this->Found.size() != before)
    {
      return std::vector<Box>();
    }
    UniteBoxes(boxes);
    return boxes;
  }

  template <class Value>
  static Status OnlyStatus(const Result<Value>& result)
  {
    return result ? Status{} : Status{ result.GetError() };
  }

  const Store& Whole;
  const std::uint64_t ReadBefore;
  std::uint64_t ReadAgain = 0; // bytes of pieces of levels that were read again to check their
                               // textures
  const Execution& Progress;
  ContentDigest Digest;
  std::vector<Error> Found;
};

std::vector<Error> Store::Verify(const Execution& execution) const
{
  return Verification(*this, execution).Run();
}

}
