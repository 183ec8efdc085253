// SPDX-License-Identifier: BSD-3-Clause
// The ranges of the arrays that viewers can colour by; the order of pieces must not matter.
#include "filters/store/ScalarStatistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace kdstream;

namespace
{

const AttributeInfo intensity{ "intensity", AttributeType::UInt16, AttributeAssociation::Point, 1 };
const AttributeInfo height{ "height", AttributeType::Float64, AttributeAssociation::Point, 1 };
const AttributeInfo kind{ "classification", AttributeType::UInt8, AttributeAssociation::Point, 1 };
const std::vector<AttributeInfo> all{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point,
                                        3 },
  intensity, { "area", AttributeType::Float32, AttributeAssociation::Cell, 1 }, height, kind };

// A piece with `own` own vertices, and one ghost whose values do not count.
Piece PieceOf(NodeId node, std::uint32_t own, std::mt19937& random)
{
  Piece piece;
  piece.id = { Resolution::Original(), node };
  piece.ownVertices = own;
  for (const AttributeInfo& info : all)
  {
    Attribute& array = piece.attributes.emplace_back(Attribute{ info, {} });
    array.values.resize((own + 1) * info.TupleSize());
    for (std::size_t v = 0; v <= own && info.components == 1; ++v)
    {
      const double value = info == kind     ? double(random() % 7)
                           : info == height ? double(random() % 100000) / 100000
                                            : double(random() % 4000);
      array.Set(v, 0, v == own ? 65000 : value);
    }
  }
  return piece;
}

}

TEST(ScalarStatistics, AreExactWhereAllFitTheSample)
{
  std::mt19937 random(7);
  ScalarStatistics statistics(all);
  std::vector<double> values;
  std::uint64_t threes = 0;
  for (NodeId node = 8; node < 16; ++node)
  {
    const Piece piece = PieceOf(node, 500, random);
    for (std::size_t v = 0; v < 500; ++v)
    {
      values.push_back(piece.attributes[1].Get(v, 0));
      threes += piece.attributes[4].Get(v, 0) == 3;
    }
    statistics.Add(piece);
  }
  const std::vector<ScalarDescription> found = statistics.Describe();
  ASSERT_EQ(found.size(), 3U);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(found[0].name, "intensity");
  EXPECT_EQ(found[0].least, values.front());
  EXPECT_EQ(found[0].most, values.back());
  EXPECT_EQ(found[0].low, values[79]);
  EXPECT_EQ(found[0].high, values[3999 - 79]);
  EXPECT_TRUE(found[0].classes.empty());
  EXPECT_TRUE(found[1].classes.empty());
  ASSERT_EQ(found[2].classes.size(), 7U);
  EXPECT_EQ(found[2].classes[3], (ScalarDescription::Class{ 3, threes }));
}

TEST(ScalarStatistics, DoNotDependOnTheOrderOfPieces)
{
  std::mt19937 random(8);
  std::vector<Piece> pieces;
  for (NodeId node = 128; node < 256; ++node)
  {
    pieces.push_back(PieceOf(node, 2000, random));
  }
  ScalarStatistics forwards(all);
  std::for_each(pieces.begin(), pieces.end(), [&](const Piece& piece) { forwards.Add(piece); });
  std::shuffle(pieces.begin(), pieces.end(), random);
  ScalarStatistics shuffled(all);
  std::for_each(pieces.begin(), pieces.end(), [&](const Piece& piece) { shuffled.Add(piece); });
  const std::vector<ScalarDescription> found = forwards.Describe();
  EXPECT_TRUE(found == shuffled.Describe());
  EXPECT_NEAR(found[1].low, 0.02, 0.002) << "of a quarter of the vertices";
  EXPECT_NEAR(found[1].high, 0.98, 0.002);
  EXPECT_NEAR(found[0].low, 80, 8);
}

TEST(ScalarStatistics, LeaveOutWhatIsNotFinite)
{
  const AttributeInfo heights[] = { height };
  ScalarStatistics statistics(heights);
  Piece piece;
  piece.id = { Resolution::Original(), 1 };
  piece.ownVertices = 4;
  piece.attributes.push_back({ height, {} });
  piece.attributes[0].values.resize(4 * sizeof(double));
  const double values[] = { -2, std::numeric_limits<double>::quiet_NaN(),
    std::numeric_limits<double>::infinity(), 5 };
  for (std::size_t v = 0; v < 4; ++v)
  {
    piece.attributes[0].Set(v, 0, values[v]);
  }
  EXPECT_EQ(
    statistics.Describe(), (std::vector<ScalarDescription>{ { "height", 0, 0, 0, 0, {} } }));
  statistics.Add(piece);
  EXPECT_EQ(
    statistics.Describe(), (std::vector<ScalarDescription>{ { "height", -2, 5, -2, 5, {} } }));
}

TEST(ScalarStatistics, ReportNoClassesBeyond256)
{
  const AttributeInfo label{ "label", AttributeType::Int32, AttributeAssociation::Point, 1 };
  for (const std::uint32_t count : { 256U, 257U })
  {
    ScalarStatistics statistics({ &label, 1 });
    Piece piece;
    piece.id = { Resolution::Original(), 1 };
    piece.ownVertices = count;
    piece.attributes.push_back({ label, std::vector<std::uint8_t>(count * 4) });
    for (std::uint32_t v = 0; v < count; ++v)
    {
      piece.attributes[0].Set(v, 0, -double(v) * 1000);
    }
    statistics.Add(piece);
    const ScalarDescription found = statistics.Describe().front();
    EXPECT_EQ(found.classes.size(), count == 256 ? 256U : 0U);
    EXPECT_EQ(found.least, -double(count - 1) * 1000);
  }
}

TEST(ScalarStatistics, LookAtTheFirstSixteenArrays)
{
  std::vector<AttributeInfo> many;
  for (int i = 0; i < 20; ++i)
  {
    many.push_back(
      { "a" + std::to_string(i), AttributeType::Float32, AttributeAssociation::Point, 1 });
  }
  EXPECT_EQ(ScalarStatistics::ArraysOf(many).size(), mostScalars);
  EXPECT_EQ(ScalarStatistics(many).SampleSize(), 32768U);
  const AttributeInfo own[] = { { "vtkGhostType", AttributeType::UInt8 }, height };
  EXPECT_EQ(ScalarStatistics::ArraysOf(own), std::vector<AttributeInfo>{ height });
}
