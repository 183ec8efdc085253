// SPDX-License-Identifier: BSD-3-Clause
// The addresses of models' pages, and of what belongs to them (doc/protocol.md#pages):
//
//   m/                     the page of all models
//   m/{id}                 the page; m/{id}/ where files are served
//   m/{id}/picture.jpg     its picture
//   m/{id}/manifest.json   its IIIF manifest
//   api/models/{id}/{digest}/preview.glb   its preview as glTF
//   oembed?url=…           how to embed it; m/{id}/oembed.json where files are served
#pragma once

#include <string>
#include <string_view>

namespace kdstream
{

inline constexpr std::string_view pagesFolder = "m/";

struct PagePlace
{
  // The address of the viewer's folder, with a slash at its end ("https://museum.example/3d/");
  // empty: it is not known, and addresses are relative.
  std::string root = {};
  std::string up = "../"; // the way there from the page's own folder
  bool isFolder = false;  // each page is a file in a folder: its address ends with a slash

  // REQUIRES: IsModelId(model), whose characters need no escapes.
  std::string Page(std::string_view model) const;
  std::string Picture(std::string_view model) const;
  std::string Manifest(std::string_view model) const;
  std::string Preview(std::string_view model, std::string_view digest) const;
  std::string Embed(std::string_view model) const; // REQUIRES: the root is known
  const std::string& Base() const { return this->root.empty() ? this->up : this->root; }
};

// Whether the text may be a root, but for the slash at its end: http(s), a host, perhaps a port and
// a path; no user, query, fragment or character that an address must escape.
bool IsPageRoot(std::string_view text);

// The model whose page, or old address ("?…#model=ID"), a text is; empty if it is none below the
// root. http and https are the same here.
std::string ModelOfAddress(std::string_view address, std::string_view root);

}
