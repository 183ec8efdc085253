// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/BinaryFrame.h"

#include "filters/protocol/Testing/RandomMessages.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace kdstream;
using namespace kdstream::protocol;

namespace
{

using Bytes = std::vector<std::uint8_t>;

Bytes RandomBytes(RandomMessages& random, std::size_t size)
{
  Bytes bytes(size);
  for (auto& byte : bytes)
  {
    byte = random.Small<std::uint8_t>(0, 255);
  }
  return bytes;
}

std::vector<Bytes> Cut(
  std::uint32_t request, const BlobId& id, const Bytes& blob, std::size_t payload)
{
  std::vector<Bytes> frames;
  for (std::size_t at = 0; at < blob.size(); at += payload)
  {
    const auto part = std::span(blob).subspan(at, std::min(payload, blob.size() - at));
    frames.push_back(EncodeFrame(
      { request, id, static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(blob.size()) },
      part));
  }
  return frames;
}

Result<std::optional<FrameAssembler::Blob>> Give(FrameAssembler& assembler, const Bytes& message)
{
  const auto frame = ParseFrame(message);
  KDSTREAM_TRY(frame);
  return assembler.Accept(*frame);
}

// The bytes of unfinished blobs: how many bytes less the assembler accepts because of them.
std::size_t BytesIn(FrameAssembler assembler)
{
  std::size_t room = 0;
  std::uint32_t request = 1000;
  for (Bytes part(maximumPayloadBytes, 1); !part.empty(); part.resize(part.size() / 2))
  {
    const FrameView begin{ { 0, BlobId::Partition(0), 0, maximumBlobBytes }, part };
    const auto takes = [&]
    {
      FrameView frame = begin;
      frame.header.request = ++request;
      return assembler.Accept(frame).HasValue();
    };
    while (takes())
    {
      room += part.size();
    }
  }
  return maximumBlobBytes - room;
}

}

TEST(TestBinaryFrame, LayoutIsAsDocumented)
{
  const Bytes payload{ 0xAA, 0xBB };
  const auto frame =
    EncodeFrame({ 0x01020304, BlobId::LevelPiece(7, 0x11121314), 0x00212223, 0x03000004 }, payload);
  const Bytes expected{ 4, 3, 2, 1, 1, 7, 0, 0, 0x14, 0x13, 0x12, 0x11, 0x23, 0x22, 0x21, 0, 4, 0,
    0, 3, 0xAA, 0xBB };
  EXPECT_EQ(frame, expected);
}

TEST(TestBinaryFrame, BlobsOfAlternatingRequestsComeBack)
{
  RandomMessages random(4);
  FrameAssembler assembler;
  for (int round = 0; round < 50; ++round)
  {
    const auto first = RandomBytes(random, random.Integer(1, 5000));
    const auto second = RandomBytes(random, random.Integer(1, 5000));
    const auto firstFrames = Cut(1, BlobId::Partition(3), first, random.Integer(1, 700));
    const auto secondFrames = Cut(2, BlobId::LevelPiece(9, 1), second, random.Integer(1, 700));
    std::vector<FrameAssembler::Blob> blobs;
    for (std::size_t i = 0; i < std::max(firstFrames.size(), secondFrames.size()); ++i)
    {
      for (const auto* frames : { &firstFrames, &secondFrames })
      {
        if (i < frames->size())
        {
          auto blob = Give(assembler, (*frames)[i]);
          ASSERT_TRUE(blob);
          if (*blob)
          {
            blobs.push_back(std::move(**blob));
          }
        }
      }
    }
    ASSERT_EQ(blobs.size(), 2u);
    std::sort(blobs.begin(), blobs.end(),
      [](const auto& a, const auto& b) { return a.request < b.request; });
    EXPECT_EQ(blobs[0].bytes, first);
    EXPECT_EQ(blobs[0].id, BlobId::Partition(3));
    EXPECT_EQ(blobs[1].bytes, second);
  }
  EXPECT_EQ(BytesIn(assembler), 0u);
}

TEST(TestBinaryFrame, RefusesHeadersOutOfRange)
{
  const Bytes good = EncodeFrame({ 1, BlobId::Partition(3), 5, 10 }, Bytes{ 1, 2, 3 });
  ASSERT_TRUE(ParseFrame(good));
  const auto with = [&](std::size_t at, std::uint8_t value)
  {
    auto bytes = good;
    bytes[at] = value;
    return ParseFrame(bytes).HasValue();
  };
  EXPECT_FALSE(with(0, 0));     // request 0
  EXPECT_FALSE(with(4, 6));     // no such kind
  EXPECT_FALSE(with(5, 1));     // a level of a partition
  EXPECT_FALSE(with(6, 1));     // reserved
  EXPECT_FALSE(with(7, 1));     // reserved
  EXPECT_FALSE(with(11, 0xFF)); // no such partition
  EXPECT_FALSE(with(12, 8));    // 3 bytes at 8 of 10
  EXPECT_FALSE(with(15, 0xFF)); // offset + payload overflows 32 bits
  EXPECT_FALSE(with(16, 0));    // total 0
  EXPECT_FALSE(with(19, 0xFF)); // larger than any blob
  for (std::size_t size = 0; size <= frameHeaderBytes; ++size)
  {
    EXPECT_FALSE(ParseFrame(std::span(good).first(size))) << size; // truncated, or without payload
  }
}

