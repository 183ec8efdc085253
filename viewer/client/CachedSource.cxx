// SPDX-License-Identifier: BSD-3-Clause
// A source whose blobs are kept on the disk: see CachedSource.h.
#include "viewer/client/CachedSource.h"

#include "filters/codec/Seal.h"
#include "filters/model/ModelJson.h"

#include <chrono>
#include <string_view>
#include <utility>

namespace kdstream
{
namespace
{

std::string TextOfBytes(const std::vector<std::uint8_t>& bytes)
{
  return { bytes.begin(), bytes.end() };
}

std::vector<std::uint8_t> BytesOfText(std::string_view text)
{
  return { text.begin(), text.end() };
}

constexpr const char* listName = "models"; // with no digest
std::string DescriptionName(const std::string& model)
{
  return "model/" + model;
}
std::string NotesName(const std::string& model)
{
  return "notes/" + model;
}

}

CachedSource::CachedSource(
  std::unique_ptr<ModelSource> server, std::shared_ptr<DiskCache> cache, std::string origin)
  : Server(std::move(server))
  , Cache(std::move(cache))
  , Origin(std::move(origin))
  , ModelList(this->Server ? this->Server->Models() : std::vector<ModelSummary>())
{
  if (this->Server)
  {
    this->Cache->Put(this->KeyOf("", listName), BytesOfText(WriteModelList(this->ModelList)));
  }
}

Result<std::unique_ptr<CachedSource>> CachedSource::Offline(
  std::shared_ptr<DiskCache> cache, std::string origin)
{
  auto source = std::make_unique<CachedSource>(nullptr, std::move(cache), std::move(origin));
  const auto list = source->Cache->Find(source->KeyOf("", listName));
  auto models = list ? ParseModelList(TextOfBytes(*list))
                     : Result<std::vector<ModelSummary>>(
                         Error{ ErrorCode::NotFound, "nothing of this server is in the cache" });
  KDSTREAM_TRY(models);
  source->ModelList = std::move(*models);
  return source;
}

CacheKey CachedSource::KeyOf(const std::string& digest, const std::string& name) const
{
  return { this->Origin, digest, name };
}

void CachedSource::Send(const SessionRequest& request)
{
  switch (request.kind)
  {
    case SessionRequest::Kind::Open:
      this->Open(request);
      break;
    case SessionRequest::Kind::Cancel:
      std::erase_if(
        this->Found, [&](const ClientEvent& event) { return event.request == request.id; });
      if (this->Asked.erase(request.id) > 0)
      {
        this->Server->Send(request);
      }
      break;
    case SessionRequest::Kind::Blobs:
      this->SendBlobs(request);
      break;
  }
}

void CachedSource::Open(const SessionRequest& request)
{
  if (this->Server)
  {
    this->Server->Send(request);
    return;
  }
  ClientEvent event;
  event.request = request.id;
  const auto text = this->Cache->Find(this->KeyOf("", DescriptionName(request.model)));
  auto model = text ? ParseModel(TextOfBytes(*text))
                    : Result<ModelDescription>(Error{ ErrorCode::NotFound, "" });
  if (model)
  {
    event.kind = ClientEvent::Kind::Opened;
    event.model = std::move(*model);
    this->Digest = event.model.digest;
  }
  else
  {
    event.message =
      request.model + " is not in the cache, and " + this->Origin + " cannot be reached";
  }
  this->Found.push_back(std::move(event));
}

// Notes may change while the model does not, so cached notes are used only without a server.
void CachedSource::AskForNotes(const std::string& model)
{
  if (this->Server)
  {
    this->Server->AskForNotes(model);
    return;
  }
  if (auto notes = this->Cache->Find(this->KeyOf("", NotesName(model))))
  {
    ClientEvent event;
    event.kind = ClientEvent::Kind::Notes;
    event.model.id = model;
    event.bytes = std::move(*notes);
    this->Found.push_back(std::move(event));
  }
}

// Answers with cached blobs at once, and requests the others from the server.
void CachedSource::SendBlobs(const SessionRequest& request)
{
  std::vector<protocol::BlobId> here;
  for (const protocol::BlobId& blob : request.blobs)
  {
    const auto begin = std::chrono::steady_clock::now();
    auto bytes = this->Cache->Find(this->KeyOf(this->Digest, protocol::BlobName(blob)));
    if (!bytes && this->Server)
    {
      continue;
    }
    here.push_back(blob);
    ClientEvent event;
    event.request = request.id;
    event.blob = blob;
    event.kind = bytes ? ClientEvent::Kind::Blob : ClientEvent::Kind::BlobFailed;
    event.fromCache = bytes.has_value();
    event.message =
      bytes ? "" : "it is not in the cache, and " + this->Origin + " cannot be reached";
    event.bytes = bytes ? std::move(*bytes) : std::vector<std::uint8_t>();
    event.transmissionSeconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    this->Found.push_back(std::move(event));
  }
  const SessionRequest rest = LeftOf(request, here);
  if (!rest.blobs.empty())
  {
    this->Asked[rest.id] = this->Digest;
    this->Server->Send(rest);
  }
}

std::vector<ClientEvent> CachedSource::Take()
{
  auto events = std::exchange(this->Found, {});
  if (!this->Server)
  {
    return events;
  }
  for (ClientEvent& event : this->Server->Take())
  {
    this->Keep(event);
    events.push_back(std::move(event));
  }
  return events;
}

void CachedSource::Keep(const ClientEvent& event)
{
  if (event.kind == ClientEvent::Kind::Opened)
  {
    this->Digest = event.model.digest;
    this->Cache->Put(
      this->KeyOf("", DescriptionName(event.model.id)), BytesOfText(WriteModel(event.model)));
  }
  if (event.kind == ClientEvent::Kind::Notes)
  {
    this->Cache->Put(this->KeyOf("", NotesName(event.model.id)), event.bytes);
  }
  const auto asked = this->Asked.find(event.request);
  // Damaged blobs are not kept, so they are requested again.
  if (event.kind == ClientEvent::Kind::Blob && asked != this->Asked.end() && IsSealed(event.bytes))
  {
    this->Cache->Put(this->KeyOf(asked->second, protocol::BlobName(event.blob)), event.bytes);
  }
}

bool CachedSource::Wait(std::chrono::milliseconds atMost)
{
  return !this->Found.empty() || (this->Server && this->Server->Wait(atMost));
}

}
