// The header fields by which a client asks for less than the whole: ETags, byte ranges and content
// codings (RFC 9110).
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

namespace kdstream
{

// Whether an If-None-Match field (a list of tags, or "*") names `tag`, which is quoted. Weak
// comparison.
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

// What a Range field asks of a body of `size` bytes: one range of bytes is answered; several,
// another unit and what cannot be understood give the whole, as the standard allows.
RangeAnswer ParseRange(std::string_view range, std::size_t size);

// Whether an Accept-Encoding field (12.5.3) takes gzip at least as gladly as no coding: gzip,
// x-gzip or * with a quality above 0 and not below that of identity, if that is named. Elements
// that cannot be understood are passed over. An empty or absent field names nothing: no.
bool AcceptsGzip(std::string_view acceptEncoding);

}