TEST(TestBinaryFrame, RefusesFramesLargerThanTheLimit)
{
  const Bytes blob(2 * maximumPayloadBytes, 7);
  auto frame = EncodeFrame({ 1, BlobId::Partition(0), 0, static_cast<std::uint32_t>(blob.size()) },
    std::span(blob).first(maximumPayloadBytes));
  EXPECT_EQ(frame.size(), maximumFrameBytes);
  EXPECT_TRUE(ParseFrame(frame));
  frame.push_back(7);
  EXPECT_FALSE(ParseFrame(frame));
}

TEST(TestBinaryFrame, RefusesGapsOverlapsAndStrangers)
{
  const Bytes part{ 1, 2, 3 };
  const auto frame = [&](BlobId id, std::uint32_t offset, std::uint32_t total) {
    return FrameView{ { 1, id, offset, total }, part };
  };
  const auto one = BlobId::Partition(1);
  const FrameView wrong[] = {
    frame(one, 0, 9),                  // again
    frame(one, 2, 9),                  // overlap
    frame(one, 6, 9),                  // gap
    frame(one, 3, 10),                 // another total
    frame(BlobId::Partition(2), 3, 9), // another blob
    frame(BlobId::Partition(2), 0, 9), // the start of another blob
  };
  for (const auto& bad : wrong)
  {
    FrameAssembler assembler;
    ASSERT_TRUE(assembler.Accept(frame(one, 0, 9)));
    EXPECT_FALSE(assembler.Accept(bad));
    EXPECT_EQ(BytesIn(assembler), 0u); // the unfinished blob is dropped; the assembler works on
    EXPECT_TRUE(assembler.Accept(frame(one, 0, 9)));
  }
  FrameAssembler assembler;
  EXPECT_FALSE(assembler.Accept(frame(one, 3, 9))); // does not start at offset 0
}

TEST(TestBinaryFrame, ForgetsCancelledRequests)
{
  FrameAssembler assembler;
  const Bytes part{ 1, 2, 3 };
  ASSERT_TRUE(assembler.Accept({ { 1, BlobId::Partition(1), 0, 9 }, part }));
  ASSERT_TRUE(assembler.Accept({ { 2, BlobId::Partition(1), 0, 9 }, part }));
  EXPECT_EQ(BytesIn(assembler), 6u);
  assembler.Forget(1);
  assembler.Forget(7);
  EXPECT_EQ(BytesIn(assembler), 3u);
  EXPECT_TRUE(assembler.Accept({ { 1, BlobId::Partition(5), 0, 3 }, part }));
}

TEST(TestBinaryFrame, UnfinishedBlobsAreBoundedTogether)
{
  FrameAssembler assembler;
  const Bytes part(maximumPayloadBytes, 1);
  std::uint32_t request = 0;
  bool refused = false;
  std::size_t held = 0;
  // A sender that starts blob after blob of the largest size, and never finishes one.
  for (std::size_t sent = 0; !refused && sent <= 2 * std::size_t{ maximumBlobBytes };
       sent += part.size())
  {
    refused = !assembler.Accept({ { ++request, BlobId::Partition(0), 0, maximumBlobBytes }, part });
    held += refused ? 0 : part.size();
    ASSERT_LE(held, std::size_t{ maximumBlobBytes });
  }
  EXPECT_TRUE(refused);
}

TEST(TestBinaryFrame, HostileFramesNeverGiveAWrongSize)
{
  RandomMessages random(5);
  FrameAssembler assembler;
  const auto blob = RandomBytes(random, 900);
  int whole = 0;
  for (int round = 0; round < 3000; ++round)
  {
    const auto request = random.Small<std::uint32_t>(1, 3);
    for (auto frame : Cut(request, random.Blob(), blob, 300))
    {
      if (random.Integer(0, 3) == 0)
      {
        const auto text = random.Mutated(std::string(frame.begin(), frame.end()));
        frame.assign(text.begin(), text.end());
      }
      const auto done = Give(assembler, frame);
      if (done && *done)
      {
        ++whole;
        EXPECT_TRUE(IsValid((*done)->id));
        EXPECT_GT((*done)->bytes.size(), 0u);
      }
    }
  }
  EXPECT_GT(whole, 100); // enough messages are still valid after the mutations
}
