// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the protocol's parsers: the first byte chooses the parser. For frames, the
// rest is a sequence of frames, each after a byte with its length; all go to the same assembler.
#include "filters/model/ModelJson.h"
#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ControlMessage.h"
#include "filters/protocol/ResourcePath.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>

using namespace kdstream::protocol;

namespace
{

void AssembleFrames(std::span<const std::uint8_t> bytes)
{
  FrameAssembler assembler;
  while (!bytes.empty())
  {
    const std::size_t length = std::min<std::size_t>(bytes[0], bytes.size() - 1);
    const auto frame = ParseFrame(bytes.subspan(1, length));
    if (frame)
    {
      (void)assembler.Accept(*frame).HasValue();
    }
    bytes = bytes.subspan(1 + length);
  }
}

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
  {
    return 0;
  }
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  switch (data[0] % 6)
  {
    case 0:
      (void)ParseClientMessage(text).HasValue();
      break;
    case 1:
      (void)ParseServerMessage(text).HasValue();
      break;
    case 2:
      (void)kdstream::ParseModel(text).HasValue();
      break;
    case 3:
      (void)kdstream::ParseModelList(text).HasValue();
      break;
    case 4:
      (void)ParseResourcePath(text).HasValue();
      break;
    default:
      AssembleFrames({ data + 1, size - 1 });
  }
  return 0;
}
