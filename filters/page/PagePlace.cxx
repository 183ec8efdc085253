// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/PagePlace.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"

#include <algorithm>

namespace kdstream
{

namespace
{

std::string_view WithoutScheme(std::string_view address)
{
  for (const std::string_view scheme : { "https://", "http://" })
  {
    if (address.substr(0, scheme.size()) == scheme)
    {
      return address.substr(scheme.size());
    }
  }
  return {};
}

bool IsPlainInAddress(char c)
{
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("-._~/:[]%").find(c) != std::string_view::npos;
}

}

std::string PagePlace::Page(std::string_view model) const
{
  return this->Base() + std::string(pagesFolder) + std::string(model) + (this->isFolder ? "/" : "");
}

std::string PagePlace::Picture(std::string_view model) const
{
  return this->Base() + std::string(pagesFolder) + std::string(model) + "/picture.jpg";
}

std::string PagePlace::Manifest(std::string_view model) const
{
  return this->Base() + std::string(pagesFolder) + std::string(model) + "/manifest.json";
}

std::string PagePlace::Preview(std::string_view model, std::string_view digest) const
{
  return this->Base() + "api/models/" + std::string(model) + "/" + std::string(digest) +
         "/preview.glb";
}

std::string PagePlace::Embed(std::string_view model) const
{
  return this->isFolder ? this->Page(model) + "oembed.json"
                        : this->root + "oembed?url=" + PercentEncoded(this->Page(model), "-._~");
}

bool IsPageRoot(std::string_view text)
{
  const auto rest = WithoutScheme(text);
  return !rest.empty() && rest.front() != '/' && rest.front() != ':' &&
         std::all_of(rest.begin(), rest.end(), IsPlainInAddress);
}

std::string ModelOfAddress(std::string_view address, std::string_view root)
{
  auto rest = WithoutScheme(address);
  const auto own = WithoutScheme(root);
  if (own.empty() || rest.substr(0, own.size()) != own)
  {
    return {};
  }
  rest.remove_prefix(own.size());
  const auto hash = rest.find('#');
  const auto path = rest.substr(0, std::min(hash, rest.find('?')));
  std::string_view model;
  if (path.substr(0, pagesFolder.size()) == pagesFolder)
  {
    model = path.substr(pagesFolder.size());
    model = model.substr(0, model.size() - (model.ends_with('/') ? 1 : 0));
  }
  else if (path.empty() && hash != std::string_view::npos)
  {
    auto part = rest.substr(hash); // "#key=value&…"
    constexpr std::string_view key = "model=";
    for (std::size_t at = 0; at != std::string_view::npos; at = part.find('&', at + 1))
    {
      const auto member = part.substr(at + 1);
      if (member.substr(0, key.size()) == key)
      {
        model = member.substr(key.size(), member.find('&') - key.size());
        break;
      }
    }
  }
  const auto plain = PercentDecoded(model);
  return plain && IsModelId(*plain) ? *plain : std::string();
}

}
