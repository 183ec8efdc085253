// SPDX-License-Identifier: BSD-3-Clause
// Random meshes in random OFF notation.
#pragma once

#include "filters/meshio/Testing/RandomGenerator.h"

namespace kdstream::test
{

class RandomOffMaker
{
public:
  explicit RandomOffMaker(unsigned seed)
    : Chooser(seed)
  {
  }

  RandomFile Make(std::uint64_t mostFaces)
  {
    RandomGenerator& generator = this->Chooser;
    const bool texture = generator.Chance(0.2), colors = generator.Chance(0.4),
               normals = generator.Chance(0.3);
    const std::uint64_t vertices = 3 + generator.Pick(8), faces = generator.Pick(mostFaces + 1);
    const std::size_t channels = 3 + generator.Pick(2),
                      ofFaces = generator.Chance(0.3) ? channels : 0;
    const bool bytes = generator.Chance(0.5), colorsFirst = generator.Chance(0.3);
    const std::string end = generator.PickOf({ "\n", "\r\n", "\n\n", " # remark\n", "\n#\n" });
    std::string text = std::string(texture ? "ST" : "") + (colors ? "C" : "") +
                       (normals ? "N" : "") + "OFF" + generator.PickOf({ " ", end }) +
                       std::to_string(vertices) + " " + std::to_string(faces) +
                       generator.PickOf({ "", " 0" }) + end;
    const auto color = [&](std::size_t count)
    {
      std::string made;
      for (std::size_t k = 0; k < count; ++k)
      {
        made += " " + (bytes ? std::to_string(generator.Pick(256))
                             : "0." + std::to_string(generator.Pick(9)));
      }
      return made;
    };
    for (std::uint64_t i = 0; i < vertices; ++i)
    {
      text += ShortText(generator.AnyReal<float>()) + " " + ShortText(generator.AnyReal<float>()) +
              " " + ShortText(generator.AnyReal<float>());
      const std::string normal = normals ? " 0 0.6 -0.8" : "";
      const std::string colored = color(colors ? channels : 0);
      text += (colorsFirst ? colored + normal : normal + colored) + (texture ? " 0 1" : "") + end;
    }
    for (std::uint64_t i = 0; i < faces; ++i)
    {
      const std::uint64_t corners = 2 + generator.Pick(5);
      text += std::to_string(corners);
      for (std::uint64_t k = 0; k < corners; ++k)
      {
        text += " " + std::to_string(generator.Pick(vertices));
      }
      text += color(ofFaces) + end;
    }
    RandomFile file;
    file.bytes = text;
    return file;
  }

  RandomGenerator& Generator() { return this->Chooser; }

private:
  RandomGenerator Chooser;
};

}
