// SPDX-License-Identifier: BSD-3-Clause
// A store exported as a tileset of 3D Tiles, and a level as a small .glb: what is written for any
// mesh, and that nothing is written by halves. Testing/Browser/tiles.test.mjs tests that other
// people's clients can read it.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/files/Folders.h"

#include <nlohmann/json.hpp>

#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <functional>
#include <map>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

namespace fs = std::filesystem;
using Json = nlohmann::json;

Json JsonOfGlb(const fs::path& file)
{
  const std::string bytes = ReadWhole(file);
  std::uint32_t size = 0;
  EXPECT_GT(bytes.size(), 20u) << file;
  std::memcpy(&size, bytes.data() + 12, sizeof(size));
  EXPECT_EQ(bytes.substr(0, 4), "glTF") << file;
  return Json::parse(bytes.substr(20, size));
}

class TestExportTiles : public ProgramsTest
{
protected:
  Outcome Export(std::vector<std::string> arguments, const std::string& format = "3dtiles")
  {
    arguments.insert(arguments.begin(), "export");
    arguments.insert(arguments.end(), { "--format", format });
    return this->Store(arguments);
  }
  void Make(const std::string& name, const Mesh& mesh, std::vector<std::string> more = {})
  {
    this->Write(name + ".ply", mesh);
    more.insert(more.begin(), { name + ".ply", "-o", name + ".kds", "--quiet" });
    const Outcome built = this->Build(more);
    ASSERT_EQ(built.exitCode, 0) << built.err;
  }
  Json Root(const std::string& folder) const
  {
    return Json::parse(ReadWhole(this->Folder / folder / "tileset.json")).at("root");
  }
  // The contents of all tiles, including those of external tilesets.
  std::vector<fs::path> Contents(const std::string& folder) const
  {
    std::vector<fs::path> all;
    const std::function<void(const Json&, const fs::path&)> visit =
      [&](const Json& tile, const fs::path& base)
    {
      if (tile.contains("content"))
      {
        const fs::path file = (base / tile["content"]["uri"].get<std::string>()).lexically_normal();
        if (file.extension() == ".json")
        {
          visit(
            Json::parse(ReadWhole(this->Folder / folder / file)).at("root"), file.parent_path());
          return;
        }
        all.push_back(this->Folder / folder / file);
      }
      for (const Json& child : tile.value("children", Json::array()))
      {
        visit(child, base);
      }
    };
    visit(this->Root(folder), {});
    return all;
  }
};

TEST_F(TestExportTiles, APointACloudAndATriangle)
{
  this->Make("point", Mesh{ { { 1, 2, 3 } }, {} });
  ASSERT_EQ(this->Export({ "point.kds", "point" }).exitCode, 0);
  ASSERT_FALSE(this->Contents("point").empty());
  const Json point = JsonOfGlb(this->Contents("point").back());
  EXPECT_EQ(point["meshes"][0]["primitives"][0]["mode"], 0);
  EXPECT_EQ(point["accessors"][0]["count"], 1);
  EXPECT_FALSE(point["meshes"][0]["primitives"][0].contains("indices"));

  const Mesh cloud = Cloud(4);
  this->Make("cloud", cloud, { "--vertices-per-partition", "500" });
  const Outcome outcome = this->Export({ "cloud.kds", "cloud" });
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  std::size_t points = 0;
  for (const fs::path& file : this->Contents("cloud"))
  {
    if (file.parent_path().filename() == "original")
    {
      points += JsonOfGlb(file)["accessors"][0]["count"].get<std::size_t>();
    }
  }
  EXPECT_EQ(points, cloud.points.size());

  this->Make("one", Mesh{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, { { 0, 1, 2 } } });
  ASSERT_EQ(this->Export({ "one.kds", "one" }).exitCode, 0);
  const Json one = JsonOfGlb(this->Contents("one").back());
  EXPECT_EQ(one["accessors"].back()["count"], 3);
  EXPECT_EQ(one["meshes"][0]["primitives"].size(), 1u) << "no skirts where nothing is beside it";
}

