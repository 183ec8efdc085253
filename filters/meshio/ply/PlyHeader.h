// SPDX-License-Identifier: BSD-3-Clause
// The header of a PLY file: elements, their properties, and where the body begins. Part of step
// "read".
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Result.h"
#include "filters/meshio/ByteSource.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

enum class PlyEncoding
{
  Ascii,
  BinaryLittleEndian,
  BinaryBigEndian
};

// The name that our messages use: "int", "float", …
std::string_view PlyTypeName(AttributeType type);

struct PlyProperty
{
  std::string name;
  AttributeType type = AttributeType::Float32; // of the value, or of a list's items
  bool isList = false;
  AttributeType countType = AttributeType::UInt8; // lists only
};

struct PlyElement
{
  std::string name;
  std::uint64_t count = 0; // a claim, like everything in a header
  std::vector<PlyProperty> properties;

  // The number of the first property with this name; properties.size() if there is none.
  std::size_t Find(std::string_view property) const;
  // The number of the list with a face's corners: found by its name, else the only list of
  // integers.
  std::size_t FindCorners() const;
};

// Whether a list with this name has a face's corners: vertex_indices, vertex_index or
// vertex_indexes, in any case.
bool IsNameOfCorners(std::string_view property);

struct PlyHeader
{
  PlyEncoding encoding = PlyEncoding::Ascii;
  bool hasComments = false; // whether # begins a comment in the body (OffHeader.h)
  // A line before the elements that is not part of the format and does not end with a number:
  // "'Created' (header line 3)"; empty if there is none.
  std::string strayLine{};
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;     // names in "comment TextureFile" lines, quoted
  std::vector<std::string> textureFiles; // the same as the file has them, with blanks
};

// Reads the header and leaves `source` at the first byte of the body. Lines may end in LF, CRLF or
// CR. "comment" and "obj_info" lines are skipped. Both families of type names are known ("uchar"
// and "uint8"), and also int64 and uint64, which other programs have added to the format. The
// elements "vertex", "face" and "tristrips" may be written in capitals, and become lower case. If
// two properties have the same name, the first counts (Find). Errors: InvalidInput naming the line:
// not a PLY file, no end_header in the first MiB, an unknown word or type, a count that is not a
// number below 2^64, two elements of the same name.
Result<PlyHeader> ReadPlyHeader(ByteSource& source);

}
