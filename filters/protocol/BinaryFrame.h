// SPDX-License-Identifier: BSD-3-Clause
// Binary messages of the stream: splits blobs into frames of at most 64 KiB, and joins frames into
// blobs.
//
// Layout (little-endian): request u32, kind u8, level u8, zero u16, number u32, offset u32, total
// u32, then the payload: the blob's bytes [offset, offset + payload) of `total`. Frames are small,
// so that a cancellation never waits for a large blob.
#pragma once

#include "filters/core/Result.h"
#include "filters/protocol/BlobId.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace kdstream::protocol
{

inline constexpr std::size_t frameHeaderBytes = 20;
inline constexpr std::size_t maximumFrameBytes = std::size_t{ 64 } << 10;
inline constexpr std::size_t maximumPayloadBytes = maximumFrameBytes - frameHeaderBytes;

struct FrameHeader
{
  std::uint32_t request = 0; // from 1
  BlobId blob;
  std::uint32_t offset = 0; // of the payload in the blob
  std::uint32_t total = 0;  // bytes of the whole blob, 1 … maximumBlobBytes
};

// A frame as it lies in a received message: the payload is a view of that message.
struct FrameView
{
  FrameHeader header;
  std::span<const std::uint8_t> payload;
};

// REQUIRES: the header's members are in their ranges; the payload has 1 … maximumPayloadBytes
// bytes; offset + payload <= total.
std::vector<std::uint8_t> EncodeFrame(
  const FrameHeader& header, std::span<const std::uint8_t> payload);

// Errors: InvalidInput, naming the field that is out of range.
Result<FrameView> ParseFrame(std::span<const std::uint8_t> message);

// Joins frames into blobs.
// The frames of one blob must come in order, without gaps; frames of different requests may
// alternate. Memory is allocated only for bytes that have arrived, and at most maximumBlobBytes for
// all unfinished blobs together.
class FrameAssembler
{
public:
  struct Blob
  {
    std::uint32_t request = 0;
    BlobId id;
    std::vector<std::uint8_t> bytes;
  };

  // Takes the next frame; returns the blob that it completes, if any. Errors: InvalidInput for a
  // gap, an overlap, or another blob or total before the blob is complete; LimitExceeded for too
  // many unfinished bytes. After an error, the unfinished blob of the frame's request is dropped.
  Result<std::optional<Blob>> Accept(const FrameView& frame);

  // Drops the unfinished blob of a request: call it when the request's `end` or `error` has
  // arrived.
  void Forget(std::uint32_t request);

private:
  struct Unfinished
  {
    BlobId id;
    std::uint32_t total = 0;
    std::vector<std::uint8_t> bytes;
  };
  std::map<std::uint32_t, Unfinished> Open; // by request
  std::size_t Buffered = 0;
};

}
