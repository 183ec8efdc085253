// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedPieces.h"

#include <cstring>

namespace kdstream
{
namespace
{

constexpr std::uint64_t batchBytes = std::uint64_t{ 1 } << 22;

// The facts about a piece that the writer needs besides its blob. After it come: geometric errors;
// for each array whose range is gathered, the values of the own vertices; the blob; its texture.
struct PieceHead
{
  std::uint64_t blobBytes = 0, scalarBytes = 0, textureBytes = 0, texels = 0;
  std::uint32_t node = 0, ownVertices = 0, triangles = 0, geometricErrors = 0;
  std::uint64_t hasTexture = 0;
};

}

Status DistributedPieces::Add(const EncodedPiece& encoded)
{
  if (this->Writer != nullptr)
  {
    return AddToStore(*this->Writer, encoded);
  }
  const Piece& piece = encoded.piece;
  const EncodedTexture texture = encoded.texture.value_or(EncodedTexture{});
  if (!this->Kept.IsOpen())
  {
    Result<SpillFile> file = this->Folder.CreateFile("encoded pieces", 0);
    KDSTREAM_TRY(file);
    this->Kept = std::move(*file);
  }
  std::vector<std::uint8_t> scalars;
  for (std::size_t k = 0; piece.id.resolution.IsOriginal() && k < this->Scalars.size(); ++k)
  {
    const AttributeInfo& array = this->Scalars[k];
    const std::vector<std::uint8_t>& values = FindAttribute(piece.attributes, array)->values;
    scalars.insert(scalars.end(), values.begin(),
      values.begin() + static_cast<std::ptrdiff_t>(piece.ownVertices * array.TupleSize()));
  }
  const PieceHead head{ encoded.blob.size(), scalars.size(), texture.bytes.size(), texture.texels,
    piece.id.node, piece.ownVertices, static_cast<std::uint32_t>(piece.triangles.size()),
    static_cast<std::uint32_t>(piece.geometricErrors.size()), encoded.texture ? 1U : 0U };
  const std::span<const std::byte> parts[] = { std::as_bytes(std::span(&head, 1)),
    std::as_bytes(std::span(piece.geometricErrors)), std::as_bytes(std::span(scalars)),
    std::as_bytes(std::span(encoded.blob)), std::as_bytes(std::span(texture.bytes)) };
  std::vector<std::byte> bytes;
  for (const std::span<const std::byte> part : parts)
  {
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  const std::uint64_t end = this->Kept.Size() + bytes.size();
  KDSTREAM_TRY(this->Kept.Write(this->Kept.Size(), bytes));
  const std::size_t batches = this->BatchBegin.size();
  if (batches > 1 && end - this->BatchBegin[batches - 2] <= batchBytes)
  {
    this->BatchBegin.back() = end;
  }
  else
  {
    this->BatchBegin.push_back(end);
  }
  return {};
}

Status DistributedPieces::Finish(
  Resolution resolution, std::uint64_t triangles, const Execution& execution)
{
  const Result<std::vector<std::uint64_t>> batches =
    this->Group.Gather(this->BatchBegin.size() - 1);
  KDSTREAM_TRY(batches);
  for (std::size_t rank = 1; rank < this->Group.Count(); ++rank)
  {
    for (std::size_t batch = 0; batch < (*batches)[rank]; ++batch)
    {
      RankLists<std::byte> out(this->Group.Count());
      if (rank == this->Group.Rank())
      {
        const std::uint64_t begin = this->BatchBegin[batch];
        out[0].resize(static_cast<std::size_t>(this->BatchBegin[batch + 1] - begin));
        KDSTREAM_TRY(this->Kept.Read(begin, out[0]));
      }
      const Result<RankLists<std::byte>> in = this->Group.Exchange(out);
      KDSTREAM_TRY(in);
      KDSTREAM_TRY(this->Write((*in)[rank], resolution));
    }
  }
  this->Kept = {};
  this->BatchBegin.assign(1, 0);
  KDSTREAM_TRY(this->Group.Sum(std::span(&triangles, 1)));
  return this->Writer == nullptr ? Status{}
                                 : this->Writer->FinishResolution(resolution, triangles, execution);
}

// Writes pieces received from another rank; only rank 0 receives any.
Status DistributedPieces::Write(std::span<const std::byte> bytes, Resolution resolution)
{
  while (!bytes.empty())
  {
    PieceHead head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    bytes = bytes.subspan(sizeof(head));
    EncodedPiece encoded;
    Piece& piece = encoded.piece; // only the members that the writer reads
    piece.id = { resolution, head.node };
    piece.ownVertices = head.ownVertices;
    piece.triangles.resize(head.triangles);
    piece.geometricErrors.resize(head.geometricErrors);
    if (head.geometricErrors > 0)
    {
      std::memcpy(piece.geometricErrors.data(), bytes.data(), head.geometricErrors * sizeof(float));
    }
    bytes = bytes.subspan(head.geometricErrors * sizeof(float));
    const auto* scalar = reinterpret_cast<const std::uint8_t*>(bytes.data());
    for (std::size_t k = 0; resolution.IsOriginal() && k < this->Scalars.size(); ++k)
    {
      const AttributeInfo& array = this->Scalars[k];
      const std::size_t size = head.ownVertices * array.TupleSize();
      piece.attributes.push_back({ array, { scalar, scalar + size } });
      scalar += size;
    }
    bytes = bytes.subspan(head.scalarBytes);
    const auto* blob = reinterpret_cast<const std::uint8_t*>(bytes.data());
    encoded.blob.assign(blob, blob + head.blobBytes);
    blob += head.blobBytes;
    if (head.hasTexture != 0)
    {
      encoded.texture = EncodedTexture{ { blob, blob + head.textureBytes }, head.texels };
    }
    KDSTREAM_TRY(AddToStore(*this->Writer, encoded));
    bytes = bytes.subspan(head.blobBytes + head.textureBytes);
  }
  return {};
}

}
