// SPDX-License-Identifier: BSD-3-Clause
// Warns about values of materials that change how a surface looks but are not carried. Part of step
// "read" of the pipeline picture.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

enum class LostLook
{
  Metalness,
  Roughness,
  Emission,
  Transparency
};

// Counts the materials that have each of these values. O(1) a material.
class LostLooks
{
public:
  // material: its name for messages. REQUIRES: each material only once for a look.
  void Add(LostLook look, const std::string& material)
  {
    auto& [first, count] = this->Of[static_cast<std::size_t>(look)];
    first = count++ == 0 ? material : first;
  }

  // A sentence for each kind of value: "the metalness of the material 'gold' and of 2 others is not
  // carried".
  std::vector<std::string> Tell() const
  {
    static constexpr std::array<const char*, looks> names{ "metalness", "roughness", "emission",
      "transparency" };
    std::vector<std::string> sentences;
    for (std::size_t look = 0; look < looks; ++look)
    {
      const auto& [first, count] = this->Of[look];
      if (count > 0)
      {
        const std::string others = count == 1 ? ""
                                   : count == 2
                                     ? " and of 1 other"
                                     : " and of " + std::to_string(count - 1) + " others";
        sentences.push_back(std::string("the ") + names[look] + " of the material " + first +
                            others + " is left out");
      }
    }
    return sentences;
  }

private:
  static constexpr std::size_t looks = 4;
  // the first material's name, and the number of materials
  std::array<std::pair<std::string, std::size_t>, looks> Of;
};

}
