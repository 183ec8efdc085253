// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/sources/RemoteModel.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/PieceCodec.h"

#include <algorithm>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

using Clock = std::chrono::steady_clock;

constexpr std::size_t blobsAtOnce = 128;            // in one request
constexpr std::chrono::milliseconds patience{ 20 }; // between two checks for an abort

}

RemoteModel::RemoteModel(std::unique_ptr<ModelSource> source, std::chrono::seconds timeout)
  : Source(std::move(source))
  , Timeout(timeout)
{
}

Result<std::shared_ptr<const RemoteModel>> RemoteModel::Open(
  const ServerAddress& address, const Execution& execution)
{
  auto source = ConnectServer(address, execution);
  KDSTREAM_TRY(source);
  std::shared_ptr<RemoteModel> opened(new RemoteModel(std::move(*source), address.timeout));
  const auto model = FindModel(opened->Source->Models(), address.model);
  KDSTREAM_TRY(model);
  auto description = opened->AskFor(*model, execution);
  KDSTREAM_TRY(description);
  opened->Description = std::move(*description);
  return std::shared_ptr<const RemoteModel>(std::move(opened));
}

Result<std::unique_lock<std::timed_mutex>> RemoteModel::Lock(const Execution& execution) const
{
  std::unique_lock lock(this->Mutex, std::defer_lock);
  while (!lock.try_lock_for(patience))
  {
    KDSTREAM_TRY(execution.Report("waiting", 0));
  }
  return lock;
}

// The next events: one or more.
Result<std::vector<ClientEvent>> RemoteModel::NextEvents(const Execution& execution) const
{
  const auto begin = Clock::now();
  do
  {
    KDSTREAM_TRY(execution.Report("waiting", 0));
    if (Clock::now() - begin > this->Timeout)
    {
      return NothingArrived(this->Timeout);
    }
  } while (!this->Source->Wait(patience));
  return this->Source->Take();
}

Result<ModelDescription> RemoteModel::AskFor(
  const std::string& model, const Execution& execution) const
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Open;
  request.id = ++this->LastRequest;
  request.model = model;
  this->Source->Send(request);
  for (;;)
  {
    auto events = this->NextEvents(execution);
    KDSTREAM_TRY(events);
    for (ClientEvent& event : *events)
    {
      if (event.request != request.id)
      {
        continue; // the answer to an abandoned request
      }
      if (event.kind != ClientEvent::Kind::Opened)
      {
        return Error{ ErrorCode::NotFound, model + " cannot be opened: " + event.message };
      }
      return std::move(event.model);
    }
  }
}

Result<bool> RemoteModel::IsPresent(const Execution& execution) const
{
  const auto lock = this->Lock(execution);
  KDSTREAM_TRY(lock);
  const auto now = this->AskFor(this->Description.id, execution);
  if (!now && now.GetError().code == ErrorCode::Cancelled)
  {
    return now.GetError();
  }
  return now && now->digest == this->Description.digest;
}

// Fetches all of these blobs; or returns the error of the first that cannot be fetched.
Result<RemoteModel::Blobs> RemoteModel::Fetch(
  std::span<const protocol::BlobId> wanted, const Execution& execution) const
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  request.id = ++this->LastRequest;
  request.blobs.assign(wanted.begin(), wanted.end());
  this->Source->Send(request);
  const auto giveUp = [&](Error error)
  {
    request.kind = SessionRequest::Kind::Cancel;
    request.blobs.clear();
    this->Source->Send(request);
    return error;
  };
  Blobs blobs;
  std::set<protocol::BlobId> outstanding(wanted.begin(), wanted.end());
  while (!outstanding.empty())
  {
    auto events = this->NextEvents(execution);
    if (!events)
    {
      return giveUp(events.GetError());
    }
    for (ClientEvent& event : *events)
    {
      if (event.request != request.id)
      {
        continue; // the answer to an abandoned request
      }
      if (event.kind != ClientEvent::Kind::Blob)
      {
        const bool one = event.kind == ClientEvent::Kind::BlobFailed;
        return giveUp({ one ? ErrorCode::NotFound : ErrorCode::InputOutput,
          protocol::BlobName(one ? event.blob : *outstanding.begin()) +
            " cannot be loaded: " + event.message });
      }
      if (outstanding.erase(event.blob) > 0)
      {
        blobs.emplace(event.blob, std::move(event.bytes));
      }
    }
  }
  return blobs;
}

Result<std::vector<Piece>> RemoteModel::ReadPieces(
  std::span<const PieceId> ids, const Execution& execution) const
{
  const auto lock = this->Lock(execution);
  KDSTREAM_TRY(lock);
  const CodecContext codec = this->Description.Codec();
  std::vector<Piece> pieces;
  while (pieces.size() < ids.size())
  {
    const auto batch =
      ids.subspan(pieces.size(), std::min(blobsAtOnce, ids.size() - pieces.size()));
    std::vector<protocol::BlobId> wanted;
    for (const PieceId id : batch)
    {
      wanted.push_back(BlobOfPiece(id, codec.depths));
    }
    const auto blobs = this->Fetch(wanted, execution);
    KDSTREAM_TRY(blobs);
    for (std::size_t i = 0; i < batch.size(); ++i)
    {
      KDSTREAM_TRY(execution.Report(
        "pieces", static_cast<double>(pieces.size()) / static_cast<double>(ids.size())));
      auto piece = DecodePiece(blobs->at(wanted[i]), batch[i], codec);
      if (!piece)
      {
        return Error{ piece.GetError().code,
          protocol::BlobName(wanted[i]) + ": " + piece.GetError().message };
      }
      pieces.push_back(std::move(*piece));
    }
  }
  return pieces;
}

Result<std::vector<std::uint8_t>> RemoteModel::Read(
  const protocol::BlobId& blob, const Execution& execution) const
{
  const auto lock = this->Lock(execution);
  KDSTREAM_TRY(lock);
  auto blobs = this->Fetch(std::span(&blob, 1), execution);
  KDSTREAM_TRY(blobs);
  return std::move(blobs->at(blob));
}

Result<std::vector<Box>> RemoteModel::ReadBoxes(const Execution& execution) const
{
  const auto lock = this->Lock(execution);
  KDSTREAM_TRY(lock);
  const TreeDepths& depths = this->Description.depths;
  const std::size_t first = std::size_t{ 1 } << DepthOfPartitionBoxes(depths);
  std::vector<Box> partitions; // grows as boxes arrive: the claimed count may be wrong
  for (std::size_t node = first; node < 2 * first;)
  {
    std::vector<protocol::BlobId> wanted;
    for (; node < 2 * first && wanted.size() < blobsAtOnce; ++node)
    {
      wanted.push_back(protocol::BlobId::PartitionBoxes(static_cast<NodeId>(node)));
    }
    const auto blobs = this->Fetch(wanted, execution);
    KDSTREAM_TRY(blobs);
    for (const protocol::BlobId& blob : wanted)
    {
      const auto decoded = DecodePartitionBoxes(blobs->at(blob), blob.number, depths);
      if (!decoded)
      {
        return Error{ decoded.GetError().code,
          protocol::BlobName(blob) + ": " + decoded.GetError().message };
      }
      partitions.insert(partitions.end(), decoded->begin(), decoded->end());
    }
  }
  return BoxesAbove(partitions);
}

}