TEST_F(TestExportTiles, LargeModelsHaveExternalTilesets)
{
  this->Make(
    "ball", DisplacedSphere(7), { "--vertices-per-partition", "500", "--cell-vertices", "1" });
  const Outcome outcome = this->Export({ "ball.kds", "ball" });
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find(" tiles to ball, "), std::string::npos) << outcome.err;
  const auto contents = this->Contents("ball");
  EXPECT_EQ(std::set<fs::path>(contents.begin(), contents.end()).size(), contents.size());
  std::size_t tilesets = 0, tiles = 0;
  for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "ball"))
  {
    tilesets += entry.path().extension() == ".json";
    tiles += entry.path().extension() == ".glb";
  }
  EXPECT_EQ(tiles, contents.size());
  EXPECT_GT(tilesets, 1u);
}

// Partitions are far smaller than the finest level's pieces, so tiles without content group them.
TEST_F(TestExportTiles, TilesetsAreSmallWherePartitionsAre)
{
  this->Make("dust", DisplacedSphere(6), { "--vertices-per-partition", "20" });
  ASSERT_EQ(this->Export({ "dust.kds", "dust" }).exitCode, 0);
  std::size_t tilesets = 0, groups = 0;
  const std::function<std::size_t(const Json&, const Json&)> count =
    [&](const Json& tile, const Json& shown) -> std::size_t
  {
    const bool isGroup = !tile.contains("content");
    groups += isGroup;
    if (isGroup && !shown.is_null())
    {
      EXPECT_EQ(tile["boundingVolume"], shown["boundingVolume"]);
      EXPECT_EQ(tile["geometricError"], shown["geometricError"]);
    }
    std::size_t tiles = 1;
    for (const Json& child : tile.value("children", Json::array()))
    {
      tiles += count(child, isGroup ? shown : tile);
    }
    return tiles;
  };
  std::size_t tiles = 0;
  for (const auto& entry : fs::recursive_directory_iterator(this->Folder / "dust"))
  {
    tiles += entry.path().extension() == ".glb";
    if (entry.path().extension() == ".json")
    {
      ++tilesets;
      EXPECT_LE(count(Json::parse(ReadWhole(entry.path()))["root"], {}), 256u) << entry.path();
      EXPECT_LT(fs::file_size(entry.path()), 70'000u) << entry.path();
    }
  }
  EXPECT_GT(tiles, 1000u);
  EXPECT_GT(tilesets, 16u);
  EXPECT_GT(groups, 0u);
  const auto contents = this->Contents("dust");
  EXPECT_EQ(contents.size(), tiles);
  EXPECT_EQ(std::set<fs::path>(contents.begin(), contents.end()).size(), tiles);
}

// All positions of a level are whole numbers of steps on one lattice with one origin. So
// neighbouring tiles have their common vertices in the same places.
TEST_F(TestExportTiles, TilesOfALevelShareALattice)
{
  const Mesh mesh = DisplacedSphere(5, { 40, -20, 8 });
  this->Make("grid", mesh, { "--vertices-per-partition", "500", "--unit", "mm" });
  this->Make("exact", mesh, { "--vertices-per-partition", "500", "--precision", "lossless" });
  for (const std::string name : { "grid", "exact" })
  {
    for (const std::string compression : { "meshopt", "draco" })
    {
      const std::string out = name + "-" + compression;
      const Outcome made = this->Export({ name + ".kds", out, "--compression", compression });
      if (made.err.find("was not there when KdStream was built") != std::string::npos)
      {
        continue;
      }
      ASSERT_EQ(made.exitCode, 0) << made.err;
      const auto contents = this->Contents(out);
      std::map<std::string, double> steps; // by level
      std::size_t wide = 0;
      // Backwards, so the original comes first.
      for (auto each = contents.rbegin(); each != contents.rend(); ++each)
      {
        const fs::path& file = *each;
        const Json glb = JsonOfGlb(file);
        const Json& matrix = glb["nodes"][0]["matrix"];
        const double step = matrix[0];
        EXPECT_EQ(steps.try_emplace(file.parent_path().filename(), step).first->second, step)
          << file;
        // With a grid, the lattice of a level has every 2nd, 3rd … point of the original's lattice.
        const double unit = name == "grid" ? steps.at("original") : step;
        for (const std::size_t k : { 12, 13, 14 })
        {
          const double units = matrix[k].get<double>() / unit;
          EXPECT_EQ(units, std::round(units)) << file;
        }
        const Json& positions =
          glb["accessors"]
             [glb["meshes"][0]["primitives"][0]["attributes"]["POSITION"].get<std::size_t>()];
        for (const char* const end : { "min", "max" })
        {
          for (const double value : positions[end].get<std::vector<double>>())
          {
            EXPECT_EQ(value, std::round(value)) << file;
            wide += std::abs(value) > 65535;
          }
        }
      }
      EXPECT_TRUE(wide > 0 || name == "exact") << "tiles of more than 16 bits are among them";
    }
  }
}

TEST_F(TestExportTiles, WhatIsNotCarriedIsNamed)
{
  Mesh rich = Torus(40, 20);
  const AttributeInfo colors{ "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 };
  const AttributeInfo heat{ "heat", AttributeType::Float32, AttributeAssociation::Point, 1 };
  const AttributeInfo wide{ "wide", AttributeType::Float32, AttributeAssociation::Point, 5 };
  const AttributeInfo fine{ "1 fine", AttributeType::Float64, AttributeAssociation::Point, 2 };
  for (const AttributeInfo& array : { colors, heat, wide, fine })
  {
    const std::size_t bytes = rich.points.size() * array.TupleSize();
    rich.attributes.push_back({ array, std::vector<std::uint8_t>(bytes, 64) });
  }
  this->Make("rich", rich);
  const Outcome outcome = this->Export({ "rich.kds", "rich" });
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  for (const std::string warning : { "this format cannot hold these attributes: wide\n",
         "these attributes are written as floats of 32 bits: 1 fine\n" })
  {
    EXPECT_NE(outcome.err.find("warning: rich: " + warning), std::string::npos) << outcome.err;
  }
  const Json glb = JsonOfGlb(this->Contents("rich").back());
  const Json part = glb["meshes"][0]["primitives"][0];
  for (const char* name : { "NORMAL", "COLOR_0", "_HEAT", "__1_FINE" })
  {
    EXPECT_TRUE(part["attributes"].contains(name)) << name;
  }
  EXPECT_EQ(part["extensions"]["EXT_structural_metadata"]["propertyAttributes"], Json({ 0 }));
  const Json metadata = glb["extensions"]["EXT_structural_metadata"];
  const Json properties = metadata["schema"]["classes"]["vertex"]["properties"];
  EXPECT_EQ(properties["_1_fine"]["name"], "1 fine");
  EXPECT_EQ(properties["_1_fine"]["type"], "VEC2");
  EXPECT_EQ(metadata["propertyAttributes"][0]["properties"]["heat"]["attribute"], "_HEAT");

  this->Make("ells", Torus(40, 20), { "--unit", "ells" });
  EXPECT_NE(this->Export({ "ells.kds", "ells" }).err.find("the unit 'ells' is not known"),
    std::string::npos);
  this->Make("mm", Torus(40, 20), { "--unit", "mm" });
  ASSERT_EQ(this->Export({ "mm.kds", "mm" }).err.find("warning"), std::string::npos);
  const double metres = this->Root("ells")["boundingVolume"]["box"][3];
  EXPECT_NEAR(
    this->Root("mm")["boundingVolume"]["box"][3].get<double>(), metres / 1000, metres * 1e-6);
}

// Coordinates far from the origin, as in surveys, must not be stored as floats.
TEST_F(TestExportTiles, LargeCoordinatesStandOnlyInTransforms)
{
  Mesh far = DisplacedSphere(5, { 4.5e6, 5.2e6, 800 });
  far.scalarType = ScalarType::Float64;
  this->Make("far", far, { "--precision", "lossless", "--vertices-per-partition", "500" });
  for (const std::string compression : { "none", "meshopt" })
  {
    ASSERT_EQ(this->Export({ "far.kds", compression, "--compression", compression }).exitCode, 0);
    EXPECT_GT(std::abs(this->Root(compression)["transform"][12].get<double>()), 4e6);
    for (const fs::path& file : this->Contents(compression))
    {
      const Json matrix = JsonOfGlb(file)["nodes"][0]["matrix"];
      for (int i = 12; i < 15; ++i)
      {
        EXPECT_LT(std::abs(matrix[static_cast<std::size_t>(i)].get<double>()), 3) << file;
      }
    }
  }
}

TEST_F(TestExportTiles, NothingHalfIsWritten)
{
  this->Make("ring", Torus(200, 100), { "--vertices-per-partition", "200" });
  const auto before = this->Files();

  fs::create_directory(this->Folder / "there");
  this->WriteText("there/mine", "precious");
  this->ExpectError(this->Export({ "ring.kds", "there" }), 1,
    "kdstream-store: error: there: is there already: remove it, or name a new folder");
  this->ExpectError(this->Export({ "ring.kds", "ring.ply" }), 1,
    "kdstream-store: error: ring.ply: is there already: remove it, or name a new folder");
  EXPECT_EQ(ReadWhole(this->Folder / "there/mine"), "precious");
  fs::remove_all(this->Folder / "there");
  EXPECT_EQ(this->Export({ "ring.kds", "ring.ply/below" }).exitCode, 1);
  EXPECT_EQ(this->Files(), before);

  rlimit limits{};
  ::getrlimit(RLIMIT_FSIZE, &limits);
  rlimit small = limits;
  small.rlim_cur = 2000; // children inherit it
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Outcome full = this->Export({ "ring.kds", "new/full" });
  ::setrlimit(RLIMIT_FSIZE, &limits);
  EXPECT_EQ(full.exitCode, 1);
  EXPECT_NE(full.err.find("kdstream-store: error: new/full"), std::string::npos) << full.err;
  EXPECT_EQ(this->Files(), before) << "nor the folder above";

  fs::create_directory(this->Folder / "empty");
  EXPECT_EQ(this->Export({ "ring.kds", "empty/" }).exitCode, 0) << "an empty folder is taken";
  EXPECT_TRUE(fs::exists(this->Folder / "empty/tileset.json"));
  fs::create_directory(this->Folder / "here");
  EXPECT_EQ(this->Export({ "ring.kds", "here/." }).exitCode, 0);
  const auto sorted = [](Result<std::vector<std::string>> names)
  {
    std::sort(names->begin(), names->end());
    return *names;
  };
  EXPECT_EQ(sorted(NamesIn(this->Folder / "here")), sorted(NamesIn(this->Folder / "empty")));
}

TEST_F(TestExportTiles, ADamagedStoreGivesNoTiles)
{
  this->Make("ring", Torus(200, 100));
  std::fstream store(this->Folder / "ring.kds", std::ios::in | std::ios::out | std::ios::binary);
  store.seekp(static_cast<std::streamoff>(fs::file_size(this->Folder / "ring.kds") / 2) + 100);
  store.write("spoilt", 6);
  store.close();
  const auto before = this->Files();
  const Outcome outcome = this->Export({ "ring.kds", "tiles" });
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_NE(outcome.err.find("kdstream-store: error: ring.kds: "), std::string::npos)
    << outcome.err;
  EXPECT_EQ(this->Files(), before);
}

TEST_F(TestExportTiles, AnInterruptLeavesNothing)
{
  this->Make("ball", DisplacedSphere(7), { "--vertices-per-partition", "100" });
  const auto before = this->Files();
  const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-store";
  unsigned interrupted = 0;
  for (unsigned milliseconds = 2; milliseconds < 500; milliseconds = milliseconds * 3 / 2 + 1)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      if (::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("said", "w", stderr))
      {
        ::execl(program.c_str(), program.c_str(), "export", "ball.kds", "tiles", "--format",
          "3dtiles", "--quiet", nullptr);
      }
      ::_exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGINT);
    int status = 0;
    ::waitpid(child, &status, 0);
    const std::string said = ReadWhole(this->Folder / "said");
    fs::remove(this->Folder / "said");
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
    {
      EXPECT_EQ(said, "kdstream-store: error: interrupted: tiles is not written\n");
      ++interrupted;
    }
    const bool whole = fs::exists(this->Folder / "tiles/tileset.json");
    EXPECT_EQ(fs::exists(this->Folder / "tiles"), whole);
    fs::remove_all(this->Folder / "tiles");
    EXPECT_EQ(this->Files(), before) << "after " << milliseconds << " ms";
  }
  EXPECT_GT(interrupted, 0u);
}

