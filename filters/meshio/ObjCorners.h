// SPDX-License-Identifier: BSD-3-Clause
// Reads the corners of an OBJ file's faces, for all readers of its statements: the place, texture
// coordinate and normal of each corner. Defines which errors are tolerated and which are refused.
// Part of step "read".
#pragma once

#include "filters/core/Result.h"
#include "filters/meshio/ObjStatements.h"
#include "filters/meshio/Tolerance.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

// The numbers of places, texture coordinates and normals.
using ObjCounts = std::array<std::uint64_t, 3>;

// Names an element and its line, at which `statements` stand: "face 0 (line 5)".
std::string PlaceInObj(const char* element, std::uint64_t index, const ObjStatements& statements);
// Puts the place before the error's message, if the error is about the input.
Error AtPlaceInObj(const std::string& place, const Error& error);

class ObjCorners
{
public:
  // The numbers of the place, texture coordinate and normal, counted from 1; 0 if there is none.
  using Corner = std::array<std::uint32_t, 3>;

  // Takes the corners of the current face of `statements`. face: the number of this face in the
  // file. before: how many places, texture coordinates and normals come before it; all: how many
  // are in the file. If a corner names a texture coordinate (or normal) that does not exist, no
  // corner of the face has one, and `tolerance` counts this. A face may have fewer than three
  // corners. O(corners). Errors: InvalidInput for a place that does not exist, and for text that is
  // not a number.
  Status Read(const ObjStatements& statements, const ObjCounts& before, const ObjCounts& all,
    std::uint64_t face, Tolerance& tolerance);
  // Valid until the next call.
  std::span<const Corner> Get() const { return this->Corners; }

private:
  std::vector<Corner> Corners;
};

// Counts the face at which `statements` stand. If it is the first of its kind, its place is kept.
void ForgiveObjFace(
  Lapse kind, std::uint64_t face, const ObjStatements& statements, Tolerance& tolerance);

}
