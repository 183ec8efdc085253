// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to tilesets: ./dev fuzz. The input is the JSON up to the first 0; the bytes
// after it are both the only tile and the subtree.
#include "filters/convert/ForeignMesh.h"
#include "filters/texture/Testing/FuzzFolder.h"

#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  using namespace kdstream;
  using test::Require;
  static const test::FuzzFolder folder;
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(all.find('\0'), size);
  const std::string_view bytes = all.substr(std::min(end + 1, size));
  folder.Write("t", bytes);
  folder.Write("s", bytes);
  const Result<ForeignMesh> read =
    ReadTileset(folder.Write("t.json", all.substr(0, end)), { true, 1 << 16 }, {});
  if (!read)
  {
    Require(!read.GetError().message.empty());
    return 0;
  }
  for (const Triangle& t : read->mesh.triangles)
  {
    for (const VertexId corner : t)
    {
      Require(corner < read->mesh.points.size());
    }
  }
  for (const Attribute& attribute : read->mesh.attributes)
  {
    Require(attribute.TupleCount() == read->mesh.points.size());
  }
  return 0;
}
