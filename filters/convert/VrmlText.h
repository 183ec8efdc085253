// SPDX-License-Identifier: BSD-3-Clause
// Checks the text of a VRML file and makes it harmless, before a library parses it. Part of step
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

// A file that an Inline names.
struct VrmlUrl
{
  std::string url;
  std::uint64_t line = 0;
};

// The nodes of one kind that are left out: which and why ("'Knob', which VRML does not have"), how
// many, and the line of the first (0: unknown).
struct VrmlLeftOut
{
  std::uint64_t count = 0, line = 0;
};
using VrmlNodesLeftOut = std::map<std::string, VrmlLeftOut>;

// Written in place of a number that is not finite, which the library would refuse: a float larger
// than coordinates may be.
inline constexpr const char* vrmlNotFinite = "-3.4028230607370965e38";

// The beginning of names that no file can have.
inline constexpr const char* vrmlUrlBegin = "/dev/null/";

struct VrmlText
{
  bool isFirst = false; // VRML 1.0, else 2.0
  // The same scene for the library. Lines stay where they are.
  // - Comments, ROUTEs (nothing is animated here), unknown fields and the content of textures
  //   become blanks; unknown nodes become empty groups.
  // - Strings become empty, so that none names a file. The URL of an Inline becomes vrmlUrlBegin
  //   and a number of `urls`.
  // - Numbers have points instead of decimal commas (VrmlCommas.h), and e instead of D in
  //   exponents. Coordinates of points and heights that are not finite ("nan", "1.#IND") become
  //   vrmlNotFinite.
  // - Names are replaced by ones that the library accepts.
  std::string text;
  std::vector<VrmlUrl> urls;
  bool floatsSuffice = true; // for the decimals of points and heights
  bool hasPictures = false;  // nodes of textures
  VrmlNodesLeftOut leftOut{};
  // Zeros and Ctrl-Z at the end, and fields that are not known: both are left out.
  Tolerance tolerance{};
};

// Reads the text once. library: the nodes and fields that it knows, of VRML 1 (isFirst) and 2.
// Errors: InvalidInput naming the line, for:
// - another format or version;
// - brackets that do not match, are nested deeper than 400, or deeper than 1000 where nodes are
//   used again;
// - a string without end; control characters;
// - a node that contains itself (USE within its DEF, a PROTO within its body).
//
// LimitExceeded for more than a million nodes that PROTOs make.
struct VrmlLibrary
{
  std::function<bool(const std::string& type, bool isFirst)> isNode;
  std::function<bool(const std::string& type, const std::string& field, bool isFirst)> hasField;
  // How many floats a value of the field has; 0 for fields of other types.
  std::function<std::size_t(const std::string& type, const std::string& field, bool isFirst)>
    widthOf;
  // In VRML 2: whether nodes of the type hold others without a field, as Inventor's do.
  std::function<bool(const std::string& type)> holdsNodes;
};
Result<VrmlText> CheckVrmlText(std::string_view file, const VrmlLibrary& library);

}
