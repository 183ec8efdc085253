// SPDX-License-Identifier: BSD-3-Clause
// What is wanted and not there, and how it is got: see WishList.h.
#include "viewer/session/line/WishList.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{

using protocol::BlobId;

WishList::WishList(std::size_t aheadBytes)
  : AheadBytes(aheadBytes)
  , AheadLeft(aheadBytes)
{
}

void WishList::Open(const std::string& model)
{
  SessionRequest open;
  open.kind = SessionRequest::Kind::Open;
  open.model = model;
  this->Requests.Send(std::move(open));
}

void WishList::CloseModel()
{
  this->Requests.CancelAll();
  this->Queue.clear();
  this->Ahead.clear();
  this->AheadOf.clear();
  this->Counts = {};
}

void WishList::Want(const std::vector<BlobId>& missing)
{
  std::set<BlobId> useful(missing.begin(), missing.end());
  if (missing.empty())
  {
    useful.merge(this->Ahead);
  }
  this->Ahead.clear();
  this->Requests.CancelUseless(useful);
  for (const auto& [blob, request] : this->Requests.AllOwed())
  {
    if (missing.empty() && useful.count(blob) > 0)
    {
      this->Ahead.insert(blob);
    }
  }
  this->Queue.clear();
  std::copy_if(missing.begin(), missing.end(), std::back_inserter(this->Queue),
    [this](const BlobId& blob) { return !this->Requests.IsOwed(blob); });
}

void WishList::KeepTreeOnly()
{
  std::set<BlobId> kept;
  for (const auto& [blob, request] : this->Requests.AllOwed())
  {
    if (IsOfTree(blob))
    {
      kept.insert(blob);
    }
  }
  this->Requests.CancelUnwanted(kept);
  this->Queue.clear();
}

std::uint32_t WishList::Ask(std::vector<BlobId> blobs)
{
  SessionRequest request;
  request.kind = SessionRequest::Kind::Blobs;
  request.blobs = std::move(blobs);
  return this->Requests.Send(std::move(request));
}

std::size_t WishList::AskMore(const Estimate& bytesOf, const Manner& manner)
{
  const std::size_t window = this->Meter.Window();
  std::size_t underWay = 0, ofTree = 0;
  for (const auto& [blob, request] : this->Requests.AllOwed())
  {
    underWay += bytesOf(blob);
  }
  const auto mayAsk = [&]
  { return !this->Queue.empty() && !(manner.treeOnly && !IsOfTree(this->Queue.front())); };
  while (mayAsk() && underWay < window && this->Requests.RequestCount() < mostRequests)
  {
    const bool isAlone = this->Queue.front() == manner.alone;
    std::vector<BlobId> blobs;
    std::size_t bytes = 0;
    const bool isOriginal = IsOfOriginal(this->Queue.front());
    const auto fits = [&]
    {
      return mayAsk() && !isAlone && bytes < window / 4 &&
             !(manner.originalApart && IsOfOriginal(this->Queue.front()) != isOriginal);
    };
    do
    {
      const BlobId blob = this->Queue.front();
      ofTree += IsOfTree(blob) ? 1 : 0;
      bytes += bytesOf(blob);
      blobs.push_back(blob);
      this->Queue.pop_front();
    } while (fits());
    underWay += bytes;
    const bool isLone = this->Requests.Empty();
    const std::uint32_t id = this->Ask(std::move(blobs));
    this->LoneRequest = isLone ? id : this->LoneRequest;
  }
  this->Counts =
    this->IsIdle()
      ? Progress{}
      : Progress{ this->Counts.blobsLoaded,
          this->Counts.blobsLoaded + this->Requests.AllOwed().size() + this->Queue.size(),
          this->Counts.bytesLoaded };
  return ofTree;
}

bool WishList::MayAskAhead(const std::vector<PieceId>& view)
{
  if (this->AheadBytes == 0 || !this->IsEmpty())
  {
    return false;
  }
  if (this->AheadOf != view)
  {
    this->AheadOf = view;
    this->AheadLeft = this->AheadBytes;
  }
  return this->AheadLeft > 0;
}

void WishList::AskAhead(const std::vector<BlobId>& next, const Estimate& bytesOf)
{
  std::vector<BlobId> blobs;
  std::size_t bytes = 0;
  for (const BlobId& blob : next)
  {
    bytes += bytesOf(blob);
    if (bytes > this->Meter.Window() || bytes > this->AheadLeft)
    {
      break;
    }
    blobs.push_back(blob);
  }
  this->AheadLeft -= blobs.empty() ? this->AheadLeft : std::min(bytes, this->AheadLeft);
  this->Ahead = { blobs.begin(), blobs.end() };
  if (!blobs.empty())
  {
    this->Ask(std::move(blobs));
  }
}

void WishList::SetAhead(std::size_t bytes)
{
  this->AheadBytes = this->AheadLeft = bytes;
  if (bytes == 0 && this->IsOnlyAhead())
  {
    this->Requests.CancelUnwanted({});
  }
}

bool WishList::Arrived(
  std::uint32_t request, const BlobId& blob, std::size_t bytes, double seconds, bool fromCache)
{
  if (!this->Requests.Settle(request, blob))
  {
    return false;
  }
  if (!fromCache)
  {
    this->Meter.Arrived(bytes, seconds, request == this->LoneRequest);
    this->LoneRequest = 0;
  }
  ++this->Counts.blobsLoaded;
  this->Counts.bytesLoaded += bytes;
  return true;
}

bool WishList::GiveUpAhead(const BlobId& blob)
{
  const bool isAhead = this->Ahead.erase(blob) > 0;
  this->AheadLeft = isAhead ? 0 : this->AheadLeft;
  return isAhead;
}

bool WishList::IsOnlyAhead() const
{
  const auto& owed = this->Requests.AllOwed();
  return this->Requests.Empty() ||
         (!owed.empty() && std::all_of(owed.begin(), owed.end(),
                             [this](const auto& each) { return this->IsAhead(each.first); }));
}

}
