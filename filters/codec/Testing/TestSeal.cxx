// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/codec/Seal.h"

#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/PieceCodec.h"
#include "filters/codec/TreePage.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Bytes = std::vector<std::uint8_t>;

Bytes BytesOf(std::string_view text)
{
  return { text.begin(), text.end() };
}

// The error message of opening the bytes as a blob of `magic`; empty if there is no error.
std::string WhyNot(const Bytes& blob, std::string_view magic)
{
  const auto content = UnsealBlob(blob, magic);
  return content ? "" : content.GetError().message;
}

struct Blobs : testing::Test
{
  std::unique_ptr<Model> model = MakeModel(Torus(12, 8), { 30, {}, 8 });
  CodecContext context{ model->tree.depths,
    CoordinateGrid::Over({ { -2, -2, -2 }, { 2, 2, 2 } }, 20, ScalarType::Float32) };
  PieceId id{ Resolution::Original(), PartitionNode() };
  Bytes piece = EncodePiece(model->pieces.at(id), context);
  const TreeDepths& depths = model->tree.depths;
  Bytes page =
    EncodeTreePage(RoundTreePage(model->tree.boxes, 1, depths, PieceTable(depths, true)));
  Bytes boxes = EncodePartitionBoxes(model->tree.boxes, 1, depths);

  NodeId PartitionNode() const { return NodeId{ 1 } << this->model->tree.depths.partition; }
  Error DecodePieceError(const Bytes& blob) const
  {
    const Result<Piece> decoded = DecodePiece(blob, this->id, this->context);
    return decoded ? Error{ ErrorCode::Cancelled, "decoded" } : decoded.GetError();
  }
  Error DecodePageError(const Bytes& blob) const
  {
    const auto reported = DecodeTreePage(blob, 1, this->model->tree.boxes[1], this->depths, true);
    return reported ? Error{ ErrorCode::Cancelled, "decoded" } : reported.GetError();
  }
  Error DecodeBoxesError(const Bytes& blob) const
  {
    const auto reported = DecodePartitionBoxes(blob, 1, this->depths);
    return reported ? Error{ ErrorCode::Cancelled, "decoded" } : reported.GetError();
  }
};

// Gives each byte every other value. `decode` must refuse each change, and report its place.
template <class Decode>
void ExpectEveryChangeIsRefused(const Bytes& whole, const std::string& name, const Decode& decode)
{
  for (std::size_t at = 0; at < whole.size(); ++at)
  {
    for (unsigned change = 1; change < 256; ++change)
    {
      Bytes altered = whole;
      altered[at] = static_cast<std::uint8_t>(altered[at] ^ change);
      const Error error = decode(altered);
      if (at < magicSize)
      {
        ASSERT_TRUE(IsAt(error, ErrorCode::InvalidInput, name + ": ")) << at;
      }
      else if (at == magicSize)
      {
        ASSERT_TRUE(IsAt(error, ErrorCode::Unsupported, name + ": ")) << at;
        ASSERT_TRUE(IsAt(error, ErrorCode::Unsupported, "version " + std::to_string(altered[at])));
      }
      else
      {
        ASSERT_TRUE(IsAt(error, ErrorCode::Damaged, name + ": ")) << at;
      }
    }
  }
}

template <class Decode>
void ExpectEveryTruncationIsRefused(
  const Bytes& whole, const std::string& name, const Decode& decode)
{
  for (std::size_t size = 0; size < whole.size(); ++size)
  {
    const Error error = decode(Bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size)));
    ASSERT_TRUE(IsAt(error, ErrorCode::Damaged, name + ": ")) << size;
    const bool isTooShort = size < blobHeadSize + checksumSize;
    ASSERT_TRUE(IsAt(
      error, ErrorCode::Damaged, isTooShort ? " " + std::to_string(size) + " bytes" : "checksum"));
  }
}

}

TEST(Seal, IsXxh64OfAllBytesBefore)
{
  // From the algorithm's own test vectors.
  Bytes empty, abc = BytesOf("abc");
  SealBlob(empty);
  EXPECT_EQ(empty, (Bytes{ 0x99, 0xE9, 0xD8, 0x51, 0x37, 0xDB, 0x46, 0xEF }));
  SealBlob(abc);
  EXPECT_EQ(abc, (Bytes{ 'a', 'b', 'c', 0x99, 0x09, 0x77, 0xAD, 0xF5, 0x2C, 0xBC, 0x44 }));
}

TEST(Seal, GivesTheBlobWithoutItsChecksum)
{
  ByteWriter writer;
  WriteBlobHead(writer, "KDP");
  writer.Byte(9);
  const Bytes content = writer.Take();
  Bytes blob = content;
  SealBlob(blob);
  const auto unsealed = UnsealBlob(blob, "KDP");
  ASSERT_TRUE(unsealed) << unsealed.GetError().message;
  EXPECT_EQ(Bytes(unsealed->begin(), unsealed->end()), content);
  EXPECT_EQ(WhyNot(blob, "KDT"), "does not begin with \"KDT\"");
}

TEST(Seal, NothingCanBeSealedToo)
{
  Bytes blob;
  SealBlob(blob);
  EXPECT_TRUE(IsSealed(blob));
  blob.pop_back();
  EXPECT_FALSE(IsSealed(blob));
  EXPECT_FALSE(IsSealed({}));
}

TEST(Seal, NamesAnotherVersionHoweverItIsSealed)
{
  EXPECT_EQ(WhyNot({ 'K', 'D', 'P', 9 }, "KDP"), "unknown codec version 9: this viewer knows 8");
  EXPECT_EQ(
    WhyNot({ 'K', 'D', 'P', 1, 1, 0, 0, 0, 1, 1, 1, 0, 0 }, "KDP"), // version 1 had no checksum
    "unknown codec version 1: this viewer knows 8");
}

TEST_F(Blobs, EveryChangedByteIsRefused)
{
  ASSERT_EQ(this->DecodePieceError(this->piece).message, "decoded");
  ASSERT_EQ(this->DecodePageError(this->page).message, "decoded");
  ASSERT_EQ(this->DecodeBoxesError(this->boxes).message, "decoded");
  const std::string name = "piece " + std::to_string(this->PartitionNode()) + " of the original";
  ExpectEveryChangeIsRefused(
    this->piece, name, [this](const Bytes& blob) { return this->DecodePieceError(blob); });
  ExpectEveryChangeIsRefused(
    this->page, "tree page 1", [this](const Bytes& blob) { return this->DecodePageError(blob); });
  ExpectEveryChangeIsRefused(
    this->boxes, "boxes 1", [this](const Bytes& blob) { return this->DecodeBoxesError(blob); });
}

TEST_F(Blobs, EveryTruncationIsRefused)
{
  const std::string name = "piece " + std::to_string(this->PartitionNode()) + " of the original";
  ExpectEveryTruncationIsRefused(
    this->piece, name, [this](const Bytes& blob) { return this->DecodePieceError(blob); });
  ExpectEveryTruncationIsRefused(
    this->page, "tree page 1", [this](const Bytes& blob) { return this->DecodePageError(blob); });
  ExpectEveryTruncationIsRefused(
    this->boxes, "boxes 1", [this](const Bytes& blob) { return this->DecodeBoxesError(blob); });
}

TEST_F(Blobs, ABlobWithSomethingAfterItIsRefused)
{
  Bytes longer = this->piece;
  longer.push_back(0);
  EXPECT_EQ(this->DecodePieceError(longer).code, ErrorCode::Damaged);
}
