// SPDX-License-Identifier: BSD-3-Clause
// The viewer's page for one model: the same page, with a head that messengers and search engines
// read, and with texts for whoever runs no scripts. Texts of models are untrusted: all are escaped.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/page/PagePlace.h"

#include <span>
#include <string>
#include <string_view>

namespace kdstream
{

// What is said of a model without a picture.
struct ModelTexts
{
  std::string title;   // its own, else its id
  std::string summary; // the begin of its description, who made it, how large it is; where nothing
                       // of this is known, how many triangles: at most about 500 bytes
  std::string size;  // "19.8 × 14 × 8.9 cm", in a unit of metres that is read easily; empty where
                     // it has no unit
  std::string count; // "871,414 triangles"
};
ModelTexts TextsOf(const ModelDescription& model);

// `page` is the viewer's index.html. Its title becomes the model's head: description, canonical
// address, OpenGraph, Twitter card, JSON-LD of a 3DModel, and oEmbed if the root is known. Its
// <noscript> gets the model's texts. Its relative addresses then begin with place.up. A page
// without a title or <noscript> gets them in its head and body. site: its title, may be empty.
// O(bytes).
std::string MakeModelPage(std::string_view page, const ModelDescription& model,
  const PagePlace& place, const std::string& site);

// The page of all models, m/: with scripts the viewer's own list; without them links to each.
std::string MakeListPage(std::string_view page, std::span<const ModelSummary> models,
  const PagePlace& place, const SiteDescription& site);

// The addresses of all pages, for search engines (https://www.sitemaps.org). REQUIRES: the place's
// root is known.
std::string WriteSitemap(std::span<const ModelSummary> models, const PagePlace& place);

// The page where there is no model to show. It says why, for people and robots; with scripts the
// viewer says it, and shows the other models.
std::string MakeRefusalPage(std::string_view page, const std::string& title,
  const std::string& text, const PagePlace& place, const std::string& site);

}
