// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the PLY reader, and to the OFF reader for input that does not begin with
// "ply": ./dev fuzz.
#include "filters/meshio/Testing/ReadHostile.h"
#include "filters/meshio/ply/OffHeader.h"
#include "filters/meshio/ply/PlyReader.h"

#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  const bool isPly = size >= 3 && std::memcmp(data, "ply", 3) == 0;
  const test::OpenReader openPly = [](ByteSource source)
  { return PlyReader::Open(std::move(source)); };
  const test::OpenReader openOff = [](ByteSource source)
  { return OpenOffReader(std::move(source), {}, {}); };
  test::ReadHostileBothWays(isPly ? openPly : openOff, data, size);
  return 0;
}
