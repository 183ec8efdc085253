// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Partitioning/DistributedPartition.h"

#include "filters/Partitioning/CutPartitions.h"
#include "filters/adapter/MergePoints.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/core/BitCast.h"
#include "filters/core/Extent.h"
#include "filters/core/MixBits.h"
#include "filters/core/TakeResult.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/core/tree/RadixMedians.h"
#include "filters/ranks/RankGroup.h"

#include <vtkBitArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVariant.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <sstream>
#include <tuple>
#include <utility>

namespace kdstream
{
namespace
{

constexpr unsigned char notOwnPoint =
  vtkDataSetAttributes::DUPLICATEPOINT | vtkDataSetAttributes::HIDDENPOINT;
constexpr unsigned char notOwnCell = vtkDataSetAttributes::DUPLICATECELL |
                                     vtkDataSetAttributes::HIDDENCELL |
                                     vtkDataSetAttributes::REFINEDCELL;

// For each entry, whether the ghost array marks it.
std::vector<bool> MarksOf(vtkDataSetAttributes& data, vtkIdType count, unsigned char mask)
{
  std::vector<bool> marked(static_cast<std::size_t>(count), false);
  const auto* const ghosts = vtkUnsignedCharArray::SafeDownCast(
    data.GetAbstractArray(vtkDataSetAttributes::GhostArrayName()));
  for (vtkIdType i = 0; ghosts && i < std::min(count, ghosts->GetNumberOfValues()); ++i)
  {
    marked[static_cast<std::size_t>(i)] = (ghosts->GetValue(i) & mask) != 0;
  }
  return marked;
}

// The global ids of an input's points or cells; null if they cannot be used.
vtkDataArray* IdsOf(vtkDataSetAttributes& data, vtkIdType count)
{
  vtkDataArray* const ids = data.GetGlobalIds();
  return ids && ids->GetNumberOfComponents() == 1 && ids->GetNumberOfTuples() == count &&
             ids->GetDataType() != VTK_FLOAT && ids->GetDataType() != VTK_DOUBLE
           ? ids
           : nullptr;
}

using Bytes = std::vector<unsigned char>;

// A point of a rank, sent to the rank whose share has its id.
struct PointClaim
{
  Vec3 place;
  std::int64_t id;
};

// The answer: the number of the point in the mesh of all ranks, and whether the asking rank owns
// it.
struct PointGrant
{
  VertexId number;
  bool isOwn;
};

// The id of tuple i, exact even beyond 2^53.
std::int64_t IdOf(vtkDataArray& ids, vtkIdType i)
{
  return ids.GetVariantValue(i).ToTypeInt64();
}

// The place of an element in the mesh of all ranks: first vertices, then segments, triangles of
// polygons, triangles of strips; within a kind by number, then by the order within the cell.
struct ElementPlace
{
  std::uint32_t kind = 0, part = 0;
  std::int64_t number = 0;

  bool operator==(const ElementPlace&) const = default;
  bool operator<(const ElementPlace& other) const
  {
    return std::tie(this->kind, this->number, this->part) <
           std::tie(other.kind, other.number, other.part);
  }
};

// An element of a rank, sent to the rank whose share has the id of its cell.
struct ElementClaim
{
  ElementPlace place;
  Triangle corners; // as numbers in the mesh of all ranks
  std::uint32_t rank;
};

// An array that all ranks have.
struct SharedArray
{
  std::string name;
  int type = VTK_FLOAT;
  int components = 1;
  bool ofPoints = true;
  int active = -1; // vtkDataSetAttributes::AttributeTypes

  bool IsSame(const SharedArray& other) const
  {
    return this->name == other.name && this->type == other.type &&
           this->components == other.components && this->ofPoints == other.ofPoints;
  }
};

using ArrayPointer = vtkSmartPointer<vtkDataArray>;

// A copy of the array with contiguous tuples.
ArrayPointer PlainArray(vtkDataArray& array)
{
  if (array.HasStandardMemoryLayout())
  {
    return &array;
  }
  auto copy = ArrayPointer::Take(vtkDataArray::CreateDataArray(array.GetDataType()));
  copy->DeepCopy(&array);
  return copy;
}

std::size_t TupleBytes(int type, int components)
{
  return static_cast<std::size_t>(vtkAbstractArray::GetDataTypeSize(type) * components);
}

// The given tuples of an array, as bytes.
template <class Index>
std::vector<unsigned char> TuplesOf(vtkDataArray& array, const std::vector<Index>& which)
{
  const std::size_t size = TupleBytes(array.GetDataType(), array.GetNumberOfComponents());
  const auto* const from = static_cast<const unsigned char*>(array.GetVoidPointer(0));
  std::vector<unsigned char> bytes(size * which.size());
  for (std::size_t i = 0; i < which.size(); ++i)
  {
    std::copy_n(from + static_cast<std::size_t>(which[i]) * size, size, bytes.data() + i * size);
  }
  return bytes;
}

// The data received from one rank.
struct Shipment
{
  std::vector<VertexId> numbers;
  std::vector<std::uint32_t> partitions;
  std::vector<Vec3> coordinates;
  std::vector<ElementPlace> places;
  std::vector<Triangle> corners; // as numbers in the mesh of all ranks
  std::vector<std::vector<unsigned char>> arrays;
};

// Joins the data received from all ranks into one mesh: points by number, elements by place, each
// once.
class JoinedShipments
{
public:
  JoinedShipments(
    const std::vector<Shipment>& shipments, const std::vector<SharedArray>& arrays, int pointType)
  {
    const auto points = InOrder(shipments, &Shipment::numbers);
    const auto elements = InOrder(shipments, &Shipment::places);
    this->AddPoints(shipments, points, pointType);
    this->AddElements(shipments, points, elements);
    for (std::size_t k = 0; k < arrays.size(); ++k)
    {
      arrays[k].ofPoints ? AddArray(*this->Whole->GetPointData(), shipments, points, arrays[k], k)
                         : AddArray(*this->Whole->GetCellData(), shipments, elements, arrays[k], k);
    }
  }