TEST_F(TestExportTiles, WrongUsageIsNamed)
{
  this->Make("ring", Torus(40, 20));
  this->ExpectError(this->Export({ "ring.kds", "out", "--page", "web" }), 2,
    "kdstream-store: error: --page cannot be used with --format 3dtiles, only with files");
  this->ExpectError(this->Export({ "ring.kds", "out", "--origin", "1,2,3" }, "glb"), 2,
    "kdstream-store: error: --origin cannot be used with --format glb, only with 3dtiles");
  this->ExpectError(this->Export({ "ring.kds", "out" }, "glb"), 2,
    "kdstream-store: error: out: does not end in .glb, as a file of --format glb does");
  for (const std::string place : { "1,2", "1,2,3,4,5", "181,0,0", "0,91,0", "a,b,c", "1,2,nan" })
  {
    const Outcome outcome = this->Export({ "ring.kds", "out", "--origin", place });
    EXPECT_EQ(outcome.exitCode, 2) << place;
    EXPECT_NE(outcome.err.find("is not a place"), std::string::npos) << outcome.err;
  }
  const Outcome commas = this->Export({ "ring.kds", "out", "--origin", "13,05,47,8" });
  EXPECT_EQ(commas.exitCode, 2);
  EXPECT_NE(commas.err.find("may be two numbers with decimal commas"), std::string::npos)
    << commas.err;
  ASSERT_EQ(this->Build({ "ring.ply", "-o", "flat.kds", "--partitioner", "octree" }).exitCode, 0);
  const Outcome flat = this->Export({ "flat.kds", "out" });
  EXPECT_EQ(flat.exitCode, 1);
  EXPECT_NE(flat.err.find("has no levels"), std::string::npos) << flat.err;
  EXPECT_FALSE(fs::exists(this->Folder / "out"));
}

