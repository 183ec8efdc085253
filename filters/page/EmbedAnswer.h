// SPDX-License-Identifier: BSD-3-Clause
// oEmbed 1.0 (https://oembed.com): how a page of somebody else embeds a model.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "filters/page/PagePlace.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace kdstream
{

struct EmbedRequest
{
  std::string url;
  std::optional<unsigned> maximumWidth, maximumHeight; // in pixels, at least 1
};

// The query of a URL, without its "?"; members that are not known are skipped. Errors:
// InvalidArgument naming the member; Unsupported for another format than json.
Result<EmbedRequest> ParseEmbedQuery(std::string_view query);

// The frame is 800 by 600, or what of it the request allows; the thumbnail, which has one size, is
// left out where that is too large. site: the server's title, may be empty. REQUIRES: the place's
// root is known.
std::string WriteEmbedAnswer(const ModelDescription& model, const PagePlace& place,
  const std::string& site, const EmbedRequest& request = {});

}
