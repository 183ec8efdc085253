// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/BinaryFrame.h"

#include <cassert>
#include <string>
#include <utility>

namespace kdstream::protocol
{

namespace
{

void Put(std::vector<std::uint8_t>& bytes, std::uint32_t value, int count)
{
  for (int i = 0; i < count; ++i)
  {
    bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
}

std::uint32_t Take(std::span<const std::uint8_t> message, std::size_t at, int count)
{
  std::uint32_t value = 0;
  for (int i = 0; i < count; ++i)
  {
    value |= static_cast<std::uint32_t>(message[at + static_cast<std::size_t>(i)]) << (8 * i);
  }
  return value;
}

Error Bad(const std::string& what)
{
  return Error{ ErrorCode::InvalidInput, "frame: " + what };
}

// Describes what is out of range in the header or the payload; empty if nothing is.
std::string Fault(const FrameHeader& header, std::size_t payload)
{
  if (header.request == 0)
  {
    return "request 0";
  }
  if (!IsValid(header.blob))
  {
    return "there is no blob of kind " + std::to_string(static_cast<unsigned>(header.blob.kind)) +
           ", level " + std::to_string(header.blob.level) + ", number " +
           std::to_string(header.blob.number);
  }
  if (header.total == 0 || header.total > maximumBlobBytes)
  {
    return "a blob of " + std::to_string(header.total) + " bytes";
  }
  if (payload == 0 || payload > maximumPayloadBytes)
  {
    return "a payload of " + std::to_string(payload) + " bytes";
  }
  if (header.offset > header.total || payload > header.total - header.offset)
  {
    return std::to_string(payload) + " bytes at " + std::to_string(header.offset) + " of " +
           std::to_string(header.total);
  }
  return {};
}

}

std::vector<std::uint8_t> EncodeFrame(
  const FrameHeader& header, std::span<const std::uint8_t> payload)
{
  assert(Fault(header, payload.size()).empty());
  std::vector<std::uint8_t> message;
  message.reserve(frameHeaderBytes + payload.size());
  Put(message, header.request, 4);
  Put(message, static_cast<std::uint32_t>(header.blob.kind), 1);
  Put(message, header.blob.level, 1);
  Put(message, 0, 2);
  Put(message, header.blob.number, 4);
  Put(message, header.offset, 4);
  Put(message, header.total, 4);
  message.insert(message.end(), payload.begin(), payload.end());
  return message;
}

Result<FrameView> ParseFrame(std::span<const std::uint8_t> message)
{
  if (message.size() < frameHeaderBytes)
  {
    return Bad("only " + std::to_string(message.size()) + " bytes");
  }
  if (message[6] != 0 || message[7] != 0)
  {
    return Bad("the reserved bytes are not zero");
  }
  FrameView frame;
  frame.header.request = Take(message, 0, 4);
  frame.header.blob.kind = static_cast<BlobKind>(message[4]);
  frame.header.blob.level = message[5];
  frame.header.blob.number = Take(message, 8, 4);
  frame.header.offset = Take(message, 12, 4);
  frame.header.total = Take(message, 16, 4);
  frame.payload = message.subspan(frameHeaderBytes);
  if (const auto fault = Fault(frame.header, frame.payload.size()); !fault.empty())
  {
    return Bad(fault);
  }
  return frame;
}

Result<std::optional<FrameAssembler::Blob>> FrameAssembler::Accept(const FrameView& frame)
{
  const FrameHeader& header = frame.header;
  if (const auto fault = Fault(header, frame.payload.size()); !fault.empty())
  {
    return Bad(fault);
  }
  const auto refuse = [&](ErrorCode code, const std::string& what)
  {
    this->Forget(header.request);
    return Error{ code,
      "request " + std::to_string(header.request) + ", " + BlobName(header.blob) + ": " + what };
  };

  const auto found = this->Open.find(header.request);
  const std::size_t have = found == this->Open.end() ? 0 : found->second.bytes.size();
  if (found != this->Open.end() &&
      (found->second.id != header.blob || found->second.total != header.total))
  {
    return refuse(
      ErrorCode::InvalidInput, "it starts before the end of " + BlobName(found->second.id));
  }
  if (header.offset != have)
  {
    return refuse(ErrorCode::InvalidInput,
      "offset " + std::to_string(header.offset) + " instead of " + std::to_string(have) + "");
  }
  if (this->Buffered + frame.payload.size() > maximumBlobBytes)
  {
    return refuse(ErrorCode::LimitExceeded,
      "more than " + std::to_string(maximumBlobBytes) + " bytes of unfinished blobs");
  }

  Unfinished& unfinished = this->Open[header.request];
  unfinished.id = header.blob;
  unfinished.total = header.total;
  unfinished.bytes.insert(unfinished.bytes.end(), frame.payload.begin(), frame.payload.end());
  this->Buffered += frame.payload.size();
  if (unfinished.bytes.size() < unfinished.total)
  {
    return std::optional<Blob>();
  }
  Blob blob{ header.request, header.blob, std::move(unfinished.bytes) };
  this->Buffered -= blob.bytes.size();
  this->Open.erase(header.request);
  return std::optional<Blob>(std::move(blob));
}

void FrameAssembler::Forget(std::uint32_t request)
{
  const auto found = this->Open.find(request);
  if (found != this->Open.end())
  {
    this->Buffered -= found->second.bytes.size();
    this->Open.erase(found);
  }
}

}
