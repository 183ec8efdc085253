// SPDX-License-Identifier: BSD-3-Clause
// The window's legend, in the lower right corner: the map's colours from bottom to top, and classes
// in their order. Nothing is drawn if the colours are not those of an array.
#include "viewer/desktop/window/ColorPanel.h"
#include "viewer/desktop/window/Panels.h"
#include "viewer/session/appearance/ColorLegend.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

constexpr int screenWidth = 1280, screenHeight = 800;
constexpr double stripHeight = 150; // of the strip of previews at the bottom

ImU32 InkOf(const Color& color)
{
  return IM_COL32(color[0], color[1], color[2], 255);
}

// Dear ImGui without a screen.
class TestColorPanel : public ::testing::Test
{
protected:
  TestColorPanel()
  {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = { screenWidth, screenHeight };
    io.DeltaTime = 0.1f;
    unsigned char* pixels = nullptr;
    int columns = 0, rows = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &columns, &rows);
    this->Model.scalars = std::vector<ScalarDescription>{ { "reflectance", -5, 105, 0, 100, {} },
      { "classification", 1, 9, 1, 9, { { 2, 1'800'000 }, { 6, 40'000 }, { 9, 3 } } } };
  }
  ~TestColorPanel() override { ImGui::DestroyContext(); }

  // Returns the vertices of the legend in one frame.
  std::vector<ImDrawVert> Draw(const ColorChoice& colors, double taken = stripHeight)
  {
    PanelFacts facts;
    facts.width = screenWidth;
    facts.height = screenHeight;
    facts.model = &this->Model;
    ImGui::NewFrame();
    DrawColorLegend(facts, colors, taken);
    const ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const std::vector<ImDrawVert> drawn(list.VtxBuffer.begin(), list.VtxBuffer.end());
    ImGui::Render();
    return drawn;
  }

  // The uppermost and the lowest row of all vertices of this colour; nothing if there are none.
  static std::optional<std::pair<float, float>> RowsOf(
    const std::vector<ImDrawVert>& drawn, const Color& color)
  {
    std::optional<std::pair<float, float>> rows;
    for (const ImDrawVert& vertex : drawn)
    {
      if (vertex.col == InkOf(color))
      {
        rows = { std::min(rows ? rows->first : vertex.pos.y, vertex.pos.y),
          std::max(rows ? rows->second : vertex.pos.y, vertex.pos.y) };
      }
    }
    return rows;
  }

  ColorLegend LegendBy(const ColorChoice& colors) const
  {
    return LegendOf(ColoringOf(colors, this->Model.scalars), this->Model.scalars);
  }

  ModelDescription Model;
};

const ColorChoice byMeasure{ SurfaceColoring::Attribute, "reflectance" },
  byClass{ SurfaceColoring::Attribute, "classification" };

TEST_F(TestColorPanel, AMeasureHasItsMapFromBelowToAbove)
{
  for (const ColorMap map : allColorMaps)
  {
    ColorChoice colors = byMeasure;
    colors.map = map;
    const std::vector<ImDrawVert> drawn = this->Draw(colors);
    const ColorLegend legend = this->LegendBy(colors);
    ASSERT_GT(legend.colors.size(), 2U);
    const auto low = RowsOf(drawn, legend.colors.front()),
               middle = RowsOf(drawn, legend.colors[legend.colors.size() / 2]),
               high = RowsOf(drawn, legend.colors.back());
    ASSERT_TRUE(low && middle && high);
    EXPECT_GT(low->first, middle->second);
    EXPECT_GT(middle->first, high->second);
    for (const Color& color : legend.colors) // all lie between the ends of the bar
    {
      const auto rows = RowsOf(drawn, color);
      ASSERT_TRUE(rows);
      EXPECT_LE(rows->second, low->second);
      EXPECT_GE(rows->first, high->first);
    }
    // Each tick has a line and a number of at least one character; and there is the name.
    EXPECT_GE(drawn.size(), 4 * (legend.colors.size() - 1) + 8 * legend.ticks.size());
  }
}

TEST_F(TestColorPanel, ClassesStandInTheOrderOfTheLegend)
{
  const std::vector<ImDrawVert> drawn = this->Draw(byClass);
  const ColorLegend legend = this->LegendBy(byClass);
  ASSERT_EQ(legend.classes.size(), 3U);
  for (std::size_t i = 1; i < legend.classes.size(); ++i)
  {
    const auto above = RowsOf(drawn, legend.classes[i - 1].color),
               here = RowsOf(drawn, legend.classes[i].color);
    ASSERT_TRUE(above && here) << i;
    EXPECT_GT(here->first, above->second) << i;
  }
}

TEST_F(TestColorPanel, ItStandsInTheCornerAboveWhatIsThere)
{
  for (const ColorChoice& colors : { byMeasure, byClass })
  {
    for (const double taken : { 0.0, stripHeight })
    {
      float right = 0, bottom = 0, left = screenWidth;
      for (const ImDrawVert& vertex : this->Draw(colors, taken))
      {
        right = std::max(right, vertex.pos.x);
        bottom = std::max(bottom, vertex.pos.y);
        left = std::min(left, vertex.pos.x);
      }
      EXPECT_NEAR(right, screenWidth - 12, 1);
      EXPECT_NEAR(bottom, screenHeight - 12 - taken, 1);
      EXPECT_GT(left, screenWidth / 2);
    }
  }
}

TEST_F(TestColorPanel, OtherColoursHaveNone)
{
  for (const SurfaceColoring coloring : { SurfaceColoring::Own, SurfaceColoring::Stone,
         SurfaceColoring::Partition, SurfaceColoring::Resolution })
  {
    EXPECT_TRUE(this->Draw({ coloring }).empty());
  }
  EXPECT_TRUE(this->Draw({ SurfaceColoring::Attribute, "another" }).empty());
}

}
}
