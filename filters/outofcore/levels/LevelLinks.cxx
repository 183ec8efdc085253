// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/LevelLinks.h"

#include "filters/core/levels/ClusterRound.h"
#include "filters/outofcore/files/RecordFile.h"

namespace kdstream
{

Status LevelLinks::Load(
  std::size_t firstBlock, std::size_t endBlock, std::vector<Triangle>& triangles) const
{
  const std::uint64_t first = this->begin[firstBlock];
  const std::size_t before = triangles.size();
  triangles.resize(before + static_cast<std::size_t>(this->begin[endBlock] - first));
  return ReadRecords<Triangle>(this->file, first, std::span<Triangle>(triangles).subspan(before));
}

Status LinkWriter::Begin(SpillFolder& folder)
{
  Result<SpillFile> file = folder.CreateFile("links of clusters", 0);
  KDSTREAM_TRY(file);
  this->Links.file = std::move(*file);
  this->Links.begin.assign(1, 0);
  return {};
}

Status LinkWriter::Add(const std::vector<Triangle>& mapped)
{
  const std::size_t block = this->Links.begin.size() - 1;
  const VertexId first = this->Level.begin[block], end = this->Level.begin[block + 1];
  std::vector<Link> links;
  std::for_each(mapped.begin(), mapped.end(), [&](const Triangle& t) { AppendLinkOf(t, links); });
  std::erase_if(links, [&](const Link& link) { return link.first < first || link.first >= end; });
  SortLinks(links);
  std::vector<Triangle> triangles(links.size());
  std::transform(links.begin(), links.end(), triangles.begin(), CollapsedTriangleOf);
  const std::uint64_t written = this->Links.begin.back();
  this->Links.begin.push_back(written + triangles.size());
  return WriteRecords<Triangle>(this->Links.file, written, std::span<const Triangle>(triangles));
}

}
