// SPDX-License-Identifier: BSD-3-Clause
// Colours of every kind become the array that viewers show, with any chunk size; the file's own
// arrays stay.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/ShownColors.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace kdstream::test
{
namespace
{

struct Case
{
  std::vector<std::string> properties; // of a vertex, after z
  std::vector<std::string> values;     // of two vertices
  std::string reading;                 // what is reported; empty if nothing is
  std::vector<double> colors;          // expected; empty if there are none
};

Contents ReadPly(const Case& c, std::size_t limit)
{
  std::string text = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                     "property float y\nproperty float z\n";
  for (const std::string& property : c.properties)
  {
    text += "property " + property + "\n";
  }
  text += "end_header\n0 0 0 " + c.values[0] + "\n1 0 0 " + c.values[1] + "\n";
  const fixtures::TemporaryFolder folder;
  return ReadAll(folder.Write("c.ply", text), [&] { return limit; });
}

const Attribute* FindShown(const Mesh& mesh)
{
  const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Colors; });
  return found == mesh.attributes.end() ? nullptr : &*found;
}

}

TEST(ShownColors, OfAllKinds)
{
  const std::string taken = " are taken for colours, of which ";
  const std::vector<double> redAndGrey{ 255, 0, 0, 51, 51, 51 };
  const Case cases[] = {
    { { "float red", "float green", "float blue" }, { "1 0 0", "0.2 0.2 0.2" },
      "red, green, blue of type float32" + taken + "1 is white, and shown as RGB", redAndGrey },
    { { "double r", "double g", "double b" }, { "255 0 0", "51 51 51" },
      "r, g, b of type float64" + taken + "255 is white, and shown as RGB", redAndGrey },
    { { "uchar ambient_red", "uchar ambient_green", "uchar ambient_blue" },
      { "255 0 0", "51 51 51" },
      "ambient_red, ambient_green, ambient_blue of type uint8" + taken +
        "255 is white, and shown as RGB",
      redAndGrey },
    { { "uint rgba" }, { "4294901760", "3355443" },
      "rgba is taken for colours of three bytes in a number (0xRRGGBB), and shown as RGB",
      redAndGrey },
    { { "int Rgb" }, { "-65536", "3355443" },
      "Rgb is taken for colours of three bytes in a number (0xRRGGBB), and shown as RGB",
      redAndGrey },
    { { "ushort diffuse_red", "ushort diffuse_green", "ushort diffuse_blue" },
      { "65535 0 0", "13107 13107 13107" },
      "diffuse_red, diffuse_green, diffuse_blue of type uint16" + taken +
        "65535 is white, and shown as RGB",
      redAndGrey },
    { { "ushort Red", "ushort Green", "ushort Blue" }, { "255 0 0", "51 51 51" },
      "Red, Green, Blue of type uint16" + taken + "255 is white, and shown as RGB", redAndGrey },
    { { "float red", "float green", "float blue" }, { "1.001 0 0", "0.2 0.2 0.2" },
      "red, green, blue of type float32" + taken +
        "1 is white, as most of their values are: 1 of 4 is above it and counts as white, and "
        "shown "
        "as RGB",
      redAndGrey },
    { { "uchar Red", "uchar Green", "uchar Blue" }, { "255 0 0", "51 51 51" }, "", redAndGrey },
    { { "uchar R", "uchar G", "uchar B" }, { "255 0 0", "51 51 51" }, "", redAndGrey },
    { { "uchar diffuse_red", "uchar diffuse_green", "uchar diffuse_blue" },
      { "255 0 0", "51 51 51" }, "", redAndGrey },
    { { "float f_dc_0", "float f_dc_1", "float f_dc_2", "float opacity" },
      { "1.7724539 -1.7724539 -9 1", "0 0 0 1" },
      "f_dc is taken for the colours of Gaussian splats, and shown as RGB",
      { 255, 0, 0, 128, 128, 128 } },
    { { "float color_0", "float color_1", "float color_2" }, { "1 0 0", "0.2 0.2 0.2" },
      "color of type float32" + taken + "1 is white, and shown as RGB", redAndGrey },
    { { "float rgb" }, { "2.3418052e-38", "4.7019771e-39" },
      "rgb is taken for colours of three bytes in a number (0xRRGGBB), and shown as RGB",
      redAndGrey },
    { { "float rgba" }, { "-1.7014118e+38", "0" },
      "rgba is taken for colours of three bytes in a number (0xRRGGBB), and shown as RGB",
      { 0, 0, 0, 0, 0, 0 } },
    { { "double rgb" }, { "16711680", "3355443" },
      "rgb is taken for colours of three bytes in a number (0xRRGGBB), and shown as RGB",
      redAndGrey },
    { { "float rgb" }, { "0.25", "1" },
      "rgb of type float32 is not shown: its values are not colours packed into numbers "
      "(0xRRGGBB). Colours are shown as red, green and blue",
      {} },
    { { "uchar rgb" }, { "25", "1" },
      "rgb of type uint8 is not shown: its values are not colours packed into numbers (0xRRGGBB). "
      "Colours are shown as red, green and blue",
      {} },
    { { "float red", "float green" }, { "1 0", "0 1" }, "", {} },
    { { "uchar red", "uchar green", "uchar blue", "float r", "float g", "float b" },
      { "255 0 0 0 1 0", "51 51 51 0 1 0" }, "", redAndGrey },
  };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.properties[0]);
    for (const std::size_t limit : { everything, std::size_t{ 1 } })
    {
      const Contents read = ReadPly(c, limit);
      ASSERT_TRUE(read.status) << read.status.GetError().message;
      EXPECT_EQ(read.info.tolerance.Warnings(),
        c.reading.empty() ? std::vector<std::string>() : std::vector{ c.reading });
      ASSERT_EQ(read.mesh.attributes.size(), read.info.attributes.size());
      std::size_t components = 0;
      for (std::size_t k = 0; k < read.info.attributes.size(); ++k)
      {
        EXPECT_EQ(read.mesh.attributes[k].Info(), read.info.attributes[k]);
        EXPECT_EQ(read.mesh.attributes[k].TupleCount(), 2U);
        components += read.info.attributes[k].components;
      }
      const bool isMade = !c.reading.empty() && !c.colors.empty();
      EXPECT_EQ(components, c.properties.size() + (isMade ? 3 : 0)) << "nothing is lost";
      const Attribute* const shown = FindShown(read.mesh);
      ASSERT_EQ(shown != nullptr, !c.colors.empty());
      for (std::size_t i = 0; i < c.colors.size(); ++i)
      {
        EXPECT_EQ(shown->Get(i / 3, i % 3), c.colors[i]) << i;
      }
    }
  }
}

