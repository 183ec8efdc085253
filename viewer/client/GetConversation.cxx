// SPDX-License-Identifier: BSD-3-Clause
// A session's requests as plain GETs, one blob after the other, for servers without a stream.
#include "viewer/client/GetConversation.h"

#include "filters/model/Json.h"
#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

std::string DescribeRefusal(const HttpReply& reply)
{
  std::string text = "the server says " + std::to_string(reply.status);
  const auto json = ParseJson(reply.body);
  const auto* error = json && json->IsObject() ? FindMember(*json, "error") : nullptr;
  if (error && error->IsString())
  {
    text += ": " + std::string(TextOf(*error).substr(0, 500));
  }
  return text;
}

void GetConversation::Send(const SessionRequest& request, double now)
{
  if (request.kind == SessionRequest::Kind::Cancel)
  {
    std::erase_if(
      this->Waiting, [&request](const Item& item) { return item.request == request.id; });
    this->Cancelled = this->Cancelled || (this->Current && this->Current->request == request.id);
    return;
  }
  if (request.kind == SessionRequest::Kind::Open)
  {
    this->Waiting.push_back({ request.id, request.model, {}, now });
  }
  for (const protocol::BlobId& blob : request.blobs)
  {
    this->Waiting.push_back({ request.id, {}, blob, now });
  }
}

std::optional<HttpFetch> GetConversation::Next()
{
  if (this->Current || this->Waiting.empty())
  {
    return std::nullopt;
  }
  this->Current = std::move(this->Waiting.front());
  this->Waiting.pop_front();
  this->Cancelled = false;
  if (!this->Current->model.empty())
  {
    return HttpFetch{ protocol::ModelPath(this->Current->model), maximumModelBytes };
  }
  return HttpFetch{ protocol::BlobPath(this->Model, this->Digest, this->Current->blob),
    protocol::maximumBlobBytes };
}

void GetConversation::Receive(const Result<HttpReply>& reply, double now)
{
  if (!this->Current)
  {
    return;
  }
  const Item item = *std::exchange(this->Current, std::nullopt);
  const double begin = std::max(item.asked, std::exchange(this->LastBlob, now));
  if (this->Cancelled)
  {
    return;
  }
  ClientEvent event;
  event.request = item.request;
  event.blob = item.blob;
  event.transmissionSeconds = now - begin;
  if (!reply || reply->status != 200)
  {
    const bool forbidden = reply && IsForbidden(reply->status); // so the whole request fails
    event.kind = item.model.empty() && !forbidden ? ClientEvent::Kind::BlobFailed
                                                  : ClientEvent::Kind::RequestFailed;
    if (forbidden)
    {
      std::erase_if(
        this->Waiting, [&item](const Item& other) { return other.request == item.request; });
    }
    event.message = reply ? DescribeRefusal(*reply) : reply.GetError().message;
  }
  else if (item.model.empty())
  {
    event.kind = ClientEvent::Kind::Blob;
    event.bytes.assign(reply->body.begin(), reply->body.end());
  }
  else
  {
    auto model = ParseModel(reply->body);
    if (model && model->id == item.model)
    {
      event.kind = ClientEvent::Kind::Opened;
      this->Model = model->id;
      this->Digest = model->digest;
      event.model = std::move(*model);
    }
    else
    {
      event.message = model ? "the server sent another model" : model.GetError().message;
    }
  }
  this->Events.push_back(std::move(event));
}

void GetConversation::PutBack()
{
  if (this->Current && !this->Cancelled)
  {
    this->Waiting.push_front(std::move(*this->Current));
  }
  this->Current.reset();
}

std::vector<ClientEvent> GetConversation::TakeEvents()
{
  return std::exchange(this->Events, {});
}

}
