// SPDX-License-Identifier: BSD-3-Clause
// A sequence of cuts: see CutWalk.h.
#include "Testing/Fixtures/CutWalk.h"

#include <array>
#include <iterator>
#include <map>
#include <set>

namespace kdstream::fixtures
{

CutWalk::CutWalk(const Model& model, std::uint32_t seed)
  : M(model)
  , Random(seed)
{
  this->Leap();
}

void CutWalk::Step()
{
  if (this->Random() % 40 == 0)
  {
    this->Leap();
    return;
  }
  std::set<PieceId> active(this->C.active.begin(), this->C.active.end());
  for (auto i = this->Random() % 3; i < 3; ++i)
  {
    auto piece = this->M.pieces.begin();
    std::advance(piece, static_cast<std::ptrdiff_t>(this->Random() % this->M.pieces.size()));
    if (active.erase(piece->first) == 0)
    {
      active.insert(piece->first);
    }
  }
  this->C.active.assign(active.begin(), active.end());
}

// Chooses a random share of the pieces of each resolution, sometimes all.
void CutWalk::Leap()
{
  const TreeDepths& depths = this->M.tree.depths;
  const auto level = static_cast<unsigned>(this->Random() % (depths.finest + 2));
  this->C = { depths, level > depths.finest ? Resolution::Original() : Resolution::Level(level / 2),
    {} };
  std::map<Resolution, unsigned> percent;
  for (const auto& [id, piece] : this->M.pieces)
  {
    const std::array<unsigned, 6> choices{ 0, 5, 60, 90, 97, 100 };
    const unsigned most =
      percent.try_emplace(id.resolution, choices[this->Random() % 6]).first->second;
    if (this->Random() % 100 < most)
    {
      this->C.active.push_back(id);
    }
  }
}

}
