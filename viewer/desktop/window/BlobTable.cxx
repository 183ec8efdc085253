// SPDX-License-Identifier: BSD-3-Clause
// Tables of what is shown and of the blobs that were fetched for it: see Panels.h.

#include "filters/program/ProgressReporter.h"
#include "viewer/desktop/window/Panels.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace kdstream
{
namespace
{

void Row(const char* what, const std::string& value)
{
  ImGui::TableNextColumn();
  ImGui::TextDisabled("%s", what);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
}

std::string Number(double value, const char* format)
{
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string ShareOfOriginal(const PanelFacts& facts)
{
  const ModelDescription& model = *facts.model;
  const bool hasTriangles = model.triangles > 0;
  const auto shown =
    static_cast<double>(hasTriangles ? facts.status.triangles : facts.status.vertices);
  const auto all = static_cast<double>(hasTriangles ? model.triangles : model.vertices);
  return CountText(shown) + " of " + CountText(all) + " (" +
         Number(all > 0 ? 100 * shown / all : 0, "%.3g") + " %)";
}

std::string RegionText(const ViewerStatus& status)
{
  return status.region ? "partition " + std::to_string(status.region->cell) + ", " +
                           std::to_string(status.region->shown) + " of " +
                           std::to_string(status.region->partitions) + " partitions"
                       : "none: double-click the surface";
}

// Ends the table. Returns the width of a window around it at which no column is cut off.
float EndTable()
{
  const ImGuiTable& table = *ImGui::GetCurrentTable();
  const ImGuiStyle& style = ImGui::GetStyle();
  const bool scrolls = (table.Flags & ImGuiTableFlags_ScrollY) != 0;
  const float width =
    table.ColumnsAutoFitWidth + 2 * style.WindowPadding.x + (scrolls ? style.ScrollbarSize : 0);
  ImGui::EndTable();
  return width;
}

}

float DrawFacts(const PanelFacts& facts)
{
  if (!ImGui::BeginTable("##facts", 2, ImGuiTableFlags_SizingFixedFit))
  {
    return 0;
  }
  const ViewerStatus& status = facts.status;
  if (facts.model && status.shownLevel)
  {
    Row("Shown level",
      std::to_string(*status.shownLevel) + " of " + std::to_string(facts.model->depths.finest) +
        (status.original ? ", and original" : "") +
        (status.targetLevel ? "; wanted " + std::to_string(*status.targetLevel) : ""));
    Row("Share of the original", ShareOfOriginal(facts));
    Row("Remaining error", Number(status.remainingError, "%.1f") + " points");
    Row("Region", RegionText(status));
  }
  const auto fromCache = std::count_if(facts.blobs->begin(), facts.blobs->end(),
    [](const BlobStatistics& blob) { return blob.fromCache; });
  Row("Received", BytesText(static_cast<double>(facts.traffic.bytes)) + " in " +
                    std::to_string(facts.traffic.blobs) + " blobs, " +
                    BytesText(static_cast<double>(facts.traffic.wasted)) + " not used");
  Row("From the cache", std::to_string(fromCache) + " of " + std::to_string(facts.blobs->size()));
  Row("Memory", BytesText(static_cast<double>(facts.residentBytes)));
  Row("A frame", Number(1000 * facts.frameSeconds, "%.1f ms"));
  return EndTable();
}

float DrawBlobTable(const std::deque<BlobStatistics>& blobs, double ratio)
{
  static constexpr std::array<const char*, 8> heads{ "Blob", "Vertices", "Triangles", "Bytes",
    "Sent ms", "Parsed ms", "Drawn ms", "Cache" };
  constexpr ImGuiTableFlags flags = ImGuiTableFlags_ScrollY | ImGuiTableFlags_RowBg |
                                    ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_BordersInnerV;
  const ImVec2 room(0, std::max(ImGui::GetContentRegionAvail().y, static_cast<float>(80 * ratio)));
  if (!ImGui::BeginTable("##blobs", static_cast<int>(heads.size()), flags, room))
  {
    return 0;
  }
  ImGui::TableSetupScrollFreeze(0, 1);
  for (const char* head : heads)
  {
    ImGui::TableSetupColumn(head);
  }
  ImGui::TableHeadersRow();
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(blobs.size()));
  while (clipper.Step())
  {
    for (int row = clipper.DisplayStart; row < clipper.DisplayEnd; ++row)
    {
      const BlobStatistics& blob = blobs[blobs.size() - 1 - static_cast<std::size_t>(row)];
      for (const std::string& text :
        { blob.id, std::to_string(blob.vertices), std::to_string(blob.triangles),
          std::to_string(blob.bytes), Number(1000 * blob.transmissionSeconds, "%.2f"),
          Number(1000 * blob.parsingSeconds, "%.2f"), Number(1000 * blob.renderingSeconds, "%.2f"),
          std::string(blob.fromCache ? "yes" : "") })
      {
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(text.c_str());
      }
    }
  }
  return EndTable();
}

}
