// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to PLY files with pictures, which are read and baked: ./dev fuzz.
#include "filters/texture/FindTextures.h"
#include "filters/texture/Testing/FuzzFolder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  static const test::FuzzFolder folder;
  const std::filesystem::path file =
    folder.Write("m.ply", { reinterpret_cast<const char*>(data), size });
  (void)FindTextures(file);
  if (Result<TexturedFile> read = ReadTextured(file))
  {
    test::CheckTextured(std::move(read->textured));
  }
  return 0;
}
