// SPDX-License-Identifier: BSD-3-Clause
// Which requests are in flight, and which of their blobs are outstanding: step "request" of the
// pipeline picture.
#include "viewer/session/requests/RequestBook.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

std::uint32_t RequestBook::Send(SessionRequest request)
{
  request.id = ++this->LastId;
  Entry& entry = this->Open[request.id];
  entry.outstanding.insert(request.blobs.begin(), request.blobs.end());
  for (const protocol::BlobId& blob : request.blobs)
  {
    this->Outstanding[blob] = request.id;
  }
  entry.request = request;
  this->Unsent.push_back(std::move(request));
  return this->LastId;
}

void RequestBook::Cancel(std::uint32_t request)
{
  const auto entry = this->Open.find(request);
  for (const protocol::BlobId& blob : entry->second.outstanding)
  {
    this->Outstanding.erase(blob);
  }
  Entry cancelled = std::move(entry->second);
  this->Open.erase(entry);
  // A request that has not been sent yet is only forgotten.
  const auto unsent = std::find_if(this->Unsent.begin(), this->Unsent.end(),
    [request](const SessionRequest& r) { return r.id == request; });
  if (unsent != this->Unsent.end())
  {
    this->Unsent.erase(unsent);
    return;
  }
  this->Cancelled[request] = std::move(cancelled);
  if (this->Cancelled.size() > cancelledRequests)
  {
    this->Cancelled.erase(this->Cancelled.begin());
  }
  SessionRequest cancel;
  cancel.kind = SessionRequest::Kind::Cancel;
  cancel.id = request;
  this->Unsent.push_back(cancel);
}

void RequestBook::CancelUnwanted(const std::set<protocol::BlobId>& wanted)
{
  this->CancelWhere(
    wanted, [](std::size_t useful, std::size_t outstanding) { return useful < outstanding; });
}

void RequestBook::CancelUseless(const std::set<protocol::BlobId>& wanted)
{
  this->CancelWhere(wanted,
    [](std::size_t useful, std::size_t outstanding) { return useful == 0 && outstanding > 0; });
}

void RequestBook::CancelWhere(const std::set<protocol::BlobId>& wanted,
  bool (*cancels)(std::size_t useful, std::size_t outstanding))
{
  std::vector<std::uint32_t> cancelled;
  for (const auto& [id, entry] : this->Open)
  {
    const auto useful = std::count_if(entry.outstanding.begin(), entry.outstanding.end(),
      [&](const protocol::BlobId& blob) { return wanted.count(blob) > 0; });
    if (cancels(static_cast<std::size_t>(useful), entry.outstanding.size()))
    {
      cancelled.push_back(id);
    }
  }
  for (const std::uint32_t id : cancelled)
  {
    this->Cancel(id);
  }
}

void RequestBook::CancelAll()
{
  while (!this->Open.empty())
  {
    this->Cancel(this->Open.begin()->first);
  }
  this->Cancelled.clear();
}

bool RequestBook::TakeLate(std::uint32_t request, const protocol::BlobId& blob)
{
  const auto entry = this->Cancelled.find(request);
  return entry != this->Cancelled.end() && entry->second.outstanding.erase(blob) > 0;
}

bool RequestBook::Settle(std::uint32_t request, const protocol::BlobId& blob)
{
  const auto entry = this->Open.find(request);
  if (entry == this->Open.end() || entry->second.outstanding.erase(blob) == 0)
  {
    return false;
  }
  this->Outstanding.erase(blob);
  if (entry->second.outstanding.empty())
  {
    this->Open.erase(entry);
  }
  return true;
}

bool RequestBook::SettleOpen(std::uint32_t request)
{
  const auto entry = this->Open.find(request);
  if (entry == this->Open.end() || entry->second.request.kind != SessionRequest::Kind::Open)
  {
    return false;
  }
  this->Open.erase(entry);
  return true;
}

std::vector<protocol::BlobId> RequestBook::Close(std::uint32_t request)
{
  const auto entry = this->Open.find(request);
  if (entry == this->Open.end())
  {
    return {};
  }
  std::vector<protocol::BlobId> outstanding(
    entry->second.outstanding.begin(), entry->second.outstanding.end());
  for (const protocol::BlobId& blob : outstanding)
  {
    this->Outstanding.erase(blob);
  }
  this->Open.erase(entry);
  return outstanding;
}

const SessionRequest* RequestBook::Find(std::uint32_t request) const
{
  const auto entry = this->Open.find(request);
  return entry == this->Open.end() ? nullptr : &entry->second.request;
}

std::string RequestBook::Describe() const
{
  constexpr std::size_t most = 5;
  std::vector<std::string> names;
  for (const auto& [id, entry] : this->Open)
  {
    if (entry.request.kind == SessionRequest::Kind::Open)
    {
      names.push_back("open " + entry.request.model);
    }
    for (const protocol::BlobId& blob : entry.outstanding)
    {
      names.push_back(protocol::BlobName(blob));
    }
  }
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i)
  {
    text += (i > 0 ? ", " : "") + names[i];
  }
  return names.size() > most ? text + ", and " + std::to_string(names.size() - most) + " more"
                             : text;
}

std::vector<SessionRequest> RequestBook::TakeOutgoing()
{
  return std::exchange(this->Unsent, {});
}

}
