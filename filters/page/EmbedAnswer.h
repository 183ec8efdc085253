// SPDX-License-Identifier: BSD-3-Clause
// oEmbed 1.0 (https://oembed.com): how other people's pages embed a model.
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

// Parses the query of a URL, without its "?"; unknown members are skipped. Errors: InvalidArgument,
// naming the member; Unsupported for a format other than json.
Result<EmbedRequest> ParseEmbedQuery(std::string_view query);

// The frame is 800 by 600, or less if the request requires that. The thumbnail has only one size;
// it is omitted if that is too large. site: the server's title, may be empty. REQUIRES: place.root
// is known.
std::string WriteEmbedAnswer(const ModelDescription& model, const PagePlace& place,
  const std::string& site, const EmbedRequest& request = {});

}
