// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/ConvertForBuild.h"

#include "filters/meshio/FileEnding.h"
#include "filters/texture/Picture.h"

#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace kdstream
{

Result<ConvertedInput> ConvertForBuild(
  BuildCommand& line, const std::filesystem::path& folder, const Execution& execution)
{
  std::vector<std::string> arguments;
  if (!line.reconstruct.empty())
  {
    arguments = { "--reconstruct", line.reconstruct };
  }
  if (line.textures == "off")
  {
    arguments.push_back("--textures=off");
  }
  if (line.texturePixels != mostPicturePixels)
  {
    arguments.push_back("--texture-pixels=" + std::to_string(line.texturePixels));
  }
  if (!line.columns.empty())
  {
    arguments.push_back("--columns=" + line.columns);
  }
  std::vector<std::string> more = arguments; // arguments that do not change the result
  if (line.build.strict)
  {
    more.push_back("--strict");
  }
  if (line.threads > 0)
  {
    more.push_back("--threads=" + std::to_string(line.threads));
  }
  Result<ConvertedInput> converted =
    ConvertedInput::Make(line.input, folder, more, line.WantsTiles(), execution);
  KDSTREAM_TRY(converted);
  line.baked = converted->Baked();
  line.build.inputName = std::filesystem::path(line.input).filename().string();
  line.build.convertedFrom = line.input;
  line.build.convertedWith = converted->Named();
  line.build.inputFiles = { line.input };
  const std::string ending = FileEnding(line.input);
  for (const std::filesystem::path& named : converted->Named())
  {
    // The mesh of a glTF is in its buffers, and not in its pictures and materials. A file that is
    // missing, or is elsewhere, was not read, so it can only be a picture.
    std::error_code failure;
    if ((ending == ".gltf" || ending == ".glb" || ending == ".json") &&
        TypeOfName(named.string()) == PictureType::Unknown &&
        std::filesystem::is_regular_file(named, failure))
    {
      line.build.inputFiles.push_back(named);
    }
  }
  for (const std::string& argument : arguments)
  {
    line.build.convertedBy += argument + " ";
  }
  return converted;
}

Result<std::shared_ptr<const TiledTextures>> KeepTextures(
  BuildCommand& line, const std::filesystem::path& textureFolder)
{
  const auto textureSet = TextureFolder::Open(textureFolder);
  KDSTREAM_TRY(textureSet);
  auto textures = std::make_shared<const TiledTextures>(*textureSet, line.tiles);
  line.build.textures = textures;
  line.build.convertedBy += "--texture-quality=" + line.textureQuality;
  return std::shared_ptr<const TiledTextures>(std::move(textures));
}

}
