// SPDX-License-Identifier: BSD-3-Clause
// Texts of strangers in HTML and in scripts: titles and credits never become markup.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kdstream
{

// The text for an element's content, and for an attribute in double quotes. What is not UTF-8, and
// control characters, become U+FFFD; line ends and tabs stay.
std::string HtmlEscaped(std::string_view text);

// JSON for a <script> of the page: no "<" is left, so neither "</script>" nor "<!--".
std::string ScriptEscaped(std::string_view json);

// At most this number of bytes, cut between characters, with "…" where something is cut off.
std::string Shortened(std::string_view text, std::size_t bytes);

// The text without the bidirectional embeddings, overrides and isolates of Unicode, which would
// turn round what follows it in a sentence. Marks (LRM, RLM, ALM) stay.
std::string WithoutDirections(std::string_view text);

// Whether the text is an address of the web, which may be linked: http or https, without blanks.
bool IsWebAddress(std::string_view text);

}
