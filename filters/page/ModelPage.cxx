// SPDX-License-Identifier: BSD-3-Clause
#include "filters/page/ModelPage.h"

#include "filters/core/Texts.h"
#include "filters/core/VectorMath.h"
#include "filters/model/JsonWriter.h"
#include "filters/model/Units.h"
#include "filters/page/ModelPicture.h"
#include "filters/page/PageTexts.h"
#include "filters/page/PreviewGlb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <utility>

namespace kdstream
{

namespace
{

std::string PlainText(std::string_view text)
{
  const auto plain = WithoutDirections(text);
  return std::string(Trimmed(plain, " \t\r\n"));
}

std::string Grouped(std::uint64_t number)
{
  std::string text = std::to_string(number);
  for (auto at = static_cast<std::ptrdiff_t>(text.size()) - 3; at > 0; at -= 3)
  {
    text.insert(static_cast<std::size_t>(at), ",");
  }
  return text;
}

// A metric unit in which the length is from 1 to 1000, if there is one, and the factor to convert
// to it. Units that are not metric stay unchanged. The same as in the viewer
// (viewer/mobile/web/lengths.js).
std::pair<std::string, double> UnitToRead(double length, const std::string& unit)
{
  using Unit = std::pair<const char*, double>;
  constexpr std::array<Unit, 6> largestFirst{ { { "km", 1e3 }, { "m", 1 }, { "cm", 1e-2 },
    { "mm", 1e-3 }, { "µm", 1e-6 }, { "nm", 1e-9 } } };
  const double metres = MetresOfUnit(unit).value_or(0);
  const bool isKnown = std::any_of(largestFirst.begin(), largestFirst.end(),
    [metres](const Unit& each) { return each.second == metres; });
  if (!isKnown || (length >= 1 && length < 1000))
  {
    return { PlainText(unit), 1 };
  }
  const auto found = std::find_if(largestFirst.begin(), largestFirst.end(),
    [=](const Unit& each) { return length * metres >= each.second; });
  const Unit& shown = found == largestFirst.end() ? largestFirst.back() : *found;
  return { shown.first, metres / shown.second };
}

// The sizes along the three axes, rounded so that the longest has three digits; empty if there is
// no unit or no size.
std::string SizeOf(const ModelDescription& model)
{
  const Vec3 sides = model.box.Empty() ? Vec3{} : Minus(model.box.hi, model.box.lo);
  const double longest = std::max({ sides[0], sides[1], sides[2] });
  if (model.unit.empty() || !(longest > 0) || !std::isfinite(longest))
  {
    return {};
  }
  const auto [unit, factor] = UnitToRead(longest, model.unit);
  const double order = std::floor(std::log10(longest * factor));
  const int digits = static_cast<int>(std::clamp(2 - order, -9.0, 9.0)); // after the decimal point
  std::string size;
  for (const double side : sides)
  {
    const double step = std::pow(10, -digits);
    const double value = digits > 0 ? side * factor : std::round(side * factor / step) * step;
    char text[400]; // enough for the longest double
    std::snprintf(text, sizeof text, "%.*f", std::max(0, digits), value);
    std::string figure = text;
    if (digits > 0)
    {
      figure.erase(figure.find_last_not_of('0') + 1);
      figure.erase(figure.find_last_not_of('.') + 1);
    }
    size += (size.empty() ? "" : " × ") + figure;
  }
  return size + " " + unit;
}

void AppendSentence(std::string& all, std::string_view sentence)
{
  if (!sentence.empty())
  {
    constexpr std::string_view ends[] = { ".", "!", "?", "…", "؟", "。" };
    const bool isWhole =
      std::any_of(std::begin(ends), std::end(ends), [&](auto end) { return all.ends_with(end); });
    all += (all.empty() ? "" : isWhole ? " " : ". ") + std::string(sentence);
  }
}

// ---- the head

std::string Meta(std::string_view kind, std::string_view name, std::string_view value)
{
  return value.empty() ? std::string()
                       : "<meta " + std::string(kind) + "=\"" + std::string(name) +
                           "\" content=\"" + HtmlEscaped(value) + "\">\n";
}

std::string Link(std::string_view relation, std::string_view type, std::string_view address,
  std::string_view title = {})
{
  return "<link rel=\"" + std::string(relation) + "\"" +
         (type.empty() ? "" : " type=\"" + HtmlEscaped(type) + "\"") + " href=\"" +
         HtmlEscaped(address) + "\"" +
         (title.empty() ? "" : " title=\"" + HtmlEscaped(title) + "\"") + ">\n";
}

std::string TitleElement(const std::string& title, const std::string& site)
{
  const auto& here = site.empty() ? std::string("KdStream") : site;
  return "<title>" + HtmlEscaped(title) + " – " + HtmlEscaped(here) + "</title>\n";
}

// https://schema.org/3DModel
std::string StructuredData(const ModelDescription& model, const ModelTexts& texts,
  const PagePlace& place, const std::string& site)
{
  JsonWriter json;
  const auto put = [&json](const char* name, const std::string& text)
  {
    if (!text.empty())
    {
      json.Member(name, text);
    }
  };
  json.BeginObject()
    .Member("@context", "https://schema.org")
    .Member("@type", "3DModel")
    .Member("name", texts.title)
    .Member("url", place.Page(model.id));
  put("description", model.description.empty() ? texts.summary : model.description);
  put("creditText", model.credit);
  if (IsWebAddress(model.license))
  {
    json.Member("license", model.license);
  }
  else if (!model.license.empty())
  {
    json.Key("license")
      .BeginObject()
      .Member("@type", "CreativeWork")
      .Member("name", model.license)
      .EndObject();
  }
  if (HasPicture(model))
  {
    json.Member("image", place.Picture(model.id)).Member("thumbnailUrl", place.Picture(model.id));
  }
  if (HasPreviewGlb(model))
  {
    json.Key("encoding")
      .BeginObject()
      .Member("@type", "MediaObject")
      .Member("contentUrl", place.Preview(model.id, model.digest))
      .Member("encodingFormat", "model/gltf-binary")
      .EndObject();
  }
  json.Member("embedUrl", place.Page(model.id) + "?embed");
  if (!site.empty())
  {
    json.Key("isPartOf")
      .BeginObject()
      .Member("@type", "Collection")
      .Member("name", site)
      .Member("url", place.Base())
      .EndObject();
  }
  json.EndObject();
  return "<script type=\"application/ld+json\">" + ScriptEscaped(json.Text()) + "</script>\n";
}

std::string HeadOf(const ModelDescription& model, const ModelTexts& texts, const PagePlace& place,
  const std::string& site)
{
  constexpr std::size_t mostOfTitle = 200; // bytes
  const auto title = Shortened(texts.title, mostOfTitle);
  std::string head = TitleElement(title, site);
  head += Meta("name", "description", texts.summary);
  head += Link("canonical", "", place.Page(model.id));
  head += Meta("property", "og:type", "website");
  head += Meta("property", "og:site_name", site);
  head += Meta("property", "og:title", title);
  head += Meta("property", "og:description", texts.summary);
  head += Meta("property", "og:url", place.Page(model.id));
  if (HasPicture(model))
  {
    head += Meta("property", "og:image", place.Picture(model.id));
    head += Meta("property", "og:image:type", "image/jpeg");
    head += Meta("property", "og:image:width", std::to_string(pictureWidth));
    head += Meta("property", "og:image:height", std::to_string(pictureHeight));
    head += Meta("property", "og:image:alt", title);
  }
  head += Meta("name", "twitter:card", HasPicture(model) ? "summary_large_image" : "summary");
  head += Meta("name", "twitter:title", title);
  head += Meta("name", "twitter:description", texts.summary);
  if (HasPicture(model))
  {
    head += Meta("name", "twitter:image", place.Picture(model.id));
    head += Meta("name", "twitter:image:alt", title);
  }
  if (!place.root.empty())
  {
    head += Link("alternate", "application/json+oembed", place.Embed(model.id), title);
  }
  head += Link("alternate",
    R"(application/ld+json;profile="http://iiif.io/api/presentation/4/context.json")",
    place.Manifest(model.id));
  return head + StructuredData(model, texts, place, site);
}

// ---- the body

std::string Paragraph(std::string_view text)
{
  return text.empty() ? std::string() : "<p dir=\"auto\">" + HtmlEscaped(text) + "</p>\n";
}

std::string WithoutScripts(const std::string& content)
{
  return "<noscript><div id=\"no-script\">\n" + content +
         "<p>The viewer needs JavaScript, which is switched off.</p>\n</div></noscript>";
}

std::string LinkToList(const PagePlace& place)
{
  return "<p><a href=\"" + HtmlEscaped(place.up + std::string(pagesFolder)) +
         "\">All models</a></p>\n";
}

std::string BodyOf(const ModelDescription& model, const ModelTexts& texts, const PagePlace& place)
{
  std::string body = "<h1 dir=\"auto\">" + HtmlEscaped(texts.title) + "</h1>\n";
  if (HasPicture(model))
  {
    // Relative addresses on the page's own server, because the page may not load anything from
    // others.
    const PagePlace near{ {}, place.up, place.isFolder };
    body += "<p><img src=\"" + HtmlEscaped(near.Picture(model.id)) + "\" alt=\"\" width=\"320\" " +
            "height=\"168\"></p>\n";
  }
  body += Paragraph(model.credit);
  body += IsWebAddress(model.license)
            ? "<p><a rel=\"license nofollow noopener noreferrer\" href=\"" +
                HtmlEscaped(model.license) + "\">" + HtmlEscaped(model.license) + "</a></p>\n"
            : Paragraph(model.license);
  body += Paragraph(model.description);
  return WithoutScripts(body + Paragraph(texts.size) + Paragraph(texts.count) + LinkToList(place));
}

// The head and the body are put into the page.

// Whether the value of an attribute is an address relative to the page.
bool IsRelative(std::string_view value)
{
  const auto colon = value.find(':');
  return !value.empty() && value.front() != '/' && value.front() != '#' && value.front() != '?' &&
         (colon == std::string_view::npos || colon > value.find('/'));
}

std::string WithRelativeAddresses(std::string_view page, const std::string& up)
{
  std::string moved;
  std::size_t done = 0;
  for (std::size_t at = 0; at < page.size(); ++at)
  {
    for (const std::string_view attribute : { " href=\"", " src=\"" })
    {
      const auto begin = at + attribute.size();
      if (page.substr(at, attribute.size()) == attribute &&
          IsRelative(page.substr(begin, page.find('"', begin) - begin)))
      {
        moved.append(page.substr(done, begin - done)).append(up);
        done = begin;
      }
    }
  }
  return moved.append(page.substr(done));
}

// Replaces the element <name>…</name> by `text`. If there is no such element, inserts the text
// after the tag <after …>, or at the very beginning.
void PutElement(
  std::string& page, const std::string& name, std::string_view after, const std::string& text)
{
  const auto begin = page.find("<" + name + ">");
  const std::string last = "</" + name + ">";
  const auto end = begin == page.npos ? page.npos : page.find(last, begin);
  if (end != page.npos)
  {
    page.replace(begin, end + last.size() - begin, text);
    return;
  }
  const auto tag = page.find(after);
  const auto close = tag == page.npos ? page.npos : page.find('>', tag);
  page.insert(close == page.npos ? 0 : close + 1, text);
}

std::string MakePage(
  std::string_view page, const std::string& head, const std::string& body, const PagePlace& place)
{
  std::string made = WithRelativeAddresses(page, place.up);
  PutElement(made, "noscript", "<body", body); // while no foreign texts are in the head
  PutElement(made, "title", "<head", head);
  return made;
}

}

ModelTexts TextsOf(const ModelDescription& model)
{
  ModelTexts texts;
  texts.title = PlainText(model.title);
  texts.title = texts.title.empty() ? model.id : texts.title;
  texts.count = model.primitive == PrimitiveType::Points ? Grouped(model.vertices) + " points"
                                                         : Grouped(model.triangles) + " triangles";
  texts.size = SizeOf(model);
  constexpr std::size_t mostOfCredit = 150, mostOfDescription = 250;
  AppendSentence(texts.summary, Shortened(PlainText(model.description), mostOfDescription));
  AppendSentence(texts.summary, Shortened(PlainText(model.credit), mostOfCredit));
  AppendSentence(texts.summary, texts.size);
  if (texts.summary.empty())
  {
    texts.summary = texts.count;
  }
  return texts;
}

std::string MakeModelPage(std::string_view page, const ModelDescription& model,
  const PagePlace& place, const std::string& site)
{
  const auto texts = TextsOf(model);
  return MakePage(page, HeadOf(model, texts, place, site), BodyOf(model, texts, place), place);
}

std::string MakeRefusalPage(std::string_view page, const std::string& title,
  const std::string& text, const PagePlace& place, const std::string& site)
{
  const std::string head = TitleElement(title, site) + Meta("name", "robots", "noindex");
  const std::string body = "<h1 dir=\"auto\">" + HtmlEscaped(title) + "</h1>\n" + Paragraph(text);
  return MakePage(page, head, WithoutScripts(body + LinkToList(place)), place);
}

std::string MakeListPage(std::string_view page, std::span<const ModelSummary> models,
  const PagePlace& place, const SiteDescription& site)
{
  const std::string title = site.title.empty() ? "Models" : site.title;
  const auto address = place.Base() + std::string(pagesFolder);
  std::string head = "<title>" + HtmlEscaped(title) + "</title>\n";
  head += Meta("name", "description", site.text) + Link("canonical", "", address) +
          Meta("property", "og:type", "website") + Meta("property", "og:title", title) +
          Meta("property", "og:description", site.text) + Meta("property", "og:url", address);
  std::string body = "<h1 dir=\"auto\">" + HtmlEscaped(title) + "</h1>\n" + Paragraph(site.text);
  const PagePlace near{ {}, place.up, place.isFolder };
  body += "<ul>\n";
  for (const ModelSummary& model : models)
  {
    const auto name = PlainText(model.title);
    body += "<li dir=\"auto\"><a href=\"" + HtmlEscaped(near.Page(model.id)) + "\">" +
            HtmlEscaped(name.empty() ? model.id : name) + "</a></li>\n";
  }
  return MakePage(page, head, WithoutScripts(body + "</ul>\n"), place);
}

std::string WriteSitemap(std::span<const ModelSummary> models, const PagePlace& place)
{
  std::string map = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                    "<urlset xmlns=\"http://www.sitemaps.org/schemas/sitemap/0.9\">\n";
  const auto add = [&map](const std::string& address)
  { map += "<url><loc>" + HtmlEscaped(address) + "</loc></url>\n"; };
  add(place.Base());
  for (const ModelSummary& model : models)
  {
    add(place.Page(model.id));
  }
  return map + "</urlset>\n";
}

}
