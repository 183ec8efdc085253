// SPDX-License-Identifier: BSD-3-Clause
// Fonts for the window's texts: see InterfaceLayer.h.
#include "viewer/desktop/window/InterfaceLayer.h"

#include <fontconfig/fontconfig.h>
#include <imgui.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace kdstream
{
namespace
{

constexpr int mostFonts = 8; // each adds letters that the previous fonts lack

struct FontFile
{
  std::string file;
  int index = 0;
  std::set<char32_t> letters; // requested letters that the font has
};

template <auto destroy>
struct Destroy
{
  template <class T>
  void operator()(T* object) const
  {
    destroy(object);
  }
};
using PatternOwner = std::unique_ptr<FcPattern, Destroy<FcPatternDestroy>>;
using LettersOwner = std::unique_ptr<FcCharSet, Destroy<FcCharSetDestroy>>;

// Finds the sans serif font that has most of these letters. If none is found, the file is empty.
FontFile FindFont(const std::set<char32_t>& letters)
{
  const LettersOwner wanted(FcCharSetCreate());
  for (const char32_t letter : letters)
  {
    FcCharSetAddChar(wanted.get(), letter);
  }
  const PatternOwner pattern(FcPatternCreate());
  FcPatternAddString(pattern.get(), FC_FAMILY, reinterpret_cast<const FcChar8*>("sans-serif"));
  FcPatternAddBool(pattern.get(), FC_SCALABLE, FcTrue);
  FcPatternAddCharSet(pattern.get(), FC_CHARSET, wanted.get());
  FcConfigSubstitute(nullptr, pattern.get(), FcMatchPattern);
  FcDefaultSubstitute(pattern.get());
  FcResult result = FcResultNoMatch;
  const PatternOwner font(FcFontMatch(nullptr, pattern.get(), &result));
  FontFile found;
  FcChar8* file = nullptr;
  FcCharSet* has = nullptr;
  if (!font || FcPatternGetString(font.get(), FC_FILE, 0, &file) != FcResultMatch ||
      FcPatternGetCharSet(font.get(), FC_CHARSET, 0, &has) != FcResultMatch)
  {
    return found;
  }
  FcPatternGetInteger(font.get(), FC_INDEX, 0, &found.index);
  std::error_code failure;
  const std::string name = reinterpret_cast<const char*>(file);
  if (std::filesystem::is_regular_file(name, failure))
  {
    found.file = name;
  }
  for (const char32_t letter : letters)
  {
    if (FcCharSetHasChar(has, letter))
    {
      found.letters.insert(letter);
    }
  }
  return found;
}

// Letters as ranges, in the form that ImGui expects. They must live as long as the atlas.
const ImWchar* RangesOf(const std::set<char32_t>& letters)
{
  static std::vector<std::unique_ptr<ImVector<ImWchar>>> kept;
  ImFontGlyphRangesBuilder builder;
  for (const char32_t letter : letters)
  {
    builder.AddChar(static_cast<ImWchar>(letter));
  }
  kept.push_back(std::make_unique<ImVector<ImWchar>>());
  builder.BuildRanges(kept.back().get());
  return kept.back()->Data;
}

}

std::set<char32_t> LettersOf(std::string_view text)
{
  std::set<char32_t> letters;
  for (std::size_t i = 0; i < text.size();)
  {
    const auto first = static_cast<unsigned char>(text[i]);
    const std::size_t length = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    char32_t letter = length == 1 ? first : first & (0x7fu >> length);
    for (std::size_t k = 1; k < length && i + k < text.size(); ++k)
    {
      letter = letter << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3fu);
    }
    if (letter >= 0x20 && letter <= 0xffff)
    {
      letters.insert(letter);
    }
    i += length;
  }
  return letters;
}

void LoadFonts(ImFontAtlas& atlas, double height, const std::set<char32_t>& letters)
{
  atlas.Clear();
  std::set<char32_t> missing = letters;
  for (int i = 0; i < mostFonts && !missing.empty(); ++i)
  {
    const FontFile font = FindFont(missing);
    if (font.file.empty() || font.letters.empty())
    {
      break;
    }
    ImFontConfig config;
    config.MergeMode = i > 0;
    config.FontNo = font.index;
    if (!atlas.AddFontFromFileTTF(
          font.file.c_str(), static_cast<float>(height), &config, RangesOf(font.letters)))
    {
      break;
    }
    for (const char32_t letter : font.letters)
    {
      missing.erase(letter);
    }
  }
  if (atlas.Fonts.empty())
  {
    atlas.AddFontDefault();
  }
}

}
