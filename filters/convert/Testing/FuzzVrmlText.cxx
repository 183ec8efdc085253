// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the check of VRML text before Coin parses it, also for text compressed by
// gzip: ./dev fuzz.
#include "filters/convert/UnpackGzip.h"
#include "filters/convert/VrmlText.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>

namespace
{

using namespace kdstream;

void Require(bool holds)
{
  if (!holds)
  {
    std::abort();
  }
}

// A string must not name a file, except one of `urls` by its number.
void CheckString(std::string_view text, std::size_t urls)
{
  if (text.empty())
  {
    return;
  }
  Require(text.starts_with(vrmlUrlBegin));
  text.remove_prefix(std::strlen(vrmlUrlBegin));
  std::size_t number = 0;
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
  Require(parsed.ptr == text.data() + text.size() && number < urls);
}

void CheckText(std::string_view file)
{
  const Result<VrmlText> read =
    CheckVrmlText(file, { [](const std::string& type, bool)
                          { return type == "Shape" || type == "Group" || type == "Inline"; },
                          [](const std::string&, const std::string& field, bool)
                          { return field == "children" || field == "url" || field == "geometry"; },
                          [](const std::string&, const std::string& field, bool)
                          { return std::size_t{ field == "point" ? 3U : 0U }; },
                          [](const std::string& type) { return type == "Group"; } });
  if (!read)
  {
    Require(!read.GetError().message.empty());
    return;
  }
  const std::string_view text = read->text;
  Require(text.starts_with("#VRML V"));
  const auto lines = [](std::string_view of)
  { return std::count(of.begin(), of.end(), '\n') + std::count(of.begin(), of.end(), '\r'); };
  Require(lines(text) <= lines(file) + 1);
  // After the header, strings and brackets must end, and there must be no comments.
  std::string open;
  for (std::size_t at = text.find('\n'); at < text.size(); ++at)
  {
    const char c = text[at];
    Require(c != '#' && c != '\x7f' && (c >= ' ' || c < 0 || c == '\n' || c == '\t'));
    if (c == '"')
    {
      const std::size_t end = text.find('"', at + 1);
      Require(end != std::string_view::npos);
      CheckString(text.substr(at + 1, end - at - 1), read->urls.size());
      at = end;
    }
    else if (c == '{' || c == '[')
    {
      open += c == '{' ? '}' : ']';
    }
    else if (c == '}' || c == ']')
    {
      Require(!open.empty() && open.back() == c);
      open.pop_back();
    }
  }
  Require(open.empty());
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  if (!IsGzip(file))
  {
    CheckText(file);
    return 0;
  }
  constexpr std::uint64_t most = 1 << 20;
  const Result<UnpackedText> unpacked = UnpackGzip(file, most);
  Require(unpacked ? unpacked->text.size() <= most && unpacked->bytesAfter <= size
                   : !unpacked.GetError().message.empty());
  if (unpacked)
  {
    CheckText(unpacked->text);
  }
  return 0;
}
