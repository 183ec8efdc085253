// SPDX-License-Identifier: BSD-3-Clause
// Puts untrusted texts into HTML and scripts: titles and credits never become markup.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kdstream
{

// Escapes a text for the content of an element, or for an attribute in double quotes. Bytes that
// are not UTF-8, and control characters, become U+FFFD; line breaks and tabs stay.
std::string HtmlEscaped(std::string_view text);

// Escapes JSON for a <script> of the page: no "<" is left, so it contains neither "</script>" nor
// "<!--".
std::string ScriptEscaped(std::string_view json);

// At most this number of bytes of the text, cut between characters; "…" is added if something was
// cut off.
std::string Shortened(std::string_view text, std::size_t bytes);

// Removes Unicode's bidirectional embeddings, overrides and isolates, which could reverse the text
// that follows. Marks (LRM, RLM, ALM) stay.
std::string WithoutDirections(std::string_view text);

// Whether the text is a web address that may become a link: http or https, without spaces.
bool IsWebAddress(std::string_view text);

}