// Map coordinates are far from the point that is placed on the globe.
TEST_F(TestExportTiles, AModelFarFromItsOriginIsSaid)
{
  Mesh mesh = Torus(40, 20);
  mesh.scalarType = ScalarType::Float64;
  this->Make("near", mesh);
  for (Vec3& point : mesh.points)
  {
    point[0] += 432000;
    point[1] += 5423000;
  }
  this->Make("far", mesh);
  this->Make("small", mesh, { "--unit", "mm" });
  const std::string far = "lies 5440 km from its point (0, 0, 0), perhaps in map coordinates (UTM)";
  for (const std::string name : { "near", "far", "small" })
  {
    const Outcome placed = this->Export({ name + ".kds", name, "--origin", "13.05,47.8,430" });
    EXPECT_EQ(placed.exitCode, 0);
    EXPECT_EQ(placed.err.find(far) != std::string::npos, name == "far") << placed.err;
  }
  const Outcome plain = this->Export({ "far.kds", "plain" });
  EXPECT_EQ(plain.exitCode, 0);
  EXPECT_EQ(plain.err.find("--origin"), std::string::npos) << plain.err;
}

TEST_F(TestExportTiles, ALevelIsASmallFile)
{
  this->Make("ring", Torus(200, 100));
  ASSERT_EQ(this->Export({ "ring.kds", "level.glb", "--level", "10" }, "glb").exitCode, 0);
  ASSERT_EQ(this->Export({ "ring.kds", "all.glb" }, "glb").exitCode, 0);
  const Json all = JsonOfGlb(this->Folder / "all.glb");
  EXPECT_EQ(all["accessors"].back()["count"], 3 * 2 * 200 * 100);
  EXPECT_LT(fs::file_size(this->Folder / "level.glb"), fs::file_size(this->Folder / "all.glb") / 4);
  EXPECT_EQ(this->Export({ "ring.kds", "no.glb", "--level", "30" }, "glb").exitCode, 2);
  EXPECT_FALSE(fs::exists(this->Folder / "no.glb"));
}

}
