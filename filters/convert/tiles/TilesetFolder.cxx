// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/tiles/TilesetFolder.h"

#include "filters/core/CaughtError.h"
#include "filters/core/Texts.h"

#include <algorithm>
#include <fstream>
#include <system_error>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

bool LiesIn(const fs::path& folder, const fs::path& file)
{
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

// Whether a URI begins like "http:", "data:" or "C:".
bool HasScheme(const std::string& uri)
{
  const std::size_t colon = uri.find(':');
  return colon != std::string::npos && uri.find_first_of("/?#") > colon;
}

Error CannotFollow(const std::string& uri, const std::string& why, Remedy remedy)
{
  return BadInput("names " + Quoted(uri) + ", which " + why, remedy);
}

}

Result<TilesetFolder> TilesetFolder::Open(const fs::path& tileset)
{
  TilesetFolder opened;
  opened.Folder = tileset.has_parent_path() ? tileset.parent_path() : fs::path(".");
  std::error_code failed;
  opened.Real = fs::canonical(opened.Folder, failed);
  return failed ? Result<TilesetFolder>(Error{
                    ErrorCode::InputOutput, "its folder cannot be read: " + failed.message() })
                : opened;
}

Result<fs::path> TilesetFolder::Find(const fs::path& by, const std::string& uri) const
{
  if (HasScheme(uri))
  {
    return CannotFollow(uri,
      "is a web address, and nothing is downloaded: download it yourself, together with the "
      "tileset",
      Remedy::InMessage);
  }
  const std::string path = uri.substr(0, uri.find_first_of("?#"));
  const std::string outside = "is outside the tileset's folder, and nothing is read there";
  for (const std::string& written : { PercentDecoded(path).value_or(path), path, uri })
  {
    const fs::path below = (by.parent_path() / written).lexically_normal();
    if (written.empty() || written.find('\0') != std::string::npos)
    {
      continue;
    }
    if (below.is_absolute() || *below.begin() == ".." || written.front() == '\\')
    {
      return CannotFollow(uri, outside, Remedy::Repair);
    }
    std::error_code failed;
    if (!fs::is_regular_file(this->Folder / below, failed))
    {
      continue;
    }
    const fs::path real = fs::canonical(this->Folder / below, failed);
    return !failed && LiesIn(this->Real, real)
             ? Result<fs::path>(below)
             : CannotFollow(
                 uri, "is a link that leads out of the tileset's folder", Remedy::Repair);
  }
  return CannotFollow(uri, "is not there", Remedy::CopyAgain);
}

Result<std::string> ReadTileText(const fs::path& file, std::uint64_t most)
{
  std::ifstream input(file, std::ios::binary);
  std::error_code failed;
  const std::uintmax_t bytes = fs::file_size(file, failed);
  if (failed || !input)
  {
    return Error{ ErrorCode::InputOutput, "cannot be read" };
  }
  if (bytes > most)
  {
    return Error{ ErrorCode::LimitExceeded,
      "has " + std::to_string(bytes) + " bytes; at most " + std::to_string(most) + " are read" };
  }
  std::string text(static_cast<std::size_t>(bytes), ' ');
  return input.read(text.data(), static_cast<std::streamsize>(bytes))
           ? Result<std::string>(std::move(text))
           : Error{ ErrorCode::InputOutput, "cannot be read" };
}

Result<nlohmann::json> ParseTileJson(std::string_view text)
{
  try
  {
    const std::size_t end = text.find_last_not_of(std::string_view("\x1A\0 \t\r\n", 6));
    text = text.substr(0, end + 1);
    nlohmann::json json = nlohmann::json::parse(text.begin(), text.end());
    return json.is_object() ? Result<nlohmann::json>(std::move(json))
                            : BadInput("its JSON is not an object", Remedy::Unknown);
  }
  catch (const nlohmann::json::parse_error& failure)
  {
    const std::size_t at = failure.byte > 0 ? failure.byte - 1 : 0;
    return at >= text.size()
             ? BadInput("its JSON breaks off at byte " + std::to_string(at), Remedy::CopyAgain)
             : BadInput("its JSON is damaged at byte " + std::to_string(at), Remedy::Unknown);
  }
  catch (const nlohmann::json::exception&) // for numbers such as 1e999
  {
    return BadInput("its JSON has a number that is too large to be read", Remedy::Unknown);
  }
  catch (...)
  {
    return CaughtError();
  }
}

std::uint64_t NumberInTile(std::string_view bytes, std::size_t at, std::size_t size)
{
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i)
  {
    value |= std::uint64_t{ static_cast<unsigned char>(bytes[at + i]) } << (8 * i);
  }
  return value;
}

}
