// SPDX-License-Identifier: BSD-3-Clause
// Colours by an array: maps, palettes, and what a user's choice means for a model; also the text
// and the legend of a choice.
#include "viewer/session/appearance/ColorLegend.h"
#include "viewer/session/appearance/Coloring.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace kdstream;

namespace
{

double Luma(const Color& color)
{
  return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2];
}

const ScalarDescriptions scalars(
  std::vector<ScalarDescription>{ { "intensity", 0, 65535, 100, 300, {} },
    { "Classification", 2, 9, 2, 9, { { 2, 70 }, { 9, 900 } } },
    { "label", -1, 500, 0, 400, { { -1, 5 }, { 500, 4 } } }, { "flat", 7, 7, 7, 7, {} } });

ColorChoice By(const std::string& name)
{
  return { SurfaceColoring::Attribute, name };
}

}

TEST(ColorMaps, ArePerceptual)
{
  for (const ColorMap map : { ColorMap::Viridis, ColorMap::Cividis })
  {
    for (int i = 0; i < 100; ++i)
    {
      EXPECT_LT(Luma(ColorOf(map, i / 100.0)), Luma(ColorOf(map, (i + 1) / 100.0))) << i;
    }
  }
  for (int i = 0; i < 50; ++i) // pairs from both ends towards the middle
  {
    EXPECT_LT(Luma(ColorOf(ColorMap::Diverging, i / 100.0)),
      Luma(ColorOf(ColorMap::Diverging, (i + 1) / 100.0)));
    EXPECT_LT(Luma(ColorOf(ColorMap::Diverging, 1 - i / 100.0)),
      Luma(ColorOf(ColorMap::Diverging, 1 - (i + 1) / 100.0)));
  }
  EXPECT_EQ(ColorOf(ColorMap::Viridis, 0), (Color{ 0x44, 0x01, 0x54 }));
  EXPECT_EQ(ColorOf(ColorMap::Viridis, 1), (Color{ 0xfe, 0xe7, 0x24 }));
  EXPECT_EQ(ColorOf(ColorMap::Diverging, 0.5), (Color{ 0xdd, 0xdd, 0xdd }));
}

TEST(ColorMaps, HaveNames)
{
  for (const ColorMap map : allColorMaps)
  {
    EXPECT_EQ(ParseColorMap(NameOf(map)), map);
  }
  EXPECT_EQ(ParseColorMap("Viridis"), std::nullopt);
}

TEST(ColorMaps, TakeAnyClass)
{
  EXPECT_EQ(ClassColor(2, true), (Color{ 0xa0, 0x70, 0x3c }));
  EXPECT_NE(ClassColor(2, true), ClassColor(2, false));
  EXPECT_EQ(ClassColor(19, true), ClassColor(19, false)) << "LAS has no such class";
  for (const double value : { -1.0, -1e300, 1e300, 0.5, 65536.0 })
  {
    (void)ClassColor(value, true);
    (void)ClassColor(value, false);
  }
}

