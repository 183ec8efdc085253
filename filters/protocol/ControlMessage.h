// SPDX-License-Identifier: BSD-3-Clause
// The JSON messages of the stream: a client's requests, and a server's answers, except the blobs
// themselves.
//
// Every request has an id that the client chooses (1 … 2^32 - 1, but not the id of one of its
// unfinished requests). The answer to a request is `opened`; or `begin`, then frames and
// `progress`, then `end`; or only `error`.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/BlobId.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace kdstream::protocol
{

inline constexpr std::size_t maximumClientMessageBytes = 4096;
// Limits on a client's message that a server accepts; viewers stay below them.
struct MessageLimits
{
  std::size_t bytes = maximumClientMessageBytes;
  std::size_t listed = maximumClientMessageBytes / 2; // items in a list; more would not fit
};
inline constexpr std::size_t maximumServerMessageBytes = maximumModelBytes + 4096;
inline constexpr std::uint8_t maximumRings = 3;
// `begin` lists the partitions of a region if there are at most this number.
inline constexpr std::size_t maximumListedPartitions = 4096;

// ---- From the client

// Chooses the model to which the following requests refer.
struct OpenRequest
{
  std::string model;
  bool operator==(const OpenRequest&) const = default;
};

// The partitions of the region of `rings` rings around `cell`, nearest first, without those in
// `except`.
struct RegionRequest
{
  std::uint32_t cell = 1;
  std::uint8_t rings = 1; // 0-3
  std::vector<std::uint32_t> except;
  bool operator==(const RegionRequest&) const = default;
};

// Blobs of any kind, in the order given.
struct BlobsRequest
{
  std::vector<BlobId> blobs;
  bool operator==(const BlobsRequest&) const = default;
};

// Ends the request with this id. Has no answer of its own: the ended request gets its `end`.
struct CancelRequest
{
  bool operator==(const CancelRequest&) const = default;
};

struct ClientMessage
{
  std::uint32_t request = 0;
  std::variant<OpenRequest, RegionRequest, BlobsRequest, CancelRequest> body;
  bool operator==(const ClientMessage&) const = default;
};

// A long list can make the text longer than maximumClientMessageBytes: the caller must check.
std::string WriteClientMessage(const ClientMessage& message);

// Errors: LimitExceeded for too many bytes; InvalidInput if the text is not a JSON object (both end
// the conversation); InvalidArgument, naming the wrong member (an error of this request only).
Result<ClientMessage> ParseClientMessage(std::string_view text, const MessageLimits& limits = {});

// The request id in a message that ParseClientMessage refused with InvalidArgument; 0 if it has
// none.
std::uint32_t FindRequestId(std::string_view text, const MessageLimits& limits = {});

// ---- From the server

struct OpenedAnswer
{
  ModelDescription model;
  bool operator==(const OpenedAnswer&) const = default;
};

struct BeginAnswer
{
  std::uint64_t blobs = 0; // the number that will be sent
  std::uint64_t bytes = 0; // estimated from the model's averages, for a progress bar
  // For a region: its partitions, nearest first, including those of `except`; absent if more than
  // maximumListedPartitions (the client can compute them).
  std::optional<std::vector<std::uint32_t>> partitions;
  bool operator==(const BeginAnswer&) const = default;
};

// The amount sent so far. Sent about once for each mebibyte.
struct ProgressAnswer
{
  std::uint64_t blobs = 0;
  std::uint64_t bytes = 0;
  bool operator==(const ProgressAnswer&) const = default;
};

struct EndAnswer
{
  std::uint64_t blobs = 0;  // sent whole
  std::uint64_t bytes = 0;  // of payload
  std::uint64_t failed = 0; // blobs that could not be sent; each has got an `error`
  bool cancelled = false;
  bool operator==(const EndAnswer&) const = default;
};

// With a blob: the server cannot send this blob, and the request goes on. Without a blob: the
// request has ended.
struct ErrorAnswer
{
  std::uint16_t code = 500; // a status code of HTTP
  std::string message;
  std::optional<BlobId> blob;
  bool operator==(const ErrorAnswer&) const = default;
};

struct ServerMessage
{
  std::uint32_t request = 0; // 0: an error that does not belong to a request
  std::variant<OpenedAnswer, BeginAnswer, ProgressAnswer, EndAnswer, ErrorAnswer> body;
  bool operator==(const ServerMessage&) const = default;
};

std::string WriteServerMessage(const ServerMessage& message);

// Errors: LimitExceeded for too many bytes; InvalidInput, saying what is wrong.
Result<ServerMessage> ParseServerMessage(std::string_view text);

}
