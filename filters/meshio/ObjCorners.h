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

// Of places, texture coordinates and normals.
using ObjCounts = std::array<std::uint64_t, 3>;

// "face 0 (line 5)": what the statements stand at.
std::string PlaceInObj(const char* element, std::uint64_t index, const ObjStatements& statements);
// Puts the place before the error's message, if the error is about the input.
Error AtPlaceInObj(const std::string& place, const Error& error);

class ObjCorners
{
public:
  // Numbers of place, texture coordinate and normal, from 1 on; 0: none.
  using Corner = std::array<std::uint32_t, 3>;

  // Takes the corners of the current face of `statements`, the file's face number `face`. before:
  // how many positions, texture coordinates and normals come before it; all: how many are in the
  // file. If a corner names a texture coordinate (or normal) that does not exist, no corner of the
  // face has any, and `tolerance` counts this. A face may have fewer than three corners.
  // O(corners). Errors: InvalidInput for a place that does not exist, and for what is not a number.
  Status Read(const ObjStatements& statements, const ObjCounts& before, const ObjCounts& all,
    std::uint64_t face, Tolerance& tolerance);
  // Valid until the next call.
  std::span<const Corner> Get() const { return this->Corners; }

private:
  std::vector<Corner> Corners;
};

// Counts the face that `statements` stand at, with its place if it is the first of the kind.
void ForgiveObjFace(
  Lapse kind, std::uint64_t face, const ObjStatements& statements, Tolerance& tolerance);

}
