// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to OBJ files with materials, which are read and baked: ./dev fuzz. The mesh
// comes before the first 0 byte, its library "m.mtl" after it.
#include "filters/texture/FindTextures.h"
#include "filters/texture/Testing/FuzzFolder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  static const test::FuzzFolder folder;
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(all.find('\0'), size);
  folder.Write("m.mtl", all.substr(std::min(end + 1, size)));
  const std::filesystem::path file = folder.Write("m.obj", all.substr(0, end));
  (void)FindTextures(file);
  if (Result<TexturedFile> read = ReadTextured(file))
  {
    test::CheckTextured(std::move(read->textured));
  }
  return 0;
}
