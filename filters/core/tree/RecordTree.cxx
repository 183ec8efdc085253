// SPDX-License-Identifier: BSD-3-Clause
// The k-d tree over records: see RecordTree.h. Steps as in the paper's section 4.1:
//   a. Find the box of the cell's vertices.
//   b. Find its longest axis.
//   c. Find the median in the total order (coordinate, id).
//   d. Divide the cell into two halves.
//   e. Repeat for each half.
// The upper depths are split one after the other, all nodes of a depth in parallel; below
// `forkDepths` every subtree is finished on its own while it is in the cache.
#include "filters/core/tree/RecordTree.h"

#include "filters/core/tree/RecordSelection.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kdstream
{
namespace
{

constexpr unsigned forkDepths = 8;

template <class Scalar>
class RecordTreeBuilder
{
public:
  using Records = std::span<PointRecord<Scalar>>;

  RecordTreeBuilder(const TreeDepths& depths, std::span<Box> boxes)
    : Depths(depths)
    , Boxes(boxes)
  {
  }

  Status Build(Records records, unsigned depth, std::size_t index, const Execution& execution) const
  {
    const unsigned forked = std::min(this->Depths.finest, depth + forkDepths);
    std::vector<Records> cells{ records };
    for (unsigned d = depth; d < forked; ++d, index *= 2)
    {
      std::vector<Records> halves(cells.size() * 2);
      execution.parallelFor(cells.size(), 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            this->Split(d, index + i, cells[i]);
            halves[2 * i] = Lower(cells[i]);
            halves[2 * i + 1] = Upper(cells[i]);
          }
        });
      cells = std::move(halves);
      const double done = double(d + 1 - depth) / (2 * forkDepths);
      KDSTREAM_TRY(execution.Report("tree", done));
    }
    return this->BuildSubtrees(cells, forked, index, execution);
  }

private:
  Status BuildSubtrees(const std::vector<Records>& cells, unsigned depth, std::size_t index,
    const Execution& execution) const
  {
    constexpr std::size_t batch = 32;
    for (std::size_t first = 0; first < cells.size(); first += batch)
    {
      const std::size_t count = std::min(batch, cells.size() - first);
      execution.parallelFor(count, 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = first + begin; i < first + end; ++i)
          {
            this->Recurse(depth, index + i, cells[i]);
          }
        });
      const double done = double(first + count) / double(cells.size());
      KDSTREAM_TRY(execution.Report("tree", 0.5 + 0.5 * done));
    }
    return {};
  }

  // Sorts by ascending ids. Finest cells hold few vertices: counting the smaller ids is fastest
  // there.
  static void SortById(Records cell)
  {
    constexpr std::size_t few = 16;
    if (cell.size() > few)
    {
      std::sort(cell.begin(), cell.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
      return;
    }
    std::array<PointRecord<Scalar>, few> copy;
    std::copy(cell.begin(), cell.end(), copy.begin());
    for (std::size_t i = 0; i < cell.size(); ++i)
    {
      std::size_t rank = 0;
      for (std::size_t j = 0; j < cell.size(); ++j)
      {
        rank += copy[j].id < copy[i].id ? 1 : 0;
      }
      cell[rank] = copy[i];
    }
  }

  // The lower half gets floor, the upper ceil.
  static Records Lower(Records cell) { return cell.first(cell.size() / 2); }
  static Records Upper(Records cell) { return cell.subspan(cell.size() / 2); }

  bool IsBoxed(unsigned depth) const
  {
    return depth <= this->Depths.partition && !this->Boxes.empty();
  }

  void Recurse(unsigned depth, std::size_t index, Records cell) const
  {
    if (depth == this->Depths.finest)
    {
      if (this->IsBoxed(depth))
      {
        this->Boxes[(std::size_t{ 1 } << depth) + index] = BoxOfRecords<Scalar>(cell);
      }
      if (!this->Boxes.empty())
      {
        SortById(cell);
      }
      return;
    }
    this->Split(depth, index, cell);
    this->Recurse(depth + 1, 2 * index, Lower(cell));
    this->Recurse(depth + 1, 2 * index + 1, Upper(cell));
  }

  void Split(unsigned depth, std::size_t index, Records cell) const
  {
    const Box box = BoxOfRecords<Scalar>(cell);
    if (this->IsBoxed(depth))
    {
      this->Boxes[(std::size_t{ 1 } << depth) + index] = box;
    }
    if (cell.size() < 2)
    {
      return; // the lower half is empty
    }
    PointRecord<Scalar>* const first = cell.data();
    PointRecord<Scalar>* const middle = first + cell.size() / 2;
    PointRecord<Scalar>* const last = first + cell.size();
    switch (LongestAxis(box))
    {
      case 0:
        RecordSelection<Scalar, 0>::Select(first, middle, last);
        break;
      case 1:
        RecordSelection<Scalar, 1>::Select(first, middle, last);
        break;
      default:
        RecordSelection<Scalar, 2>::Select(first, middle, last);
    }
  }

  const TreeDepths& Depths;
  std::span<Box> Boxes;
};

}

template <class Scalar>
Status BuildRecordTree(std::span<PointRecord<Scalar>> records, unsigned depth, std::size_t index,
  const TreeDepths& depths, std::span<Box> boxes, const Execution& execution)
{
  return RecordTreeBuilder<Scalar>(depths, boxes).Build(records, depth, index, execution);
}

template Status BuildRecordTree<float>(std::span<PointRecord<float>>, unsigned, std::size_t,
  const TreeDepths&, std::span<Box>, const Execution&);
template Status BuildRecordTree<double>(std::span<PointRecord<double>>, unsigned, std::size_t,
  const TreeDepths&, std::span<Box>, const Execution&);

}
