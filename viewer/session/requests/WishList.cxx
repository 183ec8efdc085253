// SPDX-License-Identifier: BSD-3-Clause
// The wanted blobs that are not loaded, and requesting them: see WishList.h.
#include "viewer/session/requests/WishList.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace kdstream
{

using protocol::BlobId;

WishList::WishList(std::size_t prefetchBytes)
  : PrefetchBytes(prefetchBytes)
  , PrefetchLeft(prefetchBytes)
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
  this->Prefetched.clear();
  this->PrefetchedFor.clear();
  this->Counts = {};
}

void WishList::Want(const std::vector<BlobId>& missing)
{
  std::set<BlobId> useful(missing.begin(), missing.end());
  if (missing.empty())
  {
    useful.merge(this->Prefetched);
  }
  this->Prefetched.clear();
  this->Requests.CancelUseless(useful);
  for (const auto& [blob, request] : this->Requests.AllOutstanding())
  {
    if (missing.empty() && useful.count(blob) > 0)
    {
      this->Prefetched.insert(blob);
    }
  }
  this->Queue.clear();
  std::copy_if(missing.begin(), missing.end(), std::back_inserter(this->Queue),
    [this](const BlobId& blob) { return !this->Requests.IsOutstanding(blob); });
}

void WishList::KeepTreeOnly()
{
  std::set<BlobId> kept;
  for (const auto& [blob, request] : this->Requests.AllOutstanding())
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
  std::size_t inFlight = 0, ofTree = 0;
  for (const auto& [blob, request] : this->Requests.AllOutstanding())
  {
    inFlight += bytesOf(blob);
  }
  const auto mayAsk = [&]
  { return !this->Queue.empty() && !(manner.treeOnly && !IsOfTree(this->Queue.front())); };
  while (mayAsk() && inFlight < window && this->Requests.RequestCount() < mostRequests)
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
    inFlight += bytes;
    const bool isLone = this->Requests.Empty();
    const std::uint32_t id = this->Ask(std::move(blobs));
    this->LoneRequest = isLone ? id : this->LoneRequest;
  }
  this->Counts =
    this->IsIdle()
      ? Progress{}
      : Progress{ this->Counts.blobsLoaded,
          this->Counts.blobsLoaded + this->Requests.AllOutstanding().size() + this->Queue.size(),
          this->Counts.bytesLoaded };
  return ofTree;
}

bool WishList::MayPrefetch(const std::vector<PieceId>& view)
{
  if (this->PrefetchBytes == 0 || !this->IsEmpty())
  {
    return false;
  }
  if (this->PrefetchedFor != view)
  {
    this->PrefetchedFor = view;
    this->PrefetchLeft = this->PrefetchBytes;
  }
  return this->PrefetchLeft > 0;
}

void WishList::Prefetch(const std::vector<BlobId>& next, const Estimate& bytesOf)
{
  std::vector<BlobId> blobs;
  std::size_t bytes = 0;
  for (const BlobId& blob : next)
  {
    bytes += bytesOf(blob);
    if (bytes > this->Meter.Window() || bytes > this->PrefetchLeft)
    {
      break;
    }
    blobs.push_back(blob);
  }
  this->PrefetchLeft -= blobs.empty() ? this->PrefetchLeft : std::min(bytes, this->PrefetchLeft);
  this->Prefetched = { blobs.begin(), blobs.end() };
  if (!blobs.empty())
  {
    this->Ask(std::move(blobs));
  }
}

void WishList::SetPrefetch(std::size_t bytes)
{
  this->PrefetchBytes = this->PrefetchLeft = bytes;
  if (bytes == 0 && this->IsOnlyPrefetched())
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

bool WishList::GiveUpPrefetch(const BlobId& blob)
{
  const bool isPrefetched = this->Prefetched.erase(blob) > 0;
  this->PrefetchLeft = isPrefetched ? 0 : this->PrefetchLeft;
  return isPrefetched;
}

bool WishList::IsOnlyPrefetched() const
{
  const auto& outstanding = this->Requests.AllOutstanding();
  return this->Requests.Empty() ||
         (!outstanding.empty() &&
           std::all_of(outstanding.begin(), outstanding.end(),
             [this](const auto& each) { return this->IsPrefetched(each.first); }));
}

}