TEST(ColorWhite, IsWhatMostValuesSay)
{
  struct Case
  {
    std::vector<double> values;
    double white;
    std::string doubt;
    bool whole = false;
  };
  const std::string most = "as most of their values are: ";
  const Case cases[] = {
    { {}, 1, "" },
    { { 0, 0, NAN, INFINITY, -INFINITY }, 1, "" },
    { { 1, 0, 1 }, 1, "" },
    { { 0.5, 0.9, 0.25, 1.001 }, 1, most + "1 of 4 is above it and counts as white" },
    { { 0.5, 0.9, 0.25, 2, 4000 }, 1, most + "2 of 5 are above it and count as white" },
    { { 0.5, INFINITY }, 1, "" },
    { { 200, 100, 50, 256 }, 255, most + "1 of 4 is above it and counts as white" },
    { { 200, 100, 50, 256 }, 255, most + "1 of 4 is above it and counts as white", true },
    { { 1, 1, 1, 200 }, 255, "", true },
    { { 200, 100, 0.5 }, 255, most + "1 of 3 is below 1 and counts as black" },
    { { 60000, 30000, 10000 }, 65535, "" },
    { { 60000, 30000, 100 }, 65535, most + "1 of 3 is at most 255 and counts as black" },
    { { 0.5, -0.5 }, 1, "1 of 2 is below 0 and counts as 0" },
  };
  for (const Case& c : cases)
  {
    ColorWhite white;
    for (const double value : c.values)
    {
      white.Add(value, c.whole);
    }
    SCOPED_TRACE(c.values.size());
    EXPECT_EQ(white.White(), c.white);
    EXPECT_EQ(white.Doubt(), c.doubt);
  }
}

TEST(ShownColors, AreDroppedWithTheirPoints)
{
  const fixtures::TemporaryFolder folder;
  const Contents read =
    ReadAll(folder.Write("c.ply",
              "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
              "property float z\nproperty float red\nproperty float green\nproperty float blue\n"
              "end_header\n0 0 0 1 0 0\nnan 0 0 0 1 0\n2 0 0 0 0 1\n"),
      [] { return std::size_t{ 2 }; });
  ASSERT_TRUE(read.status);
  const Attribute* const shown = FindShown(read.mesh);
  ASSERT_TRUE(shown);
  EXPECT_EQ(shown->values, (std::vector<std::uint8_t>{ 255, 0, 0, 0, 0, 255 }));
  EXPECT_EQ(read.mesh.attributes[0].TupleCount(), 2U);
}

TEST(ShownColors, AnArrayThatHasTheNameStays)
{
  Mesh mesh;
  mesh.points.resize(1);
  Attribute colors{ { "RGB", AttributeType::Float32, AttributeAssociation::Point, 3 }, {} };
  colors.values.resize(12);
  colors.Set(0, 1, 1);
  mesh.attributes.push_back(colors);
  Tolerance tolerance;
  AddShownColors(mesh, tolerance);
  ASSERT_EQ(mesh.attributes.size(), 2U);
  EXPECT_EQ(mesh.attributes[1].name, "RGBA");
  EXPECT_EQ(mesh.attributes[1].values, (std::vector<std::uint8_t>{ 0, 255, 0, 255 }));
  EXPECT_EQ(tolerance.Warnings().size(), 1U);
}

}
