// SPDX-License-Identifier: BSD-3-Clause
// Random but valid descriptions of models, from a seed, for tests that convert them to JSON and
// back.
#pragma once

#include "filters/model/ModelDescription.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace kdstream
{

class RandomModels
{
public:
  explicit RandomModels(std::uint64_t seed)
    : Engine(seed)
  {
  }

  std::uint64_t Integer(std::uint64_t lowest, std::uint64_t highest)
  {
    return std::uniform_int_distribution<std::uint64_t>(lowest, highest)(this->Engine);
  }
  template <class T>
  T Small(std::uint64_t lowest, std::uint64_t highest)
  {
    return static_cast<T>(this->Integer(lowest, highest));
  }

  // Any finite double: its bits are random, so subnormal numbers and -0 occur too.
  double Double()
  {
    for (;;)
    {
      const auto number = std::bit_cast<double>(this->Engine());
      if (std::isfinite(number))
      {
        return this->Integer(0, 20) == 0 ? -0.0 : number;
      }
    }
  }

  Vec3 Direction()
  {
    for (;;)
    {
      if (const auto direction = DirectionOf({ this->Double(), this->Double(), this->Double() }))
      {
        return *direction;
      }
    }
  }

  std::string Text(std::size_t most)
  {
    static const std::string pieces[] = { "a", "\"", "\\", "é", "\n", "中", "𝛼", " ", "</script>",
      std::string(1, '\0') };
    std::string text;
    for (auto i = this->Integer(0, most); i > 0; --i)
    {
      text += pieces[this->Integer(0, std::size(pieces) - 1)];
    }
    return text;
  }

  std::string Digest()
  {
    std::string digest;
    for (int i = 0; i < 32; ++i)
    {
      digest += "0123456789abcdef"[this->Integer(0, 15)];
    }
    return digest;
  }

  std::vector<std::uint32_t> Numbers(std::uint32_t lowest, std::uint32_t highest, std::size_t most)
  {
    std::vector<std::uint32_t> numbers(this->Integer(0, most));
    for (auto& number : numbers)
    {
      number = this->Small<std::uint32_t>(lowest, highest);
    }
    return numbers;
  }

  ResolutionDescription Resolution(bool deviates)
  {
    return { this->Integer(0, 1ull << 53), this->Integer(0, 1ull << 53), this->Integer(0, 1 << 30),
      this->Integer(0, 1ull << 53), deviates ? std::abs(this->Double()) : 0.0 };
  }

  ModelDescription Model()
  {
    ModelDescription model;
    model.id = "Model_" + std::to_string(this->Integer(0, 1000)) + ".x-y";
    model.digest = this->Digest();
    model.vertices = this->Integer(1, 1ull << 53);
    model.triangles = this->Integer(0, 1ull << 53);
    TreeDepths& depths = model.depths;
    depths.partition = this->Small<unsigned>(0, maximumDepth);
    depths.finest = this->Small<unsigned>(depths.partition, maximumDepth);
    depths.stitch = this->Small<unsigned>(depths.partition, depths.finest);
    model.partitions = this->Integer(1, 1ull << depths.partition);
    for (std::size_t k = 0; k < 3; ++k)
    {
      model.box.lo[k] = this->Double();
      model.box.hi[k] = this->Double();
      if (model.box.lo[k] > model.box.hi[k])
      {
        std::swap(model.box.lo[k], model.box.hi[k]);
      }
      model.grid.origin[k] = this->Double();
    }
    model.grid.bits =
      this->Integer(0, 1) == 0 ? std::uint8_t{ 0 } : this->Small<std::uint8_t>(8, 24);
    model.grid.scalarType = this->Integer(0, 1) == 1 ? ScalarType::Float64 : ScalarType::Float32;
    do
    {
      model.grid.step = std::abs(this->Double());
    } while (model.grid.step == 0);
    model.primitive = this->Integer(0, 1) == 1 ? PrimitiveType::Triangles : PrimitiveType::Points;
    if (this->Integer(0, 3) != 0)
    {
      for (unsigned depth = 0; depth <= depths.finest; ++depth)
      {
        model.levels.push_back(this->Resolution(true));
        model.levels.back().spacing = this->Small<std::uint32_t>(1, mostSpacing);
      }
    }
    model.original = this->Resolution(false);
    model.title = this->Text(40);
    model.credit = this->Text(40);
    model.license = this->Text(40);
    model.unit = this->Text(4);
    model.description = this->Text(900);
    if (this->Integer(0, 1) == 1)
    {
      model.homeView = { this->Direction(), this->Direction(), this->Integer(0, 1) == 1 };
    }
    for (auto i = this->Integer(0, 3); i > 0; --i)
    {
      model.attributes.push_back({ this->Text(10), static_cast<AttributeType>(this->Integer(0, 9)),
        this->Integer(0, 1) == 0 ? AttributeAssociation::Point : AttributeAssociation::Cell,
        this->Integer(0, 1) == 0 ? std::uint8_t{ 1 } : this->Small<std::uint8_t>(1, 255) });
    }
    this->AddScalars(model);
    return model;
  }

  void AddScalars(ModelDescription& model)
  {
    std::vector<ScalarDescription> all;
    for (const AttributeInfo& array : model.attributes)
    {
      if (!IsScalar(array) || this->Integer(0, 3) == 0)
      {
        continue;
      }
      std::array<double, 4> range{ this->Double(), this->Double(), this->Double(), this->Double() };
      std::sort(range.begin(), range.end());
      ScalarDescription scalar{ array.name, range[0], range[3], range[1], range[2], {} };
      const std::uint64_t classes = this->Integer(0, 1) * this->Integer(0, 256);
      for (std::uint64_t i = 0; i < classes; ++i)
      {
        scalar.classes.push_back({ double(i) - 100.5, this->Integer(0, 1ull << 53) });
      }
      all.push_back(scalar);
    }
    model.scalars = all;
  }

  // The text with a few bytes changed, removed, repeated or inserted.
  std::string Mutated(std::string text)
  {
    for (auto i = this->Integer(1, 4); i > 0 && !text.empty(); --i)
    {
      const auto at = this->Integer(0, text.size() - 1);
      switch (this->Integer(0, 4))
      {
        case 0:
          text[at] = static_cast<char>(this->Integer(0, 255));
          break;
        case 1:
          text.erase(at, this->Integer(1, 8));
          break;
        case 2:
          text.insert(at, text.substr(this->Integer(0, text.size() - 1), this->Integer(1, 30)));
          break;
        case 3:
          text.insert(at, 1, "-9{}[]\",:e."[this->Integer(0, 10)]);
          break;
        default:
          text.resize(at);
      }
    }
    return text;
  }

private:
  std::mt19937_64 Engine;
};

}
