// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/EmbedAnswer.h"

#include "filters/core/Texts.h"
#include "filters/model/JsonWriter.h"
#include "filters/page/ModelPage.h"
#include "filters/page/ModelPicture.h"
#include "filters/page/PageTexts.h"

#include <algorithm>
#include <charconv>

namespace kdstream
{

namespace
{

constexpr unsigned frameWidth = 800, frameHeight = 600;

std::optional<std::string> FormDecoded(std::string_view text)
{
  std::string blanks(text);
  std::replace(blanks.begin(), blanks.end(), '+', ' ');
  return PercentDecoded(blanks);
}

Status ReadPixels(const std::string& name, const std::string& text, std::optional<unsigned>& pixels)
{
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  const bool isTooLong = read.ec == std::errc::result_out_of_range; // then there is no limit
  if (read.ptr != end || (read.ec != std::errc() && !isTooLong) || (value == 0 && !isTooLong))
  {
    return Error{ ErrorCode::InvalidArgument, name + " is not a number of pixels" };
  }
  constexpr std::uint64_t most = 1u << 20;
  pixels = static_cast<unsigned>(isTooLong ? most : std::min(value, most));
  return {};
}

}

Result<EmbedRequest> ParseEmbedQuery(std::string_view query)
{
  EmbedRequest request;
  while (!query.empty())
  {
    const auto member = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), member.size() + 1));
    const auto equal = member.find('=');
    const auto name = member.substr(0, equal);
    const auto value =
      FormDecoded(equal == std::string_view::npos ? std::string_view() : member.substr(equal + 1));
    if (!value)
    {
      return Error{ ErrorCode::InvalidArgument,
        "a % in the query is not followed by two hexadecimal digits" };
    }
    if (name == "url")
    {
      request.url = *value;
    }
    else if (name == "maxwidth")
    {
      KDSTREAM_TRY(ReadPixels("maxwidth", *value, request.maximumWidth));
    }
    else if (name == "maxheight")
    {
      KDSTREAM_TRY(ReadPixels("maxheight", *value, request.maximumHeight));
    }
    else if (name == "format" && *value != "json")
    {
      return Error{ ErrorCode::Unsupported, "the only format is json" };
    }
  }
  return request;
}

std::string WriteEmbedAnswer(const ModelDescription& model, const PagePlace& place,
  const std::string& site, const EmbedRequest& request)
{
  const auto texts = TextsOf(model);
  const auto width = std::min(frameWidth, request.maximumWidth.value_or(frameWidth));
  const auto height = std::min(frameHeight, request.maximumHeight.value_or(frameHeight));
  const std::string frame = "<iframe src=\"" + HtmlEscaped(place.Page(model.id)) +
                            "?embed\" width=\"" + std::to_string(width) + "\" height=\"" +
                            std::to_string(height) + "\" title=\"" + HtmlEscaped(texts.title) +
                            "\" style=\"border:0\" loading=\"lazy\" allow=\"fullscreen; " +
                            "web-share; clipboard-write\" allowfullscreen></iframe>";
  JsonWriter json;
  json.BeginObject()
    .Member("version", "1.0")
    .Member("type", "rich")
    .Member("title", texts.title)
    .Member("provider_name", site.empty() ? std::string("KdStream") : site)
    .Member("provider_url", place.root)
    .Member("width", width)
    .Member("height", height)
    .Member("html", frame)
    .Member("cache_age", 3600);
  if (!model.credit.empty())
  {
    json.Member("author_name", WithoutDirections(model.credit));
  }
  if (HasPicture(model) && pictureWidth <= request.maximumWidth.value_or(pictureWidth) &&
      pictureHeight <= request.maximumHeight.value_or(pictureHeight))
  {
    json.Member("thumbnail_url", place.Picture(model.id))
      .Member("thumbnail_width", pictureWidth)
      .Member("thumbnail_height", pictureHeight);
  }
  json.EndObject();
  return json.Text();
}

}
