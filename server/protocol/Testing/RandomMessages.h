// Random but valid descriptions and messages, from a seed: what must survive the way through JSON.
#pragma once

#include "server/protocol/ControlMessage.h"

#include <bit>
#include <cmath>
#include <random>
#include <string>

namespace kdstream::protocol
{

class RandomMessages
{
public:
  explicit RandomMessages(std::uint64_t seed)
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

  // Any finite double: its bits are random, subnormal numbers and -0 included.
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
    model.partitionDepth = this->Small<std::uint8_t>(0, maximumDepth);
    model.finestDepth = this->Small<std::uint8_t>(model.partitionDepth, maximumDepth);
    model.stitchDepth = this->Small<std::uint8_t>(model.partitionDepth, model.finestDepth);
    model.partitions = this->Integer(1, 1ull << model.partitionDepth);
    for (std::size_t k = 0; k < 3; ++k)
    {
      model.boxLo[k] = this->Double();
      model.boxHi[k] = this->Double();
      if (model.boxLo[k] > model.boxHi[k])
      {
        std::swap(model.boxLo[k], model.boxHi[k]);
      }
      model.gridOrigin[k] = this->Double();
    }
    model.bits = this->Integer(0, 1) == 0 ? std::uint8_t{ 0 } : this->Small<std::uint8_t>(8, 24);
    model.doublePrecision = this->Integer(0, 1) == 1;
    do
    {
      model.gridStep = std::abs(this->Double());
    } while (model.gridStep == 0);
    model.hasTriangles = this->Integer(0, 1) == 1;
    if (this->Integer(0, 3) != 0)
    {
      for (unsigned depth = 0; depth <= model.finestDepth; ++depth)
      {
        model.levels.push_back(this->Resolution(true));
      }
    }
    model.original = this->Resolution(false);
    model.title = this->Text(40);
    model.credit = this->Text(40);
    model.license = this->Text(40);
    model.unit = this->Text(4);
    for (auto i = this->Integer(0, 3); i > 0; --i)
    {
      model.attributes.push_back({ this->Text(10), this->Integer(0, 1) == 0 ? "uint8" : "float64",
        this->Integer(0, 1) == 0 ? "point" : "cell", this->Small<std::uint8_t>(1, 255) });
    }
    return model;
  }

  BlobId Blob()
  {
    switch (this->Integer(0, 2))
    {
      case 0:
        return BlobId::TreePage(this->Small<std::uint32_t>(1, (1u << 31) - 1));
      case 1:
        return BlobId::LevelPiece(this->Small<std::uint8_t>(0, maximumDepth),
          this->Small<std::uint32_t>(1, (1u << 31) - 1));
      default:
        return BlobId::Partition(this->Small<std::uint32_t>(0, (1u << 30) - 1));
    }
  }

  ClientMessage FromClient()
  {
    constexpr std::uint32_t highestNode = (1u << 31) - 1;
    ClientMessage message;
    message.request = this->Small<std::uint32_t>(1, 0xFFFFFFFFu);
    switch (this->Integer(0, 6))
    {
      case 0:
        message.body = OpenRequest{ "dragon-2.x" };
        break;
      case 1:
        message.body = PreviewRequest{};
        break;
      case 2:
        message.body = LevelRequest{ this->Small<std::uint8_t>(0, maximumDepth),
          this->Numbers(1, highestNode, 20) };
        break;
      case 3:
        message.body = TreeRequest{ this->Numbers(1, highestNode, 20) };
        break;
      case 4:
        message.body = RegionRequest{ this->Small<std::uint32_t>(1, highestNode),
          this->Small<std::uint8_t>(0, maximumRings), this->Numbers(0, (1u << 30) - 1, 100) };
        break;
      case 5:
        message.body = PartitionsRequest{ this->Numbers(0, (1u << 30) - 1, 100) };
        break;
      default:
        message.body = CancelRequest{};
    }
    return message;
  }

  ServerMessage FromServer()
  {
    constexpr std::uint64_t most = 1ull << 53;
    ServerMessage message;
    message.request = this->Small<std::uint32_t>(1, 0xFFFFFFFFu);
    switch (this->Integer(0, 4))
    {
      case 0:
        message.body = OpenedAnswer{ this->Model() };
        break;
      case 1:
      {
        BeginAnswer begin{ this->Integer(0, most), this->Integer(0, most), std::nullopt };
        if (this->Integer(0, 1) == 0)
        {
          begin.partitions = this->Numbers(0, (1u << 30) - 1, 200);
        }
        message.body = begin;
        break;
      }
      case 2:
        message.body = ProgressAnswer{ this->Integer(0, most), this->Integer(0, most) };
        break;
      case 3:
        message.body = EndAnswer{ this->Integer(0, most), this->Integer(0, most),
          this->Integer(0, most), this->Integer(0, 1) == 1 };
        break;
      default:
      {
        ErrorAnswer error{ this->Small<std::uint16_t>(400, 599), this->Text(30), std::nullopt };
        if (this->Integer(0, 1) == 0)
        {
          error.blob = this->Blob();
        }
        message.body = error;
        message.request = this->Small<std::uint32_t>(0, 1);
      }
    }
    return message;
  }

  // The text with a few bytes changed, removed, repeated or put in.
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
