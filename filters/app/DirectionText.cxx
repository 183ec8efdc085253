// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/DirectionText.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <locale>
#include <sstream>
#include <system_error>

namespace kdstream
{
namespace
{

// Uses no stream: when memory runs out, a stream fails without giving a reason.
std::optional<Vec3> ParseDirection(const std::string& text)
{
  const char* at = text.data();
  const char* const end = at + text.size();
  Vec3 vector{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (k > 0 && (at == end || *at++ != ','))
    {
      return std::nullopt;
    }
    while (at != end && std::isspace(static_cast<unsigned char>(*at)))
    {
      ++at;
    }
    at += end - at > 1 && *at == '+' && at[1] != '-' ? 1 : 0;
    const auto [after, failure] = std::from_chars(at, end, vector[k]);
    if (failure != std::errc() || !std::isfinite(vector[k]))
    {
      return std::nullopt;
    }
    at = after;
  }
  return at == end ? DirectionOf(vector) : std::nullopt;
}

}

CLI::Option* AddDirectionOption(
  CLI::App& app, const std::string& name, std::optional<Vec3>& direction, const std::string& help)
{
  return app
    .add_option_function<std::string>(
      name, [&direction](const std::string& text) { direction = ParseDirection(text); }, help)
    ->check(
      [](const std::string& text) -> std::string
      {
        return ParseDirection(text)
                 ? ""
                 : "\"" + text +
                     "\" is not a direction: give three numbers, not all 0, such as 0,0,1";
      })
    ->type_name("X,Y,Z");
}

std::string DirectionText(const Vec3& direction)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (std::abs(direction[k]) == 1)
    {
      return std::string(direction[k] > 0 ? "+" : "-") + "xyz"[k];
    }
  }
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << direction[0] << ',' << direction[1] << ',' << direction[2];
  return text.str();
}

std::string UnusedText(const ModelDescription& model)
{
  const std::uint64_t count = model.unused->vertices;
  const Vec3& farthest = model.unused->farthest;
  Box box = model.box;
  box.Add(farthest);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(10);
  text << count << (count == 1 ? " vertex" : " vertices") << " that no triangle uses, ";
  if (box == model.box)
  {
    text << "within the model's box";
  }
  else
  {
    text << (count == 1 ? "" : "the farthest ") << "at (" << farthest[0] << ", " << farthest[1]
         << ", " << farthest[2] << ")";
  }
  return text.str();
}

}