  vtkPolyData& Mesh() const { return *this->Whole; }
  const PolyDataElements& Elements() const { return this->Parts; }
  const std::vector<std::uint32_t>& PartitionOf() const { return this->Partitions; }

private:
  // Where a point or element is in the received data.
  template <class Key>
  struct Origin
  {
    Key key;
    std::size_t rank, index;
    bool operator<(const Origin& other) const
    {
      return this->key < other.key || (this->key == other.key && this->rank < other.rank);
    }
  };

  template <class Key>
  static std::vector<Origin<Key>> InOrder(
    const std::vector<Shipment>& shipments, std::vector<Key> Shipment::*keys)
  {
    std::vector<Origin<Key>> all;
    for (std::size_t rank = 0; rank < shipments.size(); ++rank)
    {
      const std::vector<Key>& theirs = shipments[rank].*keys;
      for (std::size_t i = 0; i < theirs.size(); ++i)
      {
        all.push_back({ theirs[i], rank, i });
      }
    }
    std::sort(all.begin(), all.end());
    const auto isSame = [](const Origin<Key>& one, const Origin<Key>& other)
    { return one.key == other.key; };
    all.erase(std::unique(all.begin(), all.end(), isSame), all.end());
    return all;
  }

  void AddPoints(const std::vector<Shipment>& shipments,
    const std::vector<Origin<VertexId>>& points, int pointType)
  {
    vtkNew<vtkPoints> places;
    places->SetDataType(pointType);
    places->SetNumberOfPoints(static_cast<vtkIdType>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
    {
      const Shipment& from = shipments[points[i].rank];
      places->SetPoint(static_cast<vtkIdType>(i), from.coordinates[points[i].index].data());
      this->Partitions.push_back(from.partitions[points[i].index]);
    }
    this->Whole->SetPoints(places);
  }

  void AddElements(const std::vector<Shipment>& shipments,
    const std::vector<Origin<VertexId>>& points, const std::vector<Origin<ElementPlace>>& elements)
  {
    const auto placeOf = [&](VertexId number)
    {
      const auto found = std::lower_bound(points.begin(), points.end(), number,
        [](const Origin<VertexId>& point, VertexId wanted) { return point.key < wanted; });
      return static_cast<VertexId>(found - points.begin());
    };
    std::array<vtkNew<vtkCellArray>, 3> cells; // vertices, segments, triangles
    for (const Origin<ElementPlace>& element : elements)
    {
      const Triangle& t = shipments[element.rank].corners[element.index];
      this->Parts.corners.push_back({ placeOf(t[0]), placeOf(t[1]), placeOf(t[2]) });
      const Triangle& corners = this->Parts.corners.back();
      const vtkIdType ids[] = { corners[0], corners[1], corners[2] };
      const std::size_t kind = std::min<std::size_t>(element.key.kind, 2);
      cells[kind]->InsertNextCell(static_cast<vtkIdType>(kind) + 1, ids);
    }
    this->Parts.vertices = static_cast<std::size_t>(cells[0]->GetNumberOfCells());
    this->Parts.segments = static_cast<std::size_t>(cells[1]->GetNumberOfCells());
    this->Parts.cells.resize(elements.size());
    std::iota(this->Parts.cells.begin(), this->Parts.cells.end(), vtkIdType{ 0 });
    this->Whole->SetVerts(cells[0]);
    this->Whole->SetLines(cells[1]);
    this->Whole->SetPolys(cells[2]);
  }

  template <class Key>
  static void AddArray(vtkDataSetAttributes& data, const std::vector<Shipment>& shipments,
    const std::vector<Origin<Key>>& origins, const SharedArray& shared, std::size_t place)
  {
    const auto array = ArrayPointer::Take(vtkDataArray::CreateDataArray(shared.type));
    array->SetName(shared.name.c_str());
    array->SetNumberOfComponents(shared.components);
    array->SetNumberOfTuples(static_cast<vtkIdType>(origins.size()));
    const std::size_t size = TupleBytes(shared.type, shared.components);
    auto* to = static_cast<unsigned char*>(array->GetVoidPointer(0));
    for (const Origin<Key>& origin : origins)
    {
      const unsigned char* const from = shipments[origin.rank].arrays[place].data();
      to = std::copy_n(from + origin.index * size, size, to);
    }
    data.AddArray(array);
    if (shared.active >= 0)
    {
      data.SetActiveAttribute(shared.name.c_str(), shared.active);
    }
  }

  vtkNew<vtkPolyData> Whole;
  PolyDataElements Parts;
  std::vector<std::uint32_t> Partitions;
};

class Distribution
{
public:
  Distribution(RankGroup& ranks, vtkPolyData& input, const DistributedOptions& options,
    const Execution& execution)
    : Ranks(ranks)
    , Input(input)
    , Options(options)
    , Runs(execution)
  {
    this->Options.tree.cellVertices = 0;
  }

