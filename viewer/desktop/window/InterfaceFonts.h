// SPDX-License-Identifier: BSD-3-Clause
// The letters of the window's words: the desktop's fonts, by fontconfig.
#pragma once

#include <set>
#include <string>
#include <string_view>

struct ImFontAtlas;

namespace kdstream
{

// The code points of a UTF-8 text; what is no UTF-8 is passed over.
std::set<char32_t> LettersOf(std::string_view text);

// Fills the atlas with the desktop's sans serif font, of this height in pixels, and with other
// fonts that have the missing `letters`. Where the desktop has no font: the library's own small
// one.
void LoadFonts(ImFontAtlas& atlas, double height, const std::set<char32_t>& letters);

}
