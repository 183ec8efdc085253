// SPDX-License-Identifier: BSD-3-Clause
// The random requests of one viewer of a crowd: those of a user who zooms, taps and looks around.
#pragma once

#include "filters/core/Types.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/SessionTypes.h"

#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace kdstream::benchmarks
{

struct CrowdModel
{
  ModelDescription description;
  std::vector<Box> boxes; // of the tree, in heap order: viewers find regions with them
};

class CrowdWishes
{
public:
  // REQUIRES: the model outlives this.
  CrowdWishes(const CrowdModel& model, std::uint32_t seed)
    : Model(model)
    , Chance(seed)
  {
  }

  // Each function returns a request that has no number yet.
  SessionRequest Preview() const;
  // Four to eight pieces side by side, and one that is finer, as a view near the surface needs
  // them.
  SessionRequest Zoom();
  // The region around a partition, without the partitions of the last region. If all of these are
  // there, the request of Zoom.
  SessionRequest Tap();
  SessionRequest BrowseTree(); // pages of the tree
  // The finest level, or this number of partitions.
  SessionRequest FinestLevel() const;
  SessionRequest Partitions(std::uint64_t count) const;

  // The viewer has no partitions any more.
  void Forget() { this->Held.clear(); }

  // A random number from 0 to end - 1.
  std::uint32_t Below(std::uint32_t end);
  double Uniform(double low, double high);
  double Exponential(double mean);

private:
  std::vector<protocol::BlobId> LevelPieces(unsigned level) const;

  const CrowdModel& Model;
  std::minstd_rand Chance;
  std::set<std::uint32_t> Held; // partitions of the last region
};

}
