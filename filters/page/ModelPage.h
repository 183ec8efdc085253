// SPDX-License-Identifier: BSD-3-Clause
// The viewer's page for one model: the same page, with a head for messengers and search engines,
// and with texts for people without scripts. Texts of models are untrusted: all are escaped.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/page/PagePlace.h"

#include <span>
#include <string>
#include <string_view>

namespace kdstream
{

// The texts about a model, without a picture.
struct ModelTexts
{
  std::string title; // its title; if it has none, its id
  // The beginning of its description, its author, and its size; if nothing of this is known, the
  // number of triangles. At most about 500 bytes.
  std::string summary;
  // "19.8 × 14 × 8.9 cm", in a metric unit that is easy to read; empty if the model has no unit.
  std::string size;
  std::string count; // "871,414 triangles"
};
ModelTexts TextsOf(const ModelDescription& model);

// `page` is the viewer's index.html. Its title is replaced by the model's head: title, description,
// canonical address, OpenGraph, Twitter card, JSON-LD of a 3DModel, and oEmbed if the root is
// known. Its <noscript> gets the model's texts. Its relative addresses then begin with place.up. If
// the page has no title or <noscript>, they are inserted into its head and body. site: the title of
// the site, may be empty. O(bytes).
std::string MakeModelPage(std::string_view page, const ModelDescription& model,
  const PagePlace& place, const std::string& site);

// The page of all models, m/: with scripts it shows the viewer's own list, without them a link to
// each model.
std::string MakeListPage(std::string_view page, std::span<const ModelSummary> models,
  const PagePlace& place, const SiteDescription& site);

// The addresses of all pages, for search engines (https://www.sitemaps.org). REQUIRES: place.root
// is known.
std::string WriteSitemap(std::span<const ModelSummary> models, const PagePlace& place);

// The page for a model that cannot be shown. It gives the reason, for people and robots. With
// scripts the viewer gives the reason, and shows the other models.
std::string MakeRefusalPage(std::string_view page, const std::string& title,
  const std::string& text, const PagePlace& place, const std::string& site);

}