  Result<DistributedPartitions> Make()
  {
    KDSTREAM_TRY(this->Ranks.Agree(this->Read()));
    KDSTREAM_TRY(this->NumberPoints());
    DistributedPartitions result;
    KDSTREAM_TRY(Take(this->AreSame(), result.areSame));
    if (this->Total == 0)
    {
      return result;
    }
    KDSTREAM_TRY(this->BuildTree());
    result.partitions = std::size_t{ 1 } << this->Depths.partition;
    if (this->Options.isCut)
    {
      KDSTREAM_TRY(this->Cut(result));
    }
    result.partitionOf = std::move(this->NodeOf);
    return result;
  }

private:
  // Reads this rank's points and elements, and finds out which of them are its own.
  Status Read()
  {
    KDSTREAM_TRY(Take(ReadPoints(this->Input, this->Runs), this->Points));
    KDSTREAM_TRY(Take(ReadElements(this->Input), this->Elements));
    const std::vector<bool> ghosts =
      MarksOf(*this->Input.GetCellData(), this->Input.GetNumberOfCells(), notOwnCell);
    this->IsTaken =
      MarksOf(*this->Input.GetPointData(), this->Input.GetNumberOfPoints(), notOwnPoint);
    this->IsTaken.flip();
    for (std::size_t i = 0; i < this->Elements.corners.size(); ++i)
    {
      if (!ghosts[static_cast<std::size_t>(this->Elements.cells[i])])
      {
        this->Kept.push_back(static_cast<std::uint32_t>(i));
        for (const VertexId v : this->Elements.corners[i])
        {
          this->IsTaken[v] = true;
        }
      }
    }
    return {};
  }

  Status NumberPoints()
  {
    this->Number.assign(this->Points.size(), noVertex);
    this->IsOwn.assign(this->Points.size(), false);
    vtkDataArray* const ids = IdsOf(*this->Input.GetPointData(), this->Input.GetNumberOfPoints());
    Result<bool> byIds = this->Ranks.AllHave(ids || this->Points.empty());
    if (byIds && *byIds)
    {
      byIds = this->NumberByIds(ids);
    }
    KDSTREAM_TRY(byIds);
    this->HasPointIds = *byIds;
    if (!*byIds)
    {
      KDSTREAM_TRY(this->NumberInTurn());
    }
    std::uint64_t total =
      static_cast<std::uint64_t>(std::count(this->IsOwn.begin(), this->IsOwn.end(), true));
    KDSTREAM_TRY(this->Ranks.Sum(std::span(&total, 1)));
    this->Total = total;
    return {};
  }

  // Whether all ranks have the same points, for example from one file, without ids that identify
  // them.
  Result<bool> AreSame() const
  {
    std::uint64_t hash = this->Points.size();
    for (const Vec3& p : this->Points)
    {
      for (const double x : p)
      {
        hash = MixBits(hash ^ BitCast<std::uint64_t>(x));
      }
    }
    const auto all = this->Ranks.Gather(hash >> 1);
    KDSTREAM_TRY(all);
    return this->Total > 0 && !this->HasPointIds &&
           std::count(all->begin(), all->end(), all->front()) == std::ptrdiff_t(all->size());
  }

  Status NumberInTurn()
  {
    const auto taken =
      static_cast<std::uint64_t>(std::count(this->IsTaken.begin(), this->IsTaken.end(), true));
    const Result<VertexId> before = this->CountPointsBefore(taken);
    KDSTREAM_TRY(before);
    VertexId next = *before;
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      if (this->IsTaken[i])
      {
        this->Number[i] = next++;
        this->IsOwn[i] = true;
      }
    }
    return {};
  }

