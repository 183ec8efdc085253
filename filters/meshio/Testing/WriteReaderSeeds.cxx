// SPDX-License-Identifier: BSD-3-Clause
// Writes the seed corpus of the readers' fuzz targets: small files of every format and notation, in
// one folder for each target. Usage: WriteReaderSeeds FOLDER; ./dev fuzz calls it.
#include "filters/meshio/Testing/RandomObj.h"
#include "filters/meshio/Testing/RandomOff.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/RandomStl.h"

#include <cstdio>
#include <filesystem>
#include <fstream>

namespace
{

constexpr unsigned seedsOfTarget = 60;

template <class Maker>
bool WriteSeeds(const std::filesystem::path& folder, const std::string& prefix = "seed-")
{
  std::error_code status;
  std::filesystem::create_directories(folder, status);
  bool good = !status;
  for (unsigned seed = 0; seed < seedsOfTarget && good; ++seed)
  {
    Maker maker(seed);
    const std::string bytes = maker.Make(6).bytes;
    std::ofstream file(folder / (prefix + std::to_string(seed)), std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    good = static_cast<bool>(file.flush());
  }
  return good;
}

}

int main(int argc, char** argv)
{
  using namespace kdstream::test;
  if (argc != 2)
  {
    std::fprintf(stderr, "usage: WriteReaderSeeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  const bool good = WriteSeeds<RandomPlyMaker>(folder / "FuzzPlyReader") &&
                    WriteSeeds<RandomOffMaker>(folder / "FuzzPlyReader", "off-") &&
                    WriteSeeds<RandomStlMaker>(folder / "FuzzStlReader") &&
                    WriteSeeds<RandomObjMaker>(folder / "FuzzObjReader");
  if (!good)
  {
    std::fprintf(stderr, "WriteReaderSeeds: error: %s: cannot be written\n", argv[1]);
  }
  return good ? 0 : 1;
}
