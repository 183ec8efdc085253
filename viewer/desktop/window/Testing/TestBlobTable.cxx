// SPDX-License-Identifier: BSD-3-Clause
// The table of blobs: every column can be read if the window is as wide as the table asks for.
#include "viewer/desktop/window/Panels.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>

#include <cfloat>
#include <string>

namespace kdstream
{
namespace
{

// Dear ImGui without a screen.
class TestBlobTable : public ::testing::Test
{
protected:
  TestBlobTable()
  {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = { 1280, 800 };
    io.DeltaTime = 0.1f;
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  }
  ~TestBlobTable() override { ImGui::DestroyContext(); }

  // Draws one frame of a window of this width. Returns the width that the table asks for.
  float Draw(float windowWidth)
  {
    ImGui::NewFrame();
    ImGui::SetNextWindowSize({ windowWidth, 400 });
    ImGui::Begin("Details");
    const float wanted = DrawBlobTable(this->Blobs, 1);
    const ImGuiTable* table = ImGui::TableFindByID(ImGui::GetID("##blobs"));
    EXPECT_NE(table, nullptr);
    this->CutOff.clear();
    for (int i = 0; table && i < table->ColumnsCount; ++i)
    {
      const ImGuiTableColumn& column = table->Columns[i];
      if (column.WorkMinX + column.WidthAuto > table->InnerClipRect.Max.x + 0.5f)
      {
        this->CutOff += std::string(this->CutOff.empty() ? "" : ", ") + std::to_string(i);
      }
    }
    ImGui::End();
    ImGui::Render();
    return wanted;
  }

  std::deque<BlobStatistics> Blobs;
  std::string CutOff; // columns
};

TEST_F(TestBlobTable, EveryColumnCanBeRead)
{
  for (int i = 0; i < 100; ++i)
  {
    BlobStatistics blob;
    blob.id = "partitions/" + std::to_string(1000000 + i);
    blob.vertices = 123456;
    blob.triangles = blob.bytes = 1234567890;
    blob.transmissionSeconds = 12.3456;
    blob.fromCache = true;
    this->Blobs.push_back(blob);
  }
  float width = 300;
  for (int frame = 0; frame < 4; ++frame)
  {
    width = std::max(width, this->Draw(width));
  }
  EXPECT_GT(width, 400);
  EXPECT_LT(width, 900);
  EXPECT_EQ(this->CutOff, "");
  this->Draw(width - 30);
  this->Draw(width - 30);
  EXPECT_EQ(this->CutOff, "7") << "the test sees what is cut off";
}

}
}
