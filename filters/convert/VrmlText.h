// SPDX-License-Identifier: BSD-3-Clause
// Checks the text of a VRML file, and makes it harmless before a library parses it. Part of step
// "convert" of the pipeline picture.
#pragma once

#include "filters/convert/VrmlCommas.h"
#include "filters/core/Result.h"
#include "filters/meshio/Tolerance.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

// A file that an Inline node names.
struct VrmlUrl
{
  std::string url;
  std::uint64_t line = 0;
};

// Nodes of one kind that are left out: which and why ("'Knob', which VRML does not have"), how
// many, and the line of the first one (0 if unknown).
struct VrmlLeftOut
{
  std::uint64_t count = 0, line = 0;
};
using VrmlNodesLeftOut = std::map<std::string, VrmlLeftOut>;

// Replaces a number that is not finite, which the library would refuse. It is a float whose
// magnitude is larger than coordinates may have.
inline constexpr const char* vrmlNotFinite = "-3.4028230607370965e38";

// The beginning of file names that cannot exist.
inline constexpr const char* vrmlUrlBegin = "/dev/null/";

struct VrmlText
{
  bool isFirst = false; // VRML 1.0, else 2.0
  // The same scene, rewritten for the library. Line numbers stay the same.
  // - Comments, ROUTEs (nothing is animated here), unknown fields and the content of textures
  //   become blanks; unknown nodes become empty groups.
  // - Strings become empty, so that none names a file. The URL of an Inline becomes vrmlUrlBegin
  //   followed by its number in `urls`.
  // - Decimal commas become points (VrmlCommas.h), and D in exponents becomes e. If coordinates of
  //   points, or heights, are not finite ("nan", "1.#IND"), they become vrmlNotFinite.
  // - Names are replaced by ones that the library accepts.
  std::string text;
  std::vector<VrmlUrl> urls;
  bool floatsSuffice = true; // floats keep the decimals of points and heights distinct
  bool hasPictures = false;  // there are nodes of textures
  VrmlNodesLeftOut leftOut{};
  // Counts zeros and Ctrl-Z at the end, and unknown fields: both are left out.
  Tolerance tolerance{};
};

// Reads the text once. library: the nodes and fields that the library knows, of VRML 1 (isFirst)
// and VRML 2. Errors: InvalidInput naming the line, for:
// - another format or version;
// - brackets that do not match, or are nested deeper than 400 levels, or deeper than 1000 through
//   nodes that are used again;
// - a string that does not end; control characters;
// - a node that contains itself (USE within its DEF, a PROTO within its body).
//
// LimitExceeded if PROTOs make more than a million nodes.
struct VrmlLibrary
{
  std::function<bool(const std::string& type, bool isFirst)> isNode;
  std::function<bool(const std::string& type, const std::string& field, bool isFirst)> hasField;
  // How many floats a value of the field has; 0 for fields of other types.
  std::function<std::size_t(const std::string& type, const std::string& field, bool isFirst)>
    widthOf;
  // In VRML 2: whether nodes of this type hold other nodes without naming a field, as Inventor's
  // do.
  std::function<bool(const std::string& type)> holdsNodes;
};
Result<VrmlText> CheckVrmlText(std::string_view file, const VrmlLibrary& library);

}