TEST(Coloring, FollowsTheChoice)
{
  EXPECT_EQ(ColoringOf({ SurfaceColoring::Partition }, scalars).kind, SurfaceColoring::Partition);
  const Coloring usual = ColoringOf(By("intensity"), scalars);
  EXPECT_EQ(usual.kind, SurfaceColoring::Attribute);
  EXPECT_EQ(usual.Of(100), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(usual.Of(-5), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(usual.Of(200), ColorOf(ColorMap::Viridis, 0.5));
  EXPECT_EQ(usual.Of(1e300), ColorOf(ColorMap::Viridis, 1));
  EXPECT_EQ(usual.Of(std::nan("")), stoneColor);
  ColorChoice all = By("intensity");
  all.map = ColorMap::Cividis;
  all.range = { 0.0, 65535.0 };
  EXPECT_EQ(ColoringOf(all, scalars).Of(65535.0 / 4), ColorOf(ColorMap::Cividis, 0.25));
  const Coloring flat = ColoringOf(By("flat"), scalars);
  EXPECT_EQ(flat.Of(7), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(flat.Of(8), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(ColoringOf(By("unknown"), scalars), Coloring());
  EXPECT_EQ(ColoringOf(By("intensity"), {}), Coloring());
}

TEST(Coloring, GivesClassesTheirOwn)
{
  EXPECT_EQ(ColoringOf(By("Classification"), scalars).Of(9), ClassColor(9, true));
  EXPECT_EQ(ColoringOf(By("label"), scalars).Of(9), ClassColor(9, false));
  ColorChoice ranged = By("label"); // the choice asks for a map
  ranged.range = { 0.0, 10.0 };
  EXPECT_EQ(ColoringOf(ranged, scalars).Of(5), ColorOf(ColorMap::Viridis, 0.5));
}

TEST(Coloring, FindsTheArrayOfAPiece)
{
  Surface surface;
  const auto add = [&](const char* name, std::uint8_t components)
  {
    surface.attributes.push_back(
      { { name, AttributeType::UInt8, AttributeAssociation::Point, components }, { 1, 2, 3 } });
  };
  add("RGB", 3);
  add("intensity", 3);
  EXPECT_EQ(ColoredBy(surface, {}), &surface.attributes[0]);
  EXPECT_EQ(ColoredBy(surface, ColoringOf(By("intensity"), scalars)), nullptr) << "three numbers";
  add("intensity", 1);
  const Attribute* found = ColoredBy(surface, ColoringOf(By("intensity"), scalars));
  ASSERT_EQ(found, &surface.attributes[2]);
  EXPECT_EQ(
    PointColor(*found, ColoringOf(By("intensity"), scalars), 2), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(ColoredBy(surface, SurfaceColoring::Stone), nullptr);
}

TEST(Coloring, ComesBackFromItsText)
{
  std::mt19937 random(3);
  const std::string letters[] = { "a", "Z", "0", "%", ":", "&", " ", "é", "中", "=", "#", "_",
    "~" };
  for (int i = 0; i < 2000; ++i)
  {
    ColorChoice choice = By("");
    for (auto n = random() % 9 + 1; n > 0; --n)
    {
      choice.attribute += letters[random() % std::size(letters)];
    }
    choice.map = allColorMaps[random() % 3];
    if (random() % 2 == 0)
    {
      const double low = std::ldexp(double(random()) - 2e9, int(random() % 200) - 100);
      choice.range = { low, low + std::ldexp(1 + std::abs(low), int(random() % 20)) };
    }
    const std::string text = FormatColors(choice);
    EXPECT_EQ(
      text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                             "%:-._+"),
      std::string::npos)
      << text;
    EXPECT_EQ(ParseColors(text), choice) << text;
  }
  EXPECT_EQ(FormatColors(By("intensity")), "by:intensity");
  for (const char* word : { "own", "none", "partition", "resolution" })
  {
    EXPECT_EQ(FormatColors(*ParseColors(word)), word);
  }
}

TEST(Coloring, RefusesOtherTexts)
{
  for (const char* text : { "", "by", "by:", "Own", "by:a:", "by:a:red", "by:a:viridis:1",
         "by:a:viridis:1:1", "by:a:viridis:2:1", "by:a:viridis:nan:1", "by:a:viridis:0:1e999",
         "by:a:viridis:0:1:2", "by:%", "by:%4", "by:%zz", "by:%00", "by:a%ff", "by:a:viridis:[]:1",
         "by:a:viridis:-1e308:1e308" })
  {
    if (std::string(text) != "by:a:") // no map is named, as in "by:a"
    {
      EXPECT_EQ(ParseColors(text), std::nullopt) << text;
    }
  }
  std::mt19937 random(4);
  const std::string good = "by:intensity:viridis:-1.5e3:22";
  for (int i = 0; i < 20000; ++i)
  {
    std::string text = good;
    for (auto n = random() % 4 + 1; n > 0; --n)
    {
      text[random() % text.size()] = static_cast<char>(random());
    }
    (void)ParseColors(text);
  }
}

TEST(ColorLegend, HasRoundNumbers)
{
  const auto numbers = [](double low, double high) { return RoundNumbers(low, high); };
  EXPECT_EQ(numbers(0, 1), (std::vector<double>{ 0, 0.2, 0.4, 0.6, 0.8, 1 }));
  EXPECT_EQ(numbers(3870, 8743), (std::vector<double>{ 4000, 5000, 6000, 7000, 8000 }));
  EXPECT_EQ(numbers(-0.25, 0.3), (std::vector<double>{ -0.2, -0.1, 0, 0.1, 0.2, 0.3 }));
  std::mt19937 random(5);
  for (int i = 0; i < 5000; ++i)
  {
    const double low = std::ldexp(double(random()) - 2e9, int(random() % 400) - 200);
    const double high = low + std::ldexp(double(random()) + 1, int(random() % 400) - 200);
    if (!(low < high))
    {
      continue;
    }
    const std::vector<double> found = numbers(low, high);
    ASSERT_GE(found.size(), 2U) << low << " " << high;
    ASSERT_LE(found.size(), 7U) << low << " " << high;
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    EXPECT_GE(found.front(), low);
    EXPECT_LE(found.back(), high);
  }
}

TEST(ColorLegend, ReportsMeasuresAndClasses)
{
  const ColorLegend measure = LegendOf(ColoringOf(By("intensity"), scalars), scalars);
  EXPECT_EQ(measure.colors.front(), ColorOf(ColorMap::Viridis, 0));
  EXPECT_EQ(measure.colors.back(), ColorOf(ColorMap::Viridis, 1));
  ASSERT_EQ(measure.ticks.size(), 5U);
  EXPECT_EQ(measure.ticks[2].value, 200);
  EXPECT_EQ(measure.ticks[2].share, 0.5);
  const ColorLegend classes = LegendOf(ColoringOf(By("Classification"), scalars), scalars);
  ASSERT_EQ(classes.classes.size(), 2U);
  EXPECT_EQ(classes.classes[0].name, "ground");
  EXPECT_EQ(classes.classes[0].vertices, 70U);
  EXPECT_EQ(classes.classes[1].name, "water");
  const ColorLegend flat = LegendOf(ColoringOf(By("flat"), scalars), scalars);
  EXPECT_EQ(flat.colors, std::vector<Color>(2, ColorOf(ColorMap::Viridis, 0)));
  ASSERT_EQ(flat.ticks.size(), 1U);
  EXPECT_EQ(flat.ticks[0].value, 7);
  EXPECT_TRUE(LegendOf({}, scalars).colors.empty());
}

TEST(ColorLegend, OfManyClassesReportsTheMostFrequentByNumber)
{
  ScalarDescription many{ "kind", 0, 29, 0, 29, {} };
  for (int i = 0; i < 30; ++i)
  {
    many.classes.push_back({ double(i), std::uint64_t(i < 5 ? 1 : 10 + i / 2) });
  }
  const ScalarDescriptions all(std::vector<ScalarDescription>{ many });
  const ColorLegend legend = LegendOf(ColoringOf(By("kind"), all), all);
  ASSERT_EQ(legend.classes.size(), ColorLegend::mostClasses);
  for (std::size_t i = 0; i < legend.classes.size(); ++i)
  {
    EXPECT_EQ(legend.classes[i].value, double(10 + i));
  }
}
