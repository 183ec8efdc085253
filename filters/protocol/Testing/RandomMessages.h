// SPDX-License-Identifier: BSD-3-Clause
// Random but valid messages from a seed, which must not change when they are written to JSON and
// read again.
#pragma once

#include "filters/model/Testing/RandomModels.h"
#include "filters/protocol/ControlMessage.h"

#include <string>

namespace kdstream::protocol
{

class RandomMessages : public RandomModels
{
public:
  using RandomModels::RandomModels;

  BlobId Blob()
  {
    switch (this->Integer(0, 5))
    {
      case 0:
        return BlobId::TreePage(this->Small<std::uint32_t>(1, (1u << 31) - 1));
      case 2:
        return BlobId::PartitionBoxes(this->Small<std::uint32_t>(1, (1u << 31) - 1));
      case 1:
        return BlobId::LevelPiece(this->Small<std::uint8_t>(0, maximumDepth),
          this->Small<std::uint32_t>(1, (1u << 31) - 1));
      case 3:
        return BlobId::Texture(this->Small<std::uint32_t>(0, (1u << 30) - 1));
      case 4:
        return BlobId::LevelTexture(this->Small<std::uint8_t>(0, maximumDepth),
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
    switch (this->Integer(0, 4))
    {
      case 0:
        message.body = OpenRequest{ "dragon-2.x" };
        break;
      case 1:
        message.body = RegionRequest{ this->Small<std::uint32_t>(1, highestNode),
          this->Small<std::uint8_t>(0, maximumRings), this->Numbers(0, (1u << 30) - 1, 100) };
        break;
      case 2:
      case 3:
      {
        BlobsRequest asked;
        for (auto left = this->Integer(0, 100); left > 0; --left)
        {
          asked.blobs.push_back(this->Blob());
        }
        message.body = std::move(asked);
        break;
      }
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
};

}
