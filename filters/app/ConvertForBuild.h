// SPDX-License-Identifier: BSD-3-Clause
// An input that kdstream-convert reads for a build: for kdstream-build and kdstream-build-mpi. Step
// "read" of the pipeline picture.
#pragma once

#include "filters/app/BuildCommand.h"
#include "filters/app/ConvertedInput.h"
#include "filters/app/TiledTextures.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <filesystem>
#include <memory>

namespace kdstream
{

// Converts line.input into a new folder in `folder`. Sets line.baked, and the members of line.build
// that describe the input. REQUIRES: line.converts. Errors: those of ConvertedInput::Make.
Result<ConvertedInput> ConvertForBuild(
  BuildCommand& line, const std::filesystem::path& folder, const Execution& execution);

// Prepares to make textures from the pictures that a conversion has left in this folder: sets
// line.build.textures. Errors: those of TextureFolder::Open.
Result<std::shared_ptr<const TiledTextures>> KeepTextures(
  BuildCommand& line, const std::filesystem::path& textureFolder);

}
