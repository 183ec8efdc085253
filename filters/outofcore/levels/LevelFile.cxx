// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/LevelFile.h"

#include "filters/core/GhostCorners.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ScatteredRead.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{

std::vector<VertexId> LevelBlock::Ghosts() const
{
  std::vector<VertexId> ghosts(
    this->clusters.begin(), this->clusters.begin() + std::ptrdiff_t(this->ownBegin));
  ghosts.insert(
    ghosts.end(), this->clusters.begin() + std::ptrdiff_t(this->ownEnd), this->clusters.end());
  return ghosts;
}

Result<LevelBlock> LoadLevelBlock(const LevelFile& level, std::size_t block)
{
  const VertexId first = level.begin[block], end = level.begin[block + 1];
  LevelBlock loaded;
  loaded.triangles.resize(
    static_cast<std::size_t>(level.triangleBegin[block + 1] - level.triangleBegin[block]));
  KDSTREAM_TRY(ReadRecords<Triangle>(
    level.triangles, level.triangleBegin[block], std::span<Triangle>(loaded.triangles)));
  const GhostCorners corners(loaded.triangles, first, end);
  const std::vector<VertexId> ghosts = corners.Vertices();

  const auto above = std::lower_bound(ghosts.begin(), ghosts.end(), first);
  loaded.clusters.reserve(ghosts.size() + (end - first));
  loaded.clusters.assign(ghosts.begin(), above);
  loaded.ownBegin = static_cast<VertexId>(loaded.clusters.size());
  for (VertexId c = first; c < end; ++c)
  {
    loaded.clusters.push_back(c);
  }
  loaded.ownEnd = static_cast<VertexId>(loaded.clusters.size());
  loaded.clusters.insert(loaded.clusters.end(), above, ghosts.end());
  for (Triangle& t : loaded.triangles) // local numbers ascend with the numbers in the level: the
                                       // order stays
  {
    for (VertexId& corner : t)
    {
      corner = loaded.ownBegin + (corner - first);
    }
  }
  corners.ReplaceIn(loaded.triangles,
    [&](std::size_t place)
    {
      const auto ghost = static_cast<VertexId>(place);
      return ghost < loaded.ownBegin ? ghost : ghost + (end - first);
    });
  return loaded;
}

Status ReadBlockElements(const SpillFile& file, std::size_t elementBytes, const LevelBlock& block,
  std::span<std::byte> out)
{
  const std::span<const VertexId> all(block.clusters);
  const std::size_t begin = block.ownBegin, end = block.ownEnd;
  KDSTREAM_TRY(
    ReadElementsAt(file, elementBytes, all.first(begin), out.first(begin * elementBytes)));
  if (end > begin)
  {
    KDSTREAM_TRY(file.Read(std::uint64_t{ all[begin] } * elementBytes,
      out.subspan(begin * elementBytes, (end - begin) * elementBytes)));
  }
  return ReadElementsAt(file, elementBytes, all.subspan(end), out.subspan(end * elementBytes));
}

Result<std::vector<Triangle>> LoadAllTriangles(const LevelFile& level)
{
  std::vector<Triangle> all;
  for (std::size_t block = 0; block < level.BlockCount(); ++block)
  {
    KDSTREAM_TRY(ForEachBlockOf<Triangle>(level.triangles, level.triangleBegin[block],
      level.triangleBegin[block + 1],
      [&](std::span<const Triangle> triangles)
      {
        std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(all),
          [&](const Triangle& t)
          { return t[0] >= level.begin[block] && t[0] < level.begin[block + 1]; });
      }));
  }
  return all;
}

Result<LevelBlock> LoadWholeLevel(const LevelFile& level)
{
  Result<std::vector<Triangle>> triangles = LoadAllTriangles(level);
  KDSTREAM_TRY(triangles);
  LevelBlock whole;
  whole.clusters.resize(level.ClusterCount());
  std::iota(whole.clusters.begin(), whole.clusters.end(), VertexId{ 0 });
  whole.ownEnd = level.ClusterCount();
  whole.triangles = std::move(*triangles);
  return whole;
}

Status ImageWriter::Begin(std::uint64_t expected)
{
  Result<SpillFile> file =
    this->Folder.CreateFile("triangles of a level", expected * sizeof(Triangle));
  KDSTREAM_TRY(file);
  this->Level.triangles = std::move(*file);
  this->Level.triangleBegin.assign(1, 0);
  return {};
}

Status ImageWriter::Add(std::vector<Triangle>& mapped)
{
  const std::size_t block = this->Level.triangleBegin.size() - 1;
  const VertexId first = this->Level.begin[block], end = this->Level.begin[block + 1];
  const auto own = [&](VertexId c) { return c >= first && c < end; };
  std::erase_if(mapped,
    [&](const Triangle& t) { return IsDegenerate(t) || !(own(t[0]) || own(t[1]) || own(t[2])); });
  std::transform(mapped.begin(), mapped.end(), mapped.begin(), RotateLowestFirst);
  if (!std::is_sorted(mapped.begin(), mapped.end()))
  {
    std::sort(mapped.begin(), mapped.end());
  }
  mapped.erase(std::unique(mapped.begin(), mapped.end()), mapped.end());
  this->Triangles += static_cast<std::uint64_t>(
    std::count_if(mapped.begin(), mapped.end(), [&](const Triangle& t) { return own(t[0]); }));
  const std::uint64_t written = this->Level.triangleBegin.back();
  this->Level.triangleBegin.push_back(written + mapped.size());
  return WriteRecords<Triangle>(this->Level.triangles, written, std::span<const Triangle>(mapped));
}

}
