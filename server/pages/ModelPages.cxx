// SPDX-License-Identifier: BSD-3-Clause
#include "server/pages/ModelPages.h"

#include "filters/core/Texts.h"
#include "filters/model/Notes.h"
#include "filters/page/IiifManifest.h"
#include "filters/page/ModelPicture.h"
#include "filters/page/PreviewGlb.h"
#include "filters/protocol/BlobId.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace kdstream
{

namespace
{

// Parses /api/models/{id}/{digest}/preview.glb.
std::optional<PagePath> ParsePreviewPath(std::string_view path)
{
  constexpr std::string_view begin = "/api/models/", end = "/preview.glb";
  if (!path.starts_with(begin) || !path.ends_with(end) || path.size() < begin.size() + end.size())
  {
    return std::nullopt;
  }
  path = path.substr(begin.size(), path.size() - begin.size() - end.size());
  const auto slash = path.find('/');
  if (slash == std::string_view::npos)
  {
    return std::nullopt;
  }
  return PagePath{ PagePath::Kind::Preview, std::string(path.substr(0, slash)), false,
    std::string(path.substr(slash + 1)) };
}

}

std::optional<PagePath> ParsePagePath(std::string_view path)
{
  using Kind = PagePath::Kind;
  if (path == "/oembed")
  {
    return PagePath{ Kind::Embed };
  }
  if (auto preview = ParsePreviewPath(path))
  {
    return preview;
  }
  const auto begin = "/" + std::string(pagesFolder);
  if (path == begin || path == begin.substr(0, begin.size() - 1))
  {
    return PagePath{ Kind::List, {}, path == begin };
  }
  if (!path.starts_with(begin))
  {
    return std::nullopt;
  }
  path.remove_prefix(begin.size());
  const auto slash = std::min(path.find('/'), path.size());
  const auto rest = path.substr(slash);
  const auto name = path.substr(0, slash);
  const std::string model = PercentDecoded(name).value_or(std::string(name));
  if (rest.empty() || rest == "/")
  {
    return PagePath{ Kind::Page, model, !rest.empty() };
  }
  if (rest == "/picture.jpg" || rest == "/manifest.json")
  {
    return PagePath{ rest == "/picture.jpg" ? Kind::Picture : Kind::Manifest, model };
  }
  return std::nullopt;
}

PagePlace PlaceOf(const PagePath& path, const std::string& root)
{
  if (path.kind == PagePath::Kind::List)
  {
    return { root, path.isFolder ? "../" : "" };
  }
  const bool isBelow = path.isFolder || path.kind == PagePath::Kind::Manifest;
  return { root, isBelow ? "../../" : "../" };
}

std::string ManifestOf(const Catalog& catalog, const ServedModel& model, const PagePlace& place)
{
  const auto& description = model.Description();
  std::vector<Note> notes;
  if (const auto text = catalog.ReadNotes(description.id))
  {
    auto parsed = ParseNotes({ reinterpret_cast<const char*>((*text)->data()), (*text)->size() });
    notes = parsed ? std::move(*parsed) : std::vector<Note>();
  }
  return WriteIiifManifest(description, place, notes);
}

Result<BlobBytes> PreviewOf(const ServedModel& model)
{
  const auto& description = model.Description();
  if (!HasPreviewGlb(description))
  {
    return Error{ ErrorCode::NotFound, "there is no preview of " + description.id + " as glTF" };
  }
  const auto blob = model.ReadBlob(BlobOfPiece(PreviewPiece(description), description.depths));
  KDSTREAM_TRY(blob);
  auto bytes = EncodePreviewGlb(description, **blob);
  KDSTREAM_TRY(bytes);
  return BlobBytes(std::make_shared<const std::vector<std::uint8_t>>(std::move(*bytes)));
}

BlobBytes PictureKeeper::Find(const BlobBytes& description) const
{
  const std::lock_guard lock(this->Mutex);
  const auto found = std::find_if(this->Recent.begin(), this->Recent.end(),
    [&](const Kept& each) { return *each.description == *description; });
  if (found == this->Recent.end())
  {
    return nullptr;
  }
  this->Recent.splice(this->Recent.begin(), this->Recent, found);
  return found->picture;
}

void PictureKeeper::Keep(const BlobBytes& description, const BlobBytes& picture) const
{
  const std::lock_guard lock(this->Mutex);
  this->Recent.push_front({ description, picture });
  this->Bytes += picture->size();
  while (this->Bytes > keptBytes)
  {
    this->Bytes -= this->Recent.back().picture->size();
    this->Recent.pop_back();
  }
}

Result<BlobBytes> PictureKeeper::Get(const ServedModel& model) const
{
  const auto& description = model.Description();
  if (!HasPicture(description))
  {
    return Error{ ErrorCode::NotFound, "there is no picture of " + description.id };
  }
  const auto json = model.Json();
  if (auto kept = this->Find(json))
  {
    return kept;
  }
  // Read before taking a place in the queue, so that a disk that hangs does not keep others from
  // drawing.
  const auto blob = model.ReadBlob(BlobOfPiece(PreviewPiece(description), description.depths));
  KDSTREAM_TRY(blob);
  struct Place
  {
    std::atomic<int>& waiting;
    const bool isFree = ++waiting <= mostWaiting;
    explicit Place(std::atomic<int>& number)
      : waiting(number)
    {
    }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    ~Place() { --waiting; }
  } const place(this->Waiting);
  if (!place.isFree)
  {
    return Error{ ErrorCode::Cancelled, "too many pictures are drawn at once: try again" };
  }
  const std::lock_guard lock(this->Drawing);
  if (auto kept = this->Find(json)) // made by the request that this one waited for
  {
    return kept;
  }
  auto picture = DrawModelPicture(description, **blob);
  KDSTREAM_TRY(picture);
  auto bytes = std::make_shared<const std::vector<std::uint8_t>>(std::move(*picture));
  this->Keep(json, bytes);
  return BlobBytes(std::move(bytes));
}

}
