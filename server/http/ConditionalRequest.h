// SPDX-License-Identifier: BSD-3-Clause
// The header fields by which a client asks for less than the whole answer: ETags, byte ranges and
// content codings (RFC 9110).
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

namespace kdstream
{

// Whether an If-None-Match field (a list of tags, or "*") names `tag`, which includes its quotes.
// Tags are compared weakly.
bool NamesTag(std::string_view ifNoneMatch, std::string_view tag);

struct WholeRange
{
};
struct UnsatisfiableRange
{
};
struct PartialRange
{
  std::size_t begin = 0;
  std::size_t length = 0; // at least 1
};
using RangeAnswer = std::variant<WholeRange, UnsatisfiableRange, PartialRange>;

// The part of a body of `size` bytes that a Range field asks for. Only a single range of bytes is
// honoured; several ranges, another unit, or a malformed field give the whole body, as the standard
// allows.
RangeAnswer ParseRange(std::string_view range, std::size_t size);

// Whether an Accept-Encoding field (12.5.3) rates gzip at least as high as no coding: gzip, x-gzip
// or * has a quality above 0, and not below that of identity if identity is named. Malformed
// elements are skipped. False for an empty or absent field.
bool AcceptsGzip(std::string_view acceptEncoding);

}
