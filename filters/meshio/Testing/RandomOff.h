// SPDX-License-Identifier: BSD-3-Clause
// Random meshes in random OFF dresses.
#pragma once

#include "filters/meshio/Testing/Dice.h"

namespace kdstream::test
{

struct RandomOff
{
  std::string bytes;
};

class RandomOffMaker
{
public:
  explicit RandomOffMaker(unsigned seed)
    : Chooser(seed)
  {
  }

  RandomOff Make(std::uint64_t mostFaces)
  {
    Dice& dice = this->Chooser;
    const bool texture = dice.Chance(0.2), colors = dice.Chance(0.4), normals = dice.Chance(0.3);
    const std::uint64_t vertices = 3 + dice.Pick(8), faces = dice.Pick(mostFaces + 1);
    const std::size_t channels = 3 + dice.Pick(2), ofFaces = dice.Chance(0.3) ? channels : 0;
    const bool bytes = dice.Chance(0.5), colorsFirst = dice.Chance(0.3);
    const std::string end = dice.PickOf({ "\n", "\r\n", "\n\n", " # remark\n", "\n#\n" });
    std::string text = std::string(texture ? "ST" : "") + (colors ? "C" : "") +
                       (normals ? "N" : "") + "OFF" + dice.PickOf({ " ", end }) +
                       std::to_string(vertices) + " " + std::to_string(faces) +
                       dice.PickOf({ "", " 0" }) + end;
    const auto color = [&](std::size_t count)
    {
      std::string made;
      for (std::size_t k = 0; k < count; ++k)
      {
        made +=
          " " + (bytes ? std::to_string(dice.Pick(256)) : "0." + std::to_string(dice.Pick(9)));
      }
      return made;
    };
    for (std::uint64_t i = 0; i < vertices; ++i)
    {
      text += ShortText(dice.AnyReal<float>()) + " " + ShortText(dice.AnyReal<float>()) + " " +
              ShortText(dice.AnyReal<float>());
      const std::string normal = normals ? " 0 0.6 -0.8" : "";
      const std::string colored = color(colors ? channels : 0);
      text += (colorsFirst ? colored + normal : normal + colored) + (texture ? " 0 1" : "") + end;
    }
    for (std::uint64_t i = 0; i < faces; ++i)
    {
      const std::uint64_t corners = 2 + dice.Pick(5);
      text += std::to_string(corners);
      for (std::uint64_t k = 0; k < corners; ++k)
      {
        text += " " + std::to_string(dice.Pick(vertices));
      }
      text += color(ofFaces) + end;
    }
    return { text };
  }

  Dice& GetDice() { return this->Chooser; }

private:
  Dice Chooser;
};

}
