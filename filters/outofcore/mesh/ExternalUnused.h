// SPDX-License-Identifier: BSD-3-Clause
// Finds and removes the vertices that no triangle uses, in a mesh that does not fit in memory. Like
// core's TakeUnusedVertices (UnusedVertices.h); after step "weld" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace kdstream
{

// A byte for each vertex: whether a triangle uses it.
struct VertexMarks
{
  SpillFile file;
  std::uint32_t count = 0, marked = 0;
};

// Sections of the vertices whose marks fit in memory at a time, with a bit for each vertex.
MapSections SectionsOfMarks(std::uint32_t count, std::uint64_t memory);

// The marks of one section. Vertices of other sections are ignored.
class SectionMarks
{
public:
  SectionMarks(const MapSections& sections, std::size_t section)
    : Begin(sections.Begin(section))
    , Marked(sections.End(section) - this->Begin, false)
  {
  }
  void operator()(VertexId v)
  {
    const std::size_t i = v - this->Begin; // large if v is below Begin
    if (v >= this->Begin && i < this->Marked.size())
    {
      this->Marked[i] = true;
    }
  }
  const std::vector<bool>& All() const { return this->Marked; }

private:
  VertexId Begin;
  std::vector<bool> Marked;
};

// Marks the vertices that nameAll(section, mark) passes to `mark`. It is called for each section,
// whose vertices are [Begin(section), End(section)). Memory: a bit for each vertex of a section.
// Errors: InputOutput; those of nameAll.
Result<VertexMarks> MarkVertices(SpillFolder& folder, const MapSections& sections,
  const std::function<Status(std::size_t section, SectionMarks& mark)>& nameAll);

struct PartedVertices
{
  VertexFiles used, unused; // in input order
  // For each vertex its number among the used ones; nothing if all vertices are used.
  std::optional<VertexMap> map{};
};

// Separates vertices by their marks. Errors: InputOutput.
Result<PartedVertices> PartVertices(
  SpillFolder& folder, VertexFiles vertices, const VertexMarks& marks);

// Separates the vertices that triangles use from the others. Takes one pass over the triangles for
// each section of the marks; only a huge number of vertices needs more than one section. If there
// are unused vertices, it also takes one pass over all vertices. Peak memory: `memory` and a few
// blocks. Errors: InputOutput; Cancelled.
Result<PartedVertices> PartUnusedExternally(SpillFolder& folder, VertexFiles vertices,
  const SpillFile& triangles, std::uint64_t triangleCount, std::uint64_t memory,
  const Execution& execution = {});

}
