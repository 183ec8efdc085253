// SPDX-License-Identifier: BSD-3-Clause
// The text of a VRML file, checked and made harmless before a library parses it. Part of step
// "convert" of the README's picture.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// A file that an Inline names.
struct VrmlUrl
{
  std::string url;
  std::uint64_t line = 0;
};

struct VrmlText
{
  bool isFirst = false; // VRML 1.0, else 2.0
  // The same scene for the library: lines stay, comments and ROUTEs are blanks (nothing is animated
  // here), and no string names a file: all are empty, but those of an Inline are numbers of `urls`.
  std::string text;
  std::vector<VrmlUrl> urls;
  bool hasPictures = false;  // nodes of textures
  std::uint64_t padding = 0; // zeros and Ctrl-Z at the end, which are left out
};

// Goes through the text once. Errors: InvalidInput naming the line, for another format or version,
// brackets that do not match or are nested deeper than 400, a string without end, control
// characters, a node that contains itself (USE within its DEF, a PROTO within its body);
// Unsupported for EXTERNPROTO; LimitExceeded for more than a million nodes that PROTOs make of it.
Result<VrmlText> CheckVrmlText(std::string_view file);

}
