// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/PrintStoreInfo.h"

#include "filters/app/DirectionText.h"
#include "filters/core/Texts.h"

#include <cstdio>
#include <iostream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace kdstream
{
namespace
{

// Prints a line for each level, and the meaning of the last two columns.
void PrintLevels(const ModelDescription& info)
{
  std::printf("\n%5s %10s %10s %7s %11s %12s %12s\n", "level", "vertices", "triangles", "pieces",
    "bytes", "deviation", "of 99 %");
  for (unsigned depth = 0; depth < info.levels.size(); ++depth)
  {
    const ResolutionDescription& level = info.levels[depth];
    std::printf("%5u %10llu %10llu %7llu %11llu %12.6g %12.6g\n", depth,
      static_cast<unsigned long long>(level.vertices),
      static_cast<unsigned long long>(level.triangles),
      static_cast<unsigned long long>(level.pieces), static_cast<unsigned long long>(level.bytes),
      level.geometricError, level.geometricError99);
  }
  const std::string unit = info.unit.empty() ? "in the unit of the coordinates" : "in " + info.unit;
  std::cout
    << "\ndeviation  upper bound of the distance of the original from the level, " << unit
    << ".\n"
       "of 99 %    distance of the level's vertices from the original that 99 of 100 do not "
       "exceed.\n"
       "           This is an estimate; use kdstream-store distance to measure a level.\n";
}

}

void PrintStoreInfo(const ModelDescription& info, std::uintmax_t bytes)
{
  const auto line = [](const char* name, const auto& value)
  {
    if constexpr (std::is_convertible_v<decltype(value), std::string_view>)
    {
      std::cout << name << WithoutControls(value) << "\n";
    }
    else
    {
      std::cout << name << value << "\n";
    }
  };
  line("input                ", info.input);
  for (const auto& [name, value] : { std::pair{ "title                ", info.title },
         { "description          ", info.description }, { "credit               ", info.credit },
         { "license              ", info.license }, { "unit                 ", info.unit } })
  {
    if (!value.empty())
    {
      line(name, value);
    }
  }
  if (info.homeView)
  {
    const char* const guessed = info.homeView->guessed ? " (guessed)" : "";
    line("up                   ", DirectionText(info.homeView->up) + guessed);
    line("first view from      ", DirectionText(info.homeView->view) + guessed);
  }
  line("vertices             ", info.vertices);
  line("triangles            ", info.triangles);
  if (info.unused)
  {
    line("unused vertices      ", UnusedText(info) + ": kept in the original, not shown");
  }
  line("welded vertices      ", info.welded);
  line("inconsistent edges   ", info.inconsistentEdges);
  line("precision            ",
    info.grid.Lossless() ? "lossless" : std::to_string(info.grid.bits) + " bits");
  line("partitions           ", info.partitions);
  line("partitioner          ", info.partitioner);
  line("partition vertices   ",
    std::to_string(info.smallestPartition) + " to " + std::to_string(info.largestPartition));
  for (const AttributeInfo& attribute : info.attributes)
  {
    const bool point = attribute.association == AttributeAssociation::Point;
    line("attribute            ", attribute.name + ": " + std::to_string(attribute.components) +
                                    " " + std::string(NameOf(attribute.type)) +
                                    (point ? " a vertex" : " a triangle"));
  }
  line("partition bytes      ", info.original.bytes);
  if (info.textures)
  {
    line("texture bytes        ", std::to_string(info.textures->bytes) + " (" +
                                    info.textures->format +
                                    (info.textures->lossless ? ", lossless" : "") + "), " +
                                    std::to_string(info.textures->texels) + " texels");
  }
  if (info.textures && info.textures->levels)
  {
    std::uint64_t tileBytes = 0, texels = 0;
    for (const ResolutionDescription& level : info.levels)
    {
      tileBytes += level.tileBytes;
      texels += level.texels;
    }
    line("level texture bytes  ",
      std::to_string(tileBytes) + ", " + std::to_string(texels) + " texels");
  }
  line("store bytes          ", bytes);
  line("digest               ", info.digest);
  if (!info.inputDigest.empty())
  {
    line("input digest         ", info.inputDigest);
  }
  if (!info.HasLevels())
  {
    return;
  }
  PrintLevels(info);
}

}
