// SPDX-License-Identifier: BSD-3-Clause
// The GET paths of the interface. Clients and exporters write them, servers parse them.
//
//   /api/models.json (alias /api/models)            the models
//   /api/models/{id}/model.json                     one model's description
//   /api/models/{id}/notes.json                     the notes on a model
//   /api/models/{id}/{digest}/tree/{node}           a page of a model's tree
//   /api/models/{id}/{digest}/levels/{d}/{node}     a piece of level d
//   /api/models/{id}/{digest}/partitions/{p}        a partition of the original
//   /api/models/{id}/{digest}/textures/{p}          the texture of a partition
//   /api/models/{id}/{digest}/level-textures/{d}/{node}  the texture of a piece of level d
//   /api/models/{id}/3dtiles/tileset.json           a model's tileset of 3D Tiles
//   /api/models/{id}/3dtiles/{version}/{tile}       a file that the tileset names (TileName.h)
//
// The content at a blob's path never changes: another build of the model has another digest. The
// content at a tile's path does not change either: its version also covers the model's description.
#pragma once

#include "filters/core/Result.h"
#include "filters/protocol/BlobId.h"
#include "filters/protocol/TileName.h"

#include <string>
#include <string_view>

namespace kdstream::protocol
{

// Path and subprotocol of the WebSocket.
inline constexpr std::string_view streamPath = "/api/stream";
inline constexpr std::string_view streamSubprotocol = "kdstream.v2";

// The Content-Security-Policy of the viewer's page, whatever serves it: the page loads nothing from
// other hosts. connect-src names ws: and wss:, because in some browsers 'self' does not include
// them. No frame-ancestors: other sites may embed the viewer.
inline constexpr std::string_view pagePolicy =
  "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self' ws: wss:; "
  "img-src 'self' data:; style-src 'self'; object-src 'none'; base-uri 'none'";

struct ResourcePath
{
  enum class Kind
  {
    ModelList,
    Model,
    Notes,
    Blob,
    Tile
  };
  Kind kind = Kind::ModelList;
  std::string model;  // for all except the list of models
  std::string digest; // for Blob; for Tile the version (empty for the root)
  BlobId blob;        // for Blob
  TileName tile;      // for Tile
};

inline constexpr std::string_view modelListPath = "/api/models.json";
// REQUIRES: IsModelId(model), IsDigest(digest), IsValid(blob).
std::string ModelPath(std::string_view model);
std::string NotesPath(std::string_view model);
std::string BlobPath(std::string_view model, std::string_view digest, const BlobId& blob);

// Parses the path of a URL, without query and fragment. Percent-encoding is not decoded, because
// none of our paths needs it. Errors: NotFound if the path has no known form; InvalidArgument if it
// has a known form with a wrong id, digest or number.
Result<ResourcePath> ParseResourcePath(std::string_view path);

}
