// SPDX-License-Identifier: BSD-3-Clause
#include "filters/protocol/ControlMessage.h"

#include "filters/core/Texts.h"
#include "filters/model/JsonReader.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/protocol/TextParts.h"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

namespace kdstream::protocol
{

namespace
{

constexpr std::uint32_t mostId = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t highestNode = (std::uint32_t{ 1 } << (maximumDepth + 1)) - 1;
constexpr std::uint32_t highestPartition = (std::uint32_t{ 1 } << maximumDepth) - 1;
constexpr std::uint64_t mostCount = std::uint64_t{ 1 } << 53;
constexpr std::size_t mostMessageBytes = 4096; // in the text of an error

// Writes the members of each message except its request.
void PutBody(JsonWriter& writer, const OpenRequest& body)
{
  writer.Member("type", "open");
  writer.Member("model", body.model);
}
void PutBody(JsonWriter& writer, const RegionRequest& body)
{
  writer.Member("type", "region");
  writer.Member("cell", body.cell);
  writer.Member("rings", body.rings);
  if (!body.except.empty())
  {
    writer.Member("except", body.except);
  }
}
void PutBody(JsonWriter& writer, const BlobsRequest& body)
{
  writer.Member("type", "blobs").Key("blobs").BeginArray();
  for (const BlobId& blob : body.blobs)
  {
    writer.Put(BlobName(blob));
  }
  writer.EndArray();
}
void PutBody(JsonWriter& writer, const CancelRequest&)
{
  writer.Member("type", "cancel");
}

void PutBody(JsonWriter& writer, const OpenedAnswer& body)
{
  writer.Member("type", "opened");
  writer.Key("model");
  PutModel(writer, body.model);
}
void PutBody(JsonWriter& writer, const BeginAnswer& body)
{
  writer.Member("type", "begin");
  writer.Member("blobs", body.blobs);
  writer.Member("bytes", body.bytes);
  if (body.partitions)
  {
    writer.Member("partitions", *body.partitions);
  }
}
void PutBody(JsonWriter& writer, const ProgressAnswer& body)
{
  writer.Member("type", "progress");
  writer.Member("blobs", body.blobs);
  writer.Member("bytes", body.bytes);
}
void PutBody(JsonWriter& writer, const EndAnswer& body)
{
  writer.Member("type", "end");
  writer.Member("blobs", body.blobs);
  writer.Member("bytes", body.bytes);
  writer.Member("failed", body.failed);
  writer.Member("cancelled", body.cancelled);
}
void PutBody(JsonWriter& writer, const ErrorAnswer& body)
{
  writer.Member("type", "error");
  writer.Member("code", body.code);
  writer.Member("message", body.message);
  if (body.blob)
  {
    writer.Member("blob", BlobName(*body.blob));
  }
}

template <class Message>
std::string Write(const Message& message)
{
  JsonWriter writer;
  writer.BeginObject();
  writer.Member("request", message.request);
  std::visit([&writer](const auto& body) { PutBody(writer, body); }, message.body);
  writer.EndObject();
  return writer.Text();
}

OpenRequest ReadOpen(JsonReader& reader, const JsonValue& json)
{
  OpenRequest body{ reader.Text(json, "model", maximumClientMessageBytes) };
  if (!IsModelId(body.model))
  {
    reader.Fail("not a model id: " + Quoted(body.model));
  }
  return body;
}

BlobsRequest ReadBlobs(JsonReader& reader, const JsonValue& json, std::size_t mostListed)
{
  BlobsRequest body;
  const JsonValue* names = reader.Array(json, "blobs", mostListed);
  for (std::size_t i = 0; names && i < names->Size(); ++i)
  {
    const JsonValue& name = (*names)[i];
    const auto blob = name.IsString() ? ParseBlobName(TextOf(name)) : Result<BlobId>(BlobId{});
    if (!name.IsString() || !blob)
    {
      reader.Fail("\"blobs\": " + (blob ? Show(name) + " is not a name" : blob.GetError().message));
      return {};
    }
    body.blobs.push_back(*blob);
  }
  return body;
}

RegionRequest ReadRegion(JsonReader& reader, const JsonValue& json, std::size_t mostListed)
{
  return { reader.Small<std::uint32_t>(json, "cell", 1, highestNode),
    reader.Small<std::uint8_t>(json, "rings", 0, maximumRings),
    reader.Integers(json, "except", 0, highestPartition, mostListed, false) };
}

BeginAnswer ReadBegin(JsonReader& reader, const JsonValue& json)
{
  BeginAnswer body;
  body.blobs = reader.Integer(json, "blobs", 0, mostCount);
  body.bytes = reader.Integer(json, "bytes", 0, mostCount);
  if (reader.Find(json, "partitions", false))
  {
    body.partitions =
      reader.Integers(json, "partitions", 0, highestPartition, maximumListedPartitions, true);
  }
  return body;
}

EndAnswer ReadEnd(JsonReader& reader, const JsonValue& json)
{
  EndAnswer body;
  body.blobs = reader.Integer(json, "blobs", 0, mostCount);
  body.bytes = reader.Integer(json, "bytes", 0, mostCount);
  body.failed = reader.Integer(json, "failed", 0, mostCount);
  body.cancelled = reader.Boolean(json, "cancelled");
  return body;
}

ErrorAnswer ReadError(JsonReader& reader, const JsonValue& json)
{
  ErrorAnswer body;
  body.code = reader.Small<std::uint16_t>(json, "code", 400, 599);
  body.message = reader.Text(json, "message", mostMessageBytes);
  if (reader.Find(json, "blob", false))
  {
    const auto blob = ParseBlobName(reader.Text(json, "blob", 64));
    if (blob)
    {
      body.blob = *blob;
    }
    else
    {
      reader.Fail("\"blob\": " + blob.GetError().message);
    }
  }
  return body;
}

OpenedAnswer ReadOpened(JsonReader& reader, const JsonValue& json)
{
  OpenedAnswer body;
  if (const JsonValue* object = reader.Find(json, "model"))
  {
    auto model = ModelFromJson(*object);
    if (model)
    {
      body.model = std::move(*model);
    }
    else
    {
      reader.Fail(model.GetError().message);
    }
  }
  return body;
}

void ReadClientBody(
  JsonReader& reader, const JsonValue& json, std::size_t mostListed, ClientMessage& message)
{
  const auto type = reader.Text(json, "type", 32);
  if (type == "open")
  {
    message.body = ReadOpen(reader, json);
  }
  else if (type == "region")
  {
    message.body = ReadRegion(reader, json, mostListed);
  }
  else if (type == "blobs")
  {
    message.body = ReadBlobs(reader, json, mostListed);
  }
  else if (type == "cancel")
  {
    message.body = CancelRequest{};
  }
  else
  {
    constexpr std::array earlier{ "preview", "level", "tree", "boxes", "partitions" };
    const bool isEarlier = std::find(earlier.begin(), earlier.end(), type) != earlier.end();
    reader.Fail("there is no request of type " + Quoted(type) +
                (isEarlier ? " any more: use \"blobs\"" : ""));
  }
}

void ReadServerBody(JsonReader& reader, const JsonValue& json, ServerMessage& message)
{
  const auto type = reader.Text(json, "type", 32);
  if (type == "opened")
  {
    message.body = ReadOpened(reader, json);
  }
  else if (type == "begin")
  {
    message.body = ReadBegin(reader, json);
  }
  else if (type == "progress")
  {
    message.body = ProgressAnswer{ reader.Integer(json, "blobs", 0, mostCount),
      reader.Integer(json, "bytes", 0, mostCount) };
  }
  else if (type == "end")
  {
    message.body = ReadEnd(reader, json);
  }
  else if (type == "error")
  {
    message.body = ReadError(reader, json);
  }
  else
  {
    reader.Fail("there is no answer of type " + Quoted(type));
  }
}

// Parses a text of at most `most` bytes that must be a JSON object.
Result<JsonDocument> ParseObject(std::string_view text, std::size_t most)
{
  if (text.size() > most)
  {
    return Error{ ErrorCode::LimitExceeded, "a message of " + std::to_string(text.size()) +
                                              " bytes; the maximum is " + std::to_string(most) };
  }
  auto json = ParseJson(text);
  if (json && !json->IsObject())
  {
    json = Error{ ErrorCode::InvalidInput, "the message is not a JSON object" };
  }
  return json;
}

}

std::string WriteClientMessage(const ClientMessage& message)
{
  return Write(message);
}

std::string WriteServerMessage(const ServerMessage& message)
{
  return Write(message);
}

Result<ClientMessage> ParseClientMessage(std::string_view text, const MessageLimits& limits)
{
  const auto json = ParseObject(text, limits.bytes);
  KDSTREAM_TRY(json);
  JsonReader reader("message");
  Result<ClientMessage> message = ClientMessage{};
  message->request = reader.Small<std::uint32_t>(*json, "request", 1, mostId);
  ReadClientBody(reader, *json, limits.listed, *message);
  if (!reader.Good())
  {
    message = Error{ ErrorCode::InvalidArgument, reader.Fault() };
  }
  return message;
}

std::uint32_t FindRequestId(std::string_view text, const MessageLimits& limits)
{
  const auto json = ParseObject(text, limits.bytes);
  if (!json)
  {
    return 0;
  }
  JsonReader reader("message");
  const auto request = reader.Small<std::uint32_t>(*json, "request", 1, mostId);
  return reader.Good() ? request : 0;
}

Result<ServerMessage> ParseServerMessage(std::string_view text)
{
  const auto json = ParseObject(text, maximumServerMessageBytes);
  KDSTREAM_TRY(json);
  JsonReader reader("message");
  Result<ServerMessage> message = ServerMessage{};
  message->request = reader.Small<std::uint32_t>(*json, "request", 0, mostId);
  ReadServerBody(reader, *json, *message);
  if (reader.Good() && message->request == 0 && !std::holds_alternative<ErrorAnswer>(message->body))
  {
    reader.Fail("only an error may belong to request 0");
  }
  if (!reader.Good())
  {
    message = Error{ ErrorCode::InvalidInput, reader.Fault() };
  }
  return message;
}

}
