// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/DirectionText.h"

#include <cmath>
#include <locale>
#include <sstream>

namespace kdstream
{
namespace
{

std::optional<Vec3> ParseDirection(const std::string& text)
{
  std::istringstream numbers(text);
  numbers.imbue(std::locale::classic());
  Vec3 vector{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    char comma = ',';
    if ((k > 0 && !numbers.get(comma)) || comma != ',' || !(numbers >> vector[k]))
    {
      return std::nullopt;
    }
  }
  return numbers.peek() == std::istringstream::traits_type::eof() ? DirectionOf(vector)
                                                                  : std::nullopt;
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
        return ParseDirection(text) ? ""
                                    : "\"" + text +
                                        "\" is no direction: three numbers, not all 0, "
                                        "such as 0,0,1";
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

}
