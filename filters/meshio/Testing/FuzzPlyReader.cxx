// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the PLY reader: ./dev fuzz.
#include "filters/meshio/ply/PlyReader.h"
#include "filters/meshio/Testing/ReadHostile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  kdstream::test::ReadHostileBothWays([](kdstream::ByteSource source)
    { return kdstream::PlyReader::Open(std::move(source)); },
    data, size);
  return 0;
}
