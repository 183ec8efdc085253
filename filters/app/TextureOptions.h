// SPDX-License-Identifier: BSD-3-Clause
// Options for textures, which kdstream-build and kdstream-convert share.
#pragma once

#include "filters/program/Program.h"
#include "filters/texture/BakeTextures.h"

#include <string>
#include <vector>

namespace kdstream
{

// Adds --textures, which takes these values, and --texture-pixels N. Keeps references.
inline void AddTextureOptions(CLI::App& app, const std::vector<std::string>& values,
  const std::string& help, std::string& textures, std::uint64_t& pixels)
{
  app.add_option("--textures", textures, help)
    ->check(CLI::IsMember(values))
    ->capture_default_str()
    ->group("Input");
  app
    .add_option("--texture-pixels", pixels, "maximum pixels of a texture; larger ones are left out")
    ->check(CLI::Range(std::uint64_t{ 1 }, std::uint64_t{ 1 } << 36))
    ->capture_default_str()
    ->group("Input");
}

// Checks that --texture-pixels is given only if there are pictures to limit. Errors:
// InvalidArgument.
inline Status CheckTexturePixels(const CLI::App& app, const std::string& textures)
{
  return FindOption(app, "--texture-pixels")->count() > 0 && textures == "off"
           ? Status(Error{ ErrorCode::InvalidArgument,
               "--texture-pixels has no effect with --textures off: no textures are read" })
           : Status{};
}

}
