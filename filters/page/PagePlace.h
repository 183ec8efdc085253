// SPDX-License-Identifier: BSD-3-Clause
// The addresses of models' pages, and of the files that belong to them (doc/protocol.md#pages):
//
//   m/                     the page of all models
//   m/{id}                 the page of a model; m/{id}/ if files are served
//   m/{id}/picture.jpg     its picture
//   m/{id}/manifest.json   its IIIF manifest
//   api/models/{id}/{digest}/preview.glb   its preview as glTF
//   oembed?url=…           how to embed it; m/{id}/oembed.json if files are served
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

inline constexpr std::string_view pagesFolder = "m/";

struct PagePlace
{
  // The address of the viewer's folder, with a slash at its end ("https://museum.example/3d/").
  // Empty: not known; addresses are then relative.
  std::string root = {};
  std::string up = "../"; // the path to that folder from the page's own folder
  bool isFolder = false;  // each page is a file in its own folder, so its address ends with a slash

  // REQUIRES: IsModelId(model); such characters need no escapes.
  std::string Page(std::string_view model) const;
  std::string Picture(std::string_view model) const;
  std::string Manifest(std::string_view model) const;
  std::string Preview(std::string_view model, std::string_view digest) const;
  std::string Embed(std::string_view model) const; // REQUIRES: root is known
  const std::string& Base() const { return this->root.empty() ? this->up : this->root; }
};

// Whether the text, with a slash added, is valid as a root: http(s), a host, maybe a port and a
// path; no user, query, fragment, or character that must be escaped in an address.
bool IsPageRoot(std::string_view text);

// The model whose page, or old address ("?…#model=ID"), the text is; empty if it is not an address
// below the root. http and https count as the same.
std::string ModelOfAddress(std::string_view address, std::string_view root);

}
