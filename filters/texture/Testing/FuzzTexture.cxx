// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to the files of textured meshes: pictures, and materials of OBJ files: ./dev
// fuzz.
#include "filters/texture/ObjMaterials.h"
#include "filters/texture/Picture.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  constexpr std::uint64_t mostPixels = 1 << 20;
  const Result<Picture> picture = DecodePicture({ data, size }, mostPixels);
  if (picture &&
      (picture->width * picture->height > mostPixels ||
        picture->texels.size() != picture->width * picture->height * picture->components))
  {
    std::abort();
  }
  // The same bytes as a material library, in a file in memory.
  static const int library = ::memfd_create("library", 0);
  if (library < 0 || ::ftruncate(library, 0) != 0 ||
      ::pwrite(library, data, size, 0) != static_cast<ssize_t>(size))
  {
    return 0;
  }
  ObjLibraries libraries("/proc/self/fd/mesh.obj");
  libraries.Add(std::to_string(library), 1);
  const ObjMaterials found = libraries.Take();
  for (const ObjMaterial& material : found.materials)
  {
    const std::string file = FileBeside("/folder/mesh.obj", material.picture).string();
    if (file.rfind("/folder/", 0) != 0 || file.find("/../") != std::string::npos)
    {
      std::abort();
    }
  }
  return 0;
}