  // The number of this rank's first point.
  Result<VertexId> CountPointsBefore(std::uint64_t count)
  {
    const auto counted = this->Ranks.CountBefore(count);
    KDSTREAM_TRY(counted);
    if (counted->second >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded,
        "all ranks together have more than 4294967294 points, the maximum of a tree" };
    }
    return static_cast<VertexId>(counted->first);
  }

  // Numbers points in the order of their ids. If several ranks have a point, the first of them owns
  // it. Each id belongs to the share of one rank, which decides. Returns false, and numbers
  // nothing, if the ids are not ids of points: if one id stands for places far apart, as when each
  // rank counts its own points.
  Result<bool> NumberByIds(vtkDataArray* ids)
  {
    Box all = BoxOfPoints(this->Points);
    KDSTREAM_TRY(this->Ranks.JoinBoxes(std::span(&all, 1)));
    const std::vector<std::pair<std::int64_t, VertexId>> sorted = this->PointsById(ids);
    // Checks the ids of this rank first. Otherwise all points with one id, however many, might be
    // sent to one rank.
    Result<bool> believed = this->Ranks.AllHave(this->AreOfPoints(sorted, 5 * MostApart(all)));
    if (!believed || !*believed)
    {
      return believed;
    }
    std::vector<std::int64_t> keys;
    for (const auto& [id, point] : sorted)
    {
      keys.push_back(id);
    }
    const auto ends = this->Ranks.PartInOrder(std::span<const std::int64_t>(keys));
    KDSTREAM_TRY(ends);
    keys = {};
    std::vector<std::vector<PointClaim>> claims(this->Ranks.Count());
    for (const auto& [id, point] : sorted)
    {
      claims[RankGroup::ShareOf(id, *ends)].push_back({ this->Points[point], id });
    }
    const auto asked = this->Ranks.Exchange(std::move(claims));
    KDSTREAM_TRY(asked);
    std::vector<std::vector<PointGrant>> grants;
    VertexId count = 0;
    believed = this->Ranks.AllHave(Grant(*asked, MostApart(all), grants, count));
    if (!believed || !*believed)
    {
      return believed;
    }
    const Result<VertexId> before = this->CountPointsBefore(count);
    KDSTREAM_TRY(before);
    for (std::vector<PointGrant>& theirs : grants)
    {
      for (PointGrant& grant : theirs)
      {
        grant.number += *before;
      }
    }
    const auto granted = this->Ranks.Exchange(std::move(grants));
    KDSTREAM_TRY(granted);
    std::vector<std::size_t> next(this->Ranks.Count(), 0);
    for (const auto& [id, point] : sorted)
    {
      const std::size_t home = RankGroup::ShareOf(id, *ends);
      const PointGrant& grant = (*granted)[home][next[home]++];
      this->Number[point] = grant.number;
      this->IsOwn[point] = grant.isOwn;
    }
    return true;
  }

  std::vector<std::pair<std::int64_t, VertexId>> PointsById(vtkDataArray* ids) const
  {
    std::vector<std::pair<std::int64_t, VertexId>> sorted;
    for (VertexId i = 0; i < this->Points.size(); ++i)
    {
      if (this->IsTaken[i])
      {
        sorted.emplace_back(IdOf(*ids, i), i);
      }
    }
    std::sort(sorted.begin(), sorted.end());
    return sorted;
  }

  // Whether all places with the same id are at most `most` (squared) apart.
  bool AreOfPoints(const std::vector<std::pair<std::int64_t, VertexId>>& sorted, double most) const
  {
    return std::adjacent_find(sorted.begin(), sorted.end(),
             [&](const auto& one, const auto& other)
             {
               return one.first == other.first &&
                      SquaredDistance(this->Points[one.second], this->Points[other.second]) > most;
             }) == sorted.end();
  }

  // Answers each claim with the number of its id among those of this rank's share, and whether it
  // is the first with this id, in the order of ranks. Returns false if an id stands for places
  // further apart than `most` (squared).
  static bool Grant(const std::vector<std::vector<PointClaim>>& asked, double most,
    std::vector<std::vector<PointGrant>>& grants, VertexId& count)
  {
    std::vector<std::tuple<std::int64_t, std::size_t, std::size_t>> all; // id, rank, index
    for (std::size_t rank = 0; rank < asked.size(); ++rank)
    {
      grants.emplace_back(asked[rank].size());
      for (std::size_t i = 0; i < asked[rank].size(); ++i)
      {
        all.emplace_back(asked[rank][i].id, rank, i);
      }
    }
    std::sort(all.begin(), all.end());
    const PointClaim* first = nullptr; // the first with this id
    bool believed = true;
    for (const auto& [id, rank, i] : all)
    {
      const PointClaim& claim = asked[rank][i];
      const bool isFirst = !first || first->id != id;
      first = isFirst ? &claim : first;
      count += isFirst ? 1 : 0;
      grants[rank][i] = { count - 1, isFirst };
      believed = believed && SquaredDistance(claim.place, first->place) <= most;
    }
    return believed;
  }

