// SPDX-License-Identifier: BSD-3-Clause
// What the phases of a build out of core share besides BuildState: files, and results of earlier
// phases that later ones use. Only for ExternalBuilder.cxx and the phases.
#pragma once

#include "filters/build/Conductor.h"
#include "filters/core/Execution.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace kdstream
{

struct ExternalBuildState : BuildState
{
  std::filesystem::path Input, Store;
  std::uint64_t Memory = 0; // for each step
  // Reads the input, if the input is open already; used until the mesh is read.
  std::unique_ptr<MeshReader> Reader{};
  std::optional<BuildFolder> Folder{}; // opened before the first phase
  std::string_view Step{};             // the step that was reported last, and its fraction
  double StepDone = 0;

  // Set by LoadMesh for partitions of any size. For cells of a k-d tree: empty, and 0.
  std::vector<VertexId> PartitionBegin{}; // the first rank of each partition, and the end
  std::uint64_t MostInBlock = 0;          // maximum number of vertices

  SpillFolder& Files() { return this->Folder->Files(); }

  // The Execution for a function that does the part [begin, end) of a step. The function reports
  // its own progress, 0 to 1, under any name. Users see the progress of the step, which never
  // decreases.
  Execution Part(const char* step, double begin, double end)
  {
    Execution part = this->Exec;
    part.progress = [this, step, begin, end](std::string_view, double fraction)
    {
      if (this->Step != step)
      {
        this->Step = step;
        this->StepDone = 0;
      }
      this->StepDone =
        std::max(this->StepDone, begin + (end - begin) * std::clamp(fraction, 0.0, 1.0));
      return this->Exec.progress(step, this->StepDone);
    };
    return part;
  }
};

}
