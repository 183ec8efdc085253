// SPDX-License-Identifier: BSD-3-Clause
// The options of textures, which kdstream-build and kdstream-convert share.
#pragma once

#include "filters/program/Program.h"
#include "filters/texture/BakeTextures.h"

#include <string>

namespace kdstream
{

// --textures on|off and --texture-pixels N. Keeps references.
inline void AddTextureOptions(CLI::App& app, std::string& textures, std::uint64_t& pixels)
{
  app
    .add_option("--textures", textures,
      "bake pictures to the colours of vertices, or leave them out; the whole mesh is in memory "
      "while they are baked")
    ->check(CLI::IsMember({ "on", "off" }))
    ->capture_default_str()
    ->group("Input");
  app
    .add_option(
      "--texture-pixels", pixels, "the most pixels of a picture; one that has more is left out")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 36))
    ->capture_default_str()
    ->group("Input");
}

}