  Status BuildTree()
  {
    KDSTREAM_TRY(Take(ComputeDepths(this->Total, this->Options.tree), this->Depths));
    this->NodeOf.assign(this->Points.size(), 0);
    Box all = this->BoxesOf(1)[0];
    KDSTREAM_TRY(this->Ranks.JoinBoxes(std::span(&all, 1)));
    KDSTREAM_TRY(CheckExtent(all));
    for (unsigned depth = 0; depth < this->Depths.partition; ++depth)
    {
      KDSTREAM_TRY(this->Split(depth));
      KDSTREAM_TRY(
        this->Ranks.Agree(this->Runs.Report("tree", (depth + 1.0) / this->Depths.partition)));
    }
    return {};
  }

  std::vector<Box> BoxesOf(std::size_t nodes) const
  {
    std::vector<Box> boxes(nodes);
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      if (this->IsOwn[i])
      {
        boxes[this->NodeOf[i]].Add(this->Points[i]);
      }
    }
    return boxes;
  }

  Status Split(unsigned depth)
  {
    std::vector<Box> boxes = this->BoxesOf(std::size_t{ 1 } << depth);
    KDSTREAM_TRY(this->Ranks.JoinBoxes(boxes));
    std::vector<std::size_t> axes;
    std::transform(boxes.begin(), boxes.end(), std::back_inserter(axes), LongestAxis);
    const auto keyOf = [&](std::size_t i) {
      return OrderKey{ OrderedBits(this->Points[i][axes[this->NodeOf[i]]]), this->Number[i] };
    };
    const auto medians = RadixMedians::Find(
      this->Total, depth,
      [&](const auto& visit) -> Status
      {
        for (std::size_t i = 0; i < this->Points.size(); ++i)
        {
          if (this->IsOwn[i])
          {
            visit(this->NodeOf[i], keyOf(i));
          }
        }
        return {};
      },
      [&](std::span<std::uint64_t> bins) { return this->Ranks.Sum(bins); });
    KDSTREAM_TRY(medians);
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      const std::uint32_t node = this->NodeOf[i];
      this->NodeOf[i] = 2 * node + (keyOf(i) < (*medians)[node] ? 0 : 1);
    }
    return {};
  }

  std::size_t OwnerOf(std::uint32_t partition) const
  {
    return static_cast<std::size_t>(
      (std::uint64_t{ partition } * this->Ranks.Count()) >> this->Depths.partition);
  }

  Status Cut(DistributedPartitions& result)
  {
    KDSTREAM_TRY(this->PlaceElements());
    KDSTREAM_TRY(this->AgreeOnArrays(result.skipped));
    const auto received = this->Ranks.Exchange(this->Pack());
    KDSTREAM_TRY(received);
    std::vector<Shipment> shipments;
    for (const Bytes& bytes : *received)
    {
      shipments.push_back(this->Unpack(RankMessage(bytes)));
    }
    return this->Ranks.Agree(this->CutOwn(shipments, result));
  }

  // What a rank reports about its arrays. Its point arrays count only if it has points, its cell
  // arrays only if it has cells.
  struct ReportedArrays
  {
    bool hasPoints = false, hasCells = false;
    int pointType = VTK_FLOAT;
    std::vector<SharedArray> arrays;
  };

  // Agrees on the arrays and the type of points: those of the first rank that has points or cells.
  Status AgreeOnArrays(std::vector<std::string>& skipped)
  {
    ReportedArrays own{ !this->Points.empty(), this->Input.GetNumberOfCells() > 0, VTK_FLOAT,
      this->Describe(skipped) };
    own.pointType = own.hasPoints ? this->Input.GetPoints()->GetDataType() : VTK_FLOAT;
    const auto received = this->Ranks.Exchange(
      RankLists<unsigned char>(this->Ranks.Count(), PackArrays(own).Release()));
    KDSTREAM_TRY(received);
    std::vector<ReportedArrays> reported;
    for (const Bytes& bytes : *received)
    {
      reported.push_back(UnpackArrays(RankMessage(bytes)));
      this->PointType = reported.back().pointType == VTK_FLOAT ? this->PointType : VTK_DOUBLE;
    }
    for (const bool ofPoints : { true, false })
    {
      this->ShareArrays(reported, ofPoints);
    }
    KDSTREAM_TRY(this->DropIdsOfCutCells());
    for (const SharedArray& array : own.arrays)
    {
      if (std::none_of(this->Arrays.begin(), this->Arrays.end(),
            [&](const SharedArray& kept) { return kept.IsSame(array); }))
      {
        skipped.push_back(
          "array \"" + array.name + "\": not all ranks have it, or cells were split");
      }
    }
    return {};
  }

  static RankMessage PackArrays(const ReportedArrays& reported)
  {
    RankMessage message;
    message.Put(std::vector<int>{ reported.hasPoints, reported.hasCells, reported.pointType });
    for (const SharedArray& array : reported.arrays)
    {
      message.Put(std::vector<char>(array.name.begin(), array.name.end()));
      message.Put(std::vector<int>{ array.type, array.components, array.ofPoints, array.active });
    }
    return message;
  }

  static ReportedArrays UnpackArrays(RankMessage message)
  {
    const std::vector<int> head = message.Take<int>();
    ReportedArrays reported{ head[0] != 0, head[1] != 0, head[2], {} };
    while (!message.AtEnd())
    {
      const std::vector<char> name = message.Take<char>();
      const std::vector<int> rest = message.Take<int>();
      reported.arrays.push_back(
        { std::string(name.begin(), name.end()), rest[0], rest[1], rest[2] != 0, rest[3] });
    }
    return reported;
  }

  // An array is active if it is active on all ranks. Ids that are not plausible are not active.
  void ShareArrays(const std::vector<ReportedArrays>& reported, bool ofPoints)
  {
    std::vector<SharedArray> shared;
    bool isFirst = true;
    for (const ReportedArrays& theirs : reported)
    {
      if (!(ofPoints ? theirs.hasPoints : theirs.hasCells))
      {
        continue;
      }
      if (std::exchange(isFirst, false))
      {
        std::copy_if(theirs.arrays.begin(), theirs.arrays.end(), std::back_inserter(shared),
          [&](const SharedArray& array) { return array.ofPoints == ofPoints; });
      }
      std::erase_if(shared,
        [&](SharedArray& array)
        {
          const auto same = std::find_if(theirs.arrays.begin(), theirs.arrays.end(),
            [&](const SharedArray& other) { return other.IsSame(array); });
          if (same != theirs.arrays.end() && same->active != array.active)
          {
            array.active = -1;
          }
          return same == theirs.arrays.end();
        });
    }
    for (SharedArray& array : shared)
    {
      const bool isId = array.active == vtkDataSetAttributes::GLOBALIDS;
      array.active = isId && !(ofPoints ? this->HasPointIds : this->HasCellIds) ? -1 : array.active;
      this->Arrays.push_back(array);
    }
  }

  // Drops the global ids of cells if any cells were split.
  Status DropIdsOfCutCells()
  {
    const std::vector<vtkIdType>& cells = this->Elements.cells;
    const Result<bool> whole =
      this->Ranks.AllHave(std::adjacent_find(cells.begin(), cells.end()) == cells.end());
    KDSTREAM_TRY(whole);
    std::erase_if(this->Arrays, [&](const SharedArray& array)
      { return !array.ofPoints && array.active == vtkDataSetAttributes::GLOBALIDS && !*whole; });
    return {};
  }

  std::vector<SharedArray> Describe(std::vector<std::string>& skipped) const
  {
    std::vector<SharedArray> described;
    for (const bool ofPoints : { true, false })
    {
      vtkDataSetAttributes& data = this->DataOf(ofPoints);
      const vtkIdType count =
        ofPoints ? this->Input.GetNumberOfPoints() : this->Input.GetNumberOfCells();
      for (int i = 0; count > 0 && i < data.GetNumberOfArrays(); ++i)
      {
        auto* const array = vtkDataArray::SafeDownCast(data.GetAbstractArray(i));
        const std::string name = data.GetArrayName(i) ? data.GetArrayName(i) : "";
        if (name == vtkDataSetAttributes::GhostArrayName())
        {
          continue;
        }
        if (!array || vtkBitArray::SafeDownCast(array) || name.empty() ||
            array->GetNumberOfTuples() != count)
        {
          skipped.push_back(
            "array \"" + name +
            "\": ranks can only share named numeric arrays with one tuple per point or cell");
          continue;
        }
        described.push_back({ name, array->GetDataType(), array->GetNumberOfComponents(), ofPoints,
          data.IsArrayAnAttribute(i) });
      }
    }
    return described;
  }

  vtkDataSetAttributes& DataOf(bool ofPoints) const
  {
    return ofPoints ? static_cast<vtkDataSetAttributes&>(*this->Input.GetPointData())
                    : static_cast<vtkDataSetAttributes&>(*this->Input.GetCellData());
  }

  // Puts elements in the order of the global ids of their cells, if all ranks have these; otherwise
  // rank by rank.
  Status PlaceElements()
  {
    const vtkIdType lines = this->Input.GetNumberOfVerts();
    const vtkIdType polygons = lines + this->Input.GetNumberOfLines();
    const vtkIdType strips = polygons + this->Input.GetNumberOfPolys();
    std::array<std::uint64_t, 4> counts{};
    vtkIdType last = -1;
    std::uint32_t part = 0;
    for (const std::uint32_t element : this->Kept)
    {
      const vtkIdType cell = this->Elements.cells[element];
      part = cell == std::exchange(last, cell) ? part + 1 : 0;
      const std::uint32_t kind = cell < lines ? 0 : cell < polygons ? 1 : cell < strips ? 2 : 3;
      this->Places.push_back({ kind, part, static_cast<std::int64_t>(counts[kind]++) });
    }
    KDSTREAM_TRY(this->NumberCellsByIds());
    std::array<std::int64_t, 4> before{};
    for (std::size_t kind = 0; kind < counts.size(); ++kind)
    {
      const auto all = this->Ranks.Gather(counts[kind]);
      KDSTREAM_TRY(all);
      before[kind] = static_cast<std::int64_t>(std::accumulate(
        all->begin(), all->begin() + std::ptrdiff_t(this->Ranks.Rank()), std::uint64_t{ 0 }));
    }
    for (ElementPlace& place : this->Places)
    {
      if (!this->HasCellIds)
      {
        place.number += before[place.kind];
        place.part = 0;
      }
    }
    return {};
  }

  // Numbers cells by their ids, if all ranks have ids and each id stands for one cell. Several
  // ranks may have the same cell, if it has the same corners, and occurs once on each rank. Each id
  // belongs to the share of one rank, which decides.
  Status NumberCellsByIds()
  {
    vtkDataArray* const ids = IdsOf(*this->Input.GetCellData(), this->Input.GetNumberOfCells());
    const Result<bool> has = this->Ranks.AllHave(ids || this->Kept.empty());
    KDSTREAM_TRY(has);
    if (!*has)
    {
      return {};
    }
    std::vector<ElementPlace> places = this->Places;
    std::vector<ElementClaim> own;
    for (std::size_t i = 0; i < places.size(); ++i)
    {
      const Triangle& t = this->Elements.corners[this->Kept[i]];
      places[i].number = IdOf(*ids, this->Elements.cells[this->Kept[i]]);
      own.push_back({ places[i], { this->Number[t[0]], this->Number[t[1]], this->Number[t[2]] },
        static_cast<std::uint32_t>(this->Ranks.Rank()) });
    }
    // Checks the ids of this rank first. Otherwise all cells with one id would be sent to one rank.
    Result<bool> believed = this->Ranks.AllHave(AreCells({ own }));
    if (!believed || !*believed)
    {
      return believed ? Status() : Status(believed.GetError());
    }
    std::vector<std::vector<ElementClaim>> claims(this->Ranks.Count());
    for (const ElementClaim& claim : own)
    {
      claims[MixBits(static_cast<std::uint64_t>(claim.place.number)) % claims.size()].push_back(
        claim);
    }
    own = {};
    const auto asked = this->Ranks.Exchange(std::move(claims));
    KDSTREAM_TRY(asked);
    believed = this->Ranks.AllHave(AreCells(*asked));
    KDSTREAM_TRY(believed);
    this->HasCellIds = *believed;
    if (*believed)
    {
      this->Places = std::move(places);
    }
    return {};
  }

  static bool AreCells(const std::vector<std::vector<ElementClaim>>& asked)
  {
    std::vector<ElementClaim> all;
    for (const std::vector<ElementClaim>& theirs : asked)
    {
      all.insert(all.end(), theirs.begin(), theirs.end());
    }
    const auto byId = [](const ElementClaim& a, const ElementClaim& b) {
      return std::tie(a.place.number, a.place, a.rank) < std::tie(b.place.number, b.place, b.rank);
    };
    std::sort(all.begin(), all.end(), byId);
    return std::adjacent_find(all.begin(), all.end(),
             [](const ElementClaim& a, const ElementClaim& b)
             {
               const bool isSameCell = a.place.number == b.place.number;
               const bool isSame = a.place == b.place;
               return isSameCell && (a.place.kind != b.place.kind ||
                                      (isSame && (a.corners != b.corners || a.rank == b.rank)));
             }) == all.end();
  }

  // For each rank, the data of this rank that its partitions need.
  std::vector<Bytes> Pack() const
  {
    std::vector<std::vector<std::size_t>> elementsTo(this->Ranks.Count()); // indices in Kept
    std::vector<std::vector<VertexId>> pointsTo(this->Ranks.Count());
    for (std::size_t i = 0; i < this->Points.size(); ++i)
    {
      if (this->IsOwn[i])
      {
        pointsTo[this->OwnerOf(this->NodeOf[i])].push_back(static_cast<VertexId>(i));
      }
    }
    for (std::size_t i = 0; i < this->Kept.size(); ++i)
    {
      const Triangle& corners = this->Elements.corners[this->Kept[i]];
      std::array<std::size_t, 3> owners{};
      std::transform(corners.begin(), corners.end(), owners.begin(),
        [&](VertexId v) { return this->OwnerOf(this->NodeOf[v]); });
      std::sort(owners.begin(), owners.end());
      const auto end = std::unique(owners.begin(), owners.end());
      std::for_each(owners.begin(), end,
        [&](std::size_t owner)
        {
          elementsTo[owner].push_back(i);
          pointsTo[owner].insert(pointsTo[owner].end(), corners.begin(), corners.end());
        });
    }
    std::vector<Bytes> messages;
    for (std::size_t rank = 0; rank < this->Ranks.Count(); ++rank)
    {
      std::vector<VertexId>& points = pointsTo[rank];
      std::sort(points.begin(), points.end());
      points.erase(std::unique(points.begin(), points.end()), points.end());
      messages.push_back(this->PackFor(points, elementsTo[rank]));
    }
    return messages;
  }

  Bytes PackFor(const std::vector<VertexId>& points, const std::vector<std::size_t>& elements) const
  {
    RankMessage message;
    std::vector<VertexId> numbers;
    std::vector<std::uint32_t> partitions;
    std::vector<Vec3> coordinates;
    for (const VertexId v : points)
    {
      numbers.push_back(this->Number[v]);
      partitions.push_back(this->NodeOf[v]);
      coordinates.push_back(this->Points[v]);
    }
    message.Put(numbers);
    message.Put(partitions);
    message.Put(coordinates);
    std::vector<ElementPlace> places;
    std::vector<Triangle> corners;
    std::vector<vtkIdType> cells;
    for (const std::size_t i : elements)
    {
      const Triangle& t = this->Elements.corners[this->Kept[i]];
      places.push_back(this->Places[i]);
      corners.push_back({ this->Number[t[0]], this->Number[t[1]], this->Number[t[2]] });
      cells.push_back(this->Elements.cells[this->Kept[i]]);
    }
    message.Put(places);
    message.Put(corners);
    for (const SharedArray& array : this->Arrays)
    {
      auto* const own =
        this->Points.empty() ? nullptr : this->DataOf(array.ofPoints).GetArray(array.name.c_str());
      std::vector<unsigned char> tuples;
      if (own)
      {
        const ArrayPointer plain = PlainArray(*own);
        tuples = array.ofPoints ? TuplesOf(*plain, points) : TuplesOf(*plain, cells);
      }
      message.Put(tuples);
    }
    return message.Release();
  }

  Shipment Unpack(RankMessage message) const
  {
    Shipment shipment;
    shipment.numbers = message.Take<VertexId>();
    shipment.partitions = message.Take<std::uint32_t>();
    shipment.coordinates = message.Take<Vec3>();
    shipment.places = message.Take<ElementPlace>();
    shipment.corners = message.Take<Triangle>();
    while (!message.AtEnd())
    {
      shipment.arrays.push_back(message.Take<unsigned char>());
    }
    return shipment;
  }

  Status CutOwn(const std::vector<Shipment>& shipments, DistributedPartitions& result) const
  {
    const JoinedShipments joined(shipments, this->Arrays, this->PointType);
    const PartitionLayout layout(
      joined.PartitionOf(), result.partitions, joined.Elements().corners);
    const auto firstOf = [&](std::size_t rank)
    {
      std::size_t partition = 0;
      while (partition < result.partitions &&
             this->OwnerOf(static_cast<std::uint32_t>(partition)) < rank)
      {
        ++partition;
      }
      return partition;
    };
    result.first = firstOf(this->Ranks.Rank());
    return Take(CutPartitions(joined.Mesh(), joined.Elements(), layout, this->Options.generateIds,
                  result.first, firstOf(this->Ranks.Rank() + 1), this->Runs),
      result.made);
  }

  RankGroup& Ranks;
  vtkPolyData& Input;
  DistributedOptions Options;
  const Execution& Runs;
  std::vector<Vec3> Points;
  PolyDataElements Elements;
  std::vector<std::uint32_t> Kept;   // elements that are not ghosts
  std::vector<ElementPlace> Places;  // of these elements
  std::vector<bool> IsTaken, IsOwn;  // for points: whether the joined mesh needs them; whether they
                                     // count here
  std::vector<VertexId> Number;      // of points, in the mesh of all ranks
  std::vector<std::uint32_t> NodeOf; // of points, at the depth reached so far
  std::uint64_t Total = 0;           // number of points on all ranks
  TreeDepths Depths;
  bool HasPointIds = false, HasCellIds = false; // ids are present and plausible
  std::vector<SharedArray> Arrays;
  int PointType = VTK_FLOAT;
};

}

Result<DistributedPartitions> PartitionCollectively(RankGroup& ranks, vtkPolyData& input,
  const DistributedOptions& options, const Execution& execution)
{
  return Distribution(ranks, input, options, execution).Make();
}

}
