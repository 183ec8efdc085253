// SPDX-License-Identifier: BSD-3-Clause
// The pages of models as a server makes them (doc/protocol.md#pages): which address belongs to
// what, and the pictures, which are drawn once and kept. Step "serve" of the pipeline picture. No
// sockets.
#pragma once

#include "filters/core/Result.h"
#include "filters/page/PagePlace.h"
#include "server/session/Catalog.h"

#include <atomic>
#include <cstddef>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

struct PagePath
{
  enum class Kind
  {
    List, // the page of all models
    Page,
    Picture,
    Manifest,
    Preview,
    Embed
  };
  Kind kind = Kind::Page;
  std::string
    model{}; // unless List or Embed. Any bytes: escapes are decoded, nothing else is checked
  bool isFolder = false; // the address of the page ends with a slash
  std::string digest{};  // only for Preview: any bytes
};

// Parses a path without its query. Nothing if the path has none of these forms.
std::optional<PagePath> ParsePagePath(std::string_view path);

// The place of a page, or of a file that belongs to it. root: the server's address, empty if it is
// unknown.
PagePlace PlaceOf(const PagePath& path, const std::string& root);

// The model's notes and description as a IIIF manifest. Notes that cannot be read are left out.
std::string ManifestOf(const Catalog& catalog, const ServedModel& model, const PagePlace& place);

// The preview as a .glb file. May wait for a disk. Errors: NotFound if the model has no preview;
// those of ServedModel::ReadBlob and of EncodePreviewGlb.
Result<BlobBytes> PreviewOf(const ServedModel& model);

// All functions may be called from any thread.
class PictureKeeper
{
public:
  static constexpr std::size_t keptBytes = std::size_t{ 16 } << 20;
  // Requests that may wait for a picture to be drawn, which takes much computing.
  static constexpr int mostWaiting = 4;

  // The model's picture, a JPEG. One picture is drawn at a time. May wait for a disk. Errors:
  // NotFound if the model has no picture; Cancelled if too many requests wait already, in which
  // case the client can try again later; those of ServedModel::ReadBlob and of DrawModelPicture.
  Result<BlobBytes> Get(const ServedModel& model) const;

private:
  // Finds a picture by the whole description, because the home view is part of the description, but
  // not of the digest.
  BlobBytes Find(const BlobBytes& description) const;
  void Keep(const BlobBytes& description, const BlobBytes& picture) const;

  struct Kept
  {
    BlobBytes description, picture;
  };
  mutable std::atomic<int> Waiting{ 0 };
  mutable std::mutex Drawing;
  mutable std::mutex Mutex;       // for the members below
  mutable std::list<Kept> Recent; // the latest first
  mutable std::size_t Bytes = 0;
};

}
