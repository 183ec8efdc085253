// libFuzzer's entry to the PLY reader. Built with clang and -DKDSTREAM_BUILD_FUZZERS=ON; run:
// FuzzPlyReader CORPUS/
#include "filters/meshio/Testing/ReadHostilePly.h"

#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  const kdstream::test::MemoryFile file(
    std::string_view(reinterpret_cast<const char*>(data), size));
  // One call for all and many small ones must agree.
  const bool whole = kdstream::test::ReadHostilePly(file, static_cast<std::size_t>(-1));
  const bool parts = kdstream::test::ReadHostilePly(file, 3);
  kdstream::test::Require(whole == parts, "the limit makes no difference");
  return 0;
}
