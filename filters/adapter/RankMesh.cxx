// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Read this rank's parts.
// 2. Agree on the arrays that all ranks have.
// 3. Find out which points are the same. Each id or place belongs to the share of one rank, which
//    decides (MergePoints).
// 4. Number the points.
// 5. Read triangles and arrays.
// 6. If there is an order by ids, send everything to the rank that has its interval of ids.
#include "filters/adapter/RankMesh.h"

#include "filters/adapter/MergePoints.h"
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/ReadParts.h"
#include "filters/core/BitCast.h"
#include "filters/core/MixBits.h"
#include "filters/core/TakeResult.h"
#include "filters/core/VectorMath.h"
#include "filters/core/Weld.h"

#include <vtkAbstractArray.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

namespace kdstream
{
namespace
{

using Bytes = std::vector<unsigned char>;

// A point of a rank, sent to the rank whose share has its id or place.
struct PointClaim
{
  Vec3 place;
  std::int64_t id;
  std::uint64_t hashOfArrays;
  std::uint32_t part; // number among the parts of all ranks
  std::uint32_t isCopy;
  VertexId index; // index on its own rank
};

// The point that a point becomes, on any rank.
struct PointTarget
{
  Vec3 place;
  std::uint32_t rank;
  VertexId index;
};

// The properties of an array that are the same on all ranks.
struct ArrayKind
{
  std::string name; // empty: the array is found by its role (active scalars …)
  int type = VTK_FLOAT, components = 1;
  std::vector<int> attributes; // vtkDataSetAttributes::AttributeTypes

  bool IsLike(const ArrayKind& other) const
  {
    return this->name == other.name && this->type == other.type &&
           this->components == other.components &&
           (!this->name.empty() || this->attributes == other.attributes);
  }
};

ArrayKind KindOf(const SharedArray& array)
{
  vtkAbstractArray* const one = *std::find_if(array.ofPart.begin(), array.ofPart.end(),
    [](const vtkAbstractArray* each) { return each != nullptr; });
  return { one->GetName() ? one->GetName() : "", one->GetDataType(), one->GetNumberOfComponents(),
    array.attributes };
}

// The point or cell arrays that all ranks have in common. Ranks without any points (or cells) do
// not count.
struct RankArrays
{
  bool counts = false;           // whether this rank counts
  std::vector<SharedArray> here; // in the order of `kinds`, if `counts`
  std::vector<ArrayKind> kinds;  // common to all ranks

  // Adds the arrays with these tuples of this rank's parts to `output`. Arrays that are active on
  // all ranks become active.
  void AddTo(vtkDataSetAttributes& output, const std::vector<TupleOfPart>& tuples) const
  {
    if (this->counts)
    {
      CopySharedArrays(this->here, tuples, output);
      return;
    }
    for (const ArrayKind& kind : this->kinds)
    {
      const auto array =
        vtkSmartPointer<vtkAbstractArray>::Take(vtkAbstractArray::CreateArray(kind.type));
      array->SetName(kind.name.empty() ? nullptr : kind.name.c_str());
      array->SetNumberOfComponents(kind.components);
      const int index = output.AddArray(array);
      for (const int type : kind.attributes)
      {
        output.SetActiveAttribute(index, type);
      }
    }
  }
};

// The place of an element in the whole mesh: by kind, then by number.
struct OrderOfAll
{
  std::uint32_t kind;
  std::int64_t number;

  bool operator<(const OrderOfAll& other) const
  {
    return std::tie(this->kind, this->number) < std::tie(other.kind, other.number);
  }
};

// A column of a table: one value for each row, as bytes.
struct Column
{
  std::size_t width; // bytes per value
  std::vector<unsigned char> bytes;
};

template <class T>
Column ColumnOf(const std::vector<T>& values)
{
  const auto* const begin = reinterpret_cast<const unsigned char*>(values.data());
  return { sizeof(T), { begin, begin + values.size() * sizeof(T) } };
}

template <class T>
std::vector<T> ValuesOf(const Column& column)
{
  std::vector<T> values(column.bytes.size() / sizeof(T));
  if (!values.empty())
  {
    std::memcpy(values.data(), column.bytes.data(), values.size() * sizeof(T));
  }
  return values;
}

Column RowsOf(const Column& column, const std::vector<std::size_t>& rows)
{
  Column picked{ column.width, std::vector<unsigned char>(rows.size() * column.width) };
  for (std::size_t i = 0; i < rows.size(); ++i)
  {
    std::copy_n(column.bytes.data() + rows[i] * column.width, column.width,
      picked.bytes.data() + i * column.width);
  }
  return picked;
}

class Sharing
{
public:
  Sharing(RankGroup& ranks, bool weldByPlace, const Execution& execution)
    : Ranks(ranks)
    , WeldByPlace(weldByPlace)
    , Runs(execution)
  {
  }

  Result<MeshShare> Make(const Status& ready, vtkDataObject& input)
  {
    KDSTREAM_TRY(this->Ranks.Agree(ready ? this->Read(input) : ready));
    KDSTREAM_TRY(this->CountParts());
    KDSTREAM_TRY(Take(this->AreSame(), this->Share.areSame));
    KDSTREAM_TRY(this->AgreeOnArrays(this->Input.pointData, "point", this->PointArrays));
    KDSTREAM_TRY(this->AgreeOnArrays(this->Input.cellData, "cell", this->CellArrays));
    KDSTREAM_TRY(this->FindTargets());
    this->ReadKept();
    KDSTREAM_TRY(this->NumberPoints());
    KDSTREAM_TRY(this->ReadTriangles());
    KDSTREAM_TRY(this->OrderTriangles());
    return std::move(this->Share);
  }

private:
  Status Read(vtkDataObject& input)
  {
    KDSTREAM_TRY(Take(PartsOf(input), this->Parts));
    std::erase_if(
      this->Parts, [](const InputPart& part) { return part.mesh->GetNumberOfPoints() == 0; });
    return Take(ReadParts(this->Parts, this->Runs), this->Input);
  }

  Status CountParts()
  {
    const auto parts = this->Ranks.CountBefore(this->Parts.size());
    KDSTREAM_TRY(parts);
    std::tie(this->FirstPart, this->AllParts) = *parts;
    // Sums over all ranks: parts with ghosts, ranks whose points are not floats, copies.
    const auto& copies = this->Input.points.isCopy;
    std::uint64_t sums[] = { static_cast<std::uint64_t>(
                               std::count_if(this->Parts.begin(), this->Parts.end(),
                                 [](const InputPart& part) { return HasGhosts(*part.mesh); })),
      this->Input.areFloats ? 0U : 1U,
      static_cast<std::uint64_t>(std::count(copies.begin(), copies.end(), true)) };
    KDSTREAM_TRY(this->Ranks.Sum(sums));
    this->IsWhole = this->AllParts == 1 && sums[0] == 0;
    this->Share.mesh.scalarType = sums[1] == 0 ? ScalarType::Float32 : ScalarType::Float64;
    this->AnyCopies = sums[2] > 0;
    return {};
  }

  Result<bool> AreSame() const
  {
    std::uint64_t hash = this->Input.points.places.size();
    for (const Vec3& p : this->Input.points.places)
    {
      for (const double x : p)
      {
        hash = MixBits(hash ^ BitCast<std::uint64_t>(x));
      }
    }
    for (const KeptCells& cells : this->Input.cells)
    {
      for (const VertexId corner : cells.corners)
      {
        hash = MixBits(hash ^ corner);
      }
    }
    const auto all = this->Ranks.Gather(hash >> 1);
    KDSTREAM_TRY(all);
    return this->AllParts > 0 &&
           std::count(all->begin(), all->end(), all->front()) == std::ptrdiff_t(all->size());
  }

  // Determines the common arrays: those of the first rank that counts, in its order, that all other
  // ranks that count have too. An array is active if it is active on all of them.
  Status AgreeOnArrays(
    const std::vector<PartData>& parts, const std::string& kind, RankArrays& arrays)
  {
    std::vector<SharedArray> own = FindSharedArrays(parts, kind, this->Share.leftOut);
    arrays.counts =
      std::any_of(parts.begin(), parts.end(), [](const PartData& part) { return part.tuples > 0; });
    RankMessage message;
    message.Put(std::vector<int>{ arrays.counts });
    for (const SharedArray& array : own)
    {
      const ArrayKind reported = KindOf(array);
      message.Put(std::vector<char>(reported.name.begin(), reported.name.end()));
      message.Put(std::vector<int>{ reported.type, reported.components });
      message.Put(reported.attributes);
    }
    const auto received =
      this->Ranks.Exchange(RankLists<unsigned char>(this->Ranks.Count(), message.Release()));
    KDSTREAM_TRY(received);
    bool isFirst = true;
    for (const Bytes& bytes : *received)
    {
      RankMessage reported(bytes);
      if (reported.Take<int>()[0] != 0)
      {
        KeepShared(UnpackKinds(reported), isFirst, arrays.kinds);
        isFirst = false;
      }
    }
    this->PutInOrder(std::move(own), kind, arrays);
    return {};
  }

  static std::vector<ArrayKind> UnpackKinds(RankMessage& message)
  {
    std::vector<ArrayKind> kinds;
    while (!message.AtEnd())
    {
      const std::vector<char> name = message.Take<char>();
      const std::vector<int> numbers = message.Take<int>();
      kinds.push_back(
        { std::string(name.begin(), name.end()), numbers[0], numbers[1], message.Take<int>() });
    }
    return kinds;
  }

  static void KeepShared(
    const std::vector<ArrayKind>& theirs, bool isFirst, std::vector<ArrayKind>& kinds)
  {
    if (isFirst)
    {
      kinds = theirs;
      return;
    }
    std::erase_if(kinds,
      [&](ArrayKind& kind)
      {
        const auto like = std::find_if(
          theirs.begin(), theirs.end(), [&](const ArrayKind& other) { return other.IsLike(kind); });
        if (like != theirs.end())
        {
          std::erase_if(kind.attributes,
            [&](int type)
            {
              return std::find(like->attributes.begin(), like->attributes.end(), type) ==
                     like->attributes.end();
            });
        }
        return like == theirs.end();
      });
  }

  // Puts this rank's arrays into the common order; lists those that other ranks do not have.
  void PutInOrder(std::vector<SharedArray> own, const std::string& kind, RankArrays& arrays)
  {
    for (const ArrayKind& shared : arrays.kinds)
    {
      const auto found = std::find_if(own.begin(), own.end(),
        [&](const SharedArray& array)
        {
          const ArrayKind here = KindOf(array);
          return shared.name.empty() ? here.name.empty() && here.type == shared.type &&
                                         here.components == shared.components
                                     : here.IsLike(shared);
        });
      if (found != own.end())
      {
        arrays.here.push_back({ std::move(found->ofPart), shared.attributes });
        own.erase(found);
      }
    }
    for (const SharedArray& array : own)
    {
      this->Share.leftOut.push_back(
        kind + " array \"" + KindOf(array).name + "\": not all parts have it");
    }
  }

  // Determines for each point of this rank which point it becomes.
  Status FindTargets()
  {
    const std::vector<Vec3>& places = this->Input.points.places;
    for (VertexId v = 0; v < places.size(); ++v)
    {
      this->Targets.push_back({ places[v], static_cast<std::uint32_t>(this->Ranks.Rank()), v });
    }
    if (this->IsWhole)
    {
      return {};
    }
    const bool hasIds = std::any_of(this->PointArrays.kinds.begin(), this->PointArrays.kinds.end(),
      [](const ArrayKind& kind)
      {
        return std::count(kind.attributes.begin(), kind.attributes.end(),
                 int(vtkDataSetAttributes::GLOBALIDS)) > 0;
      });
    KDSTREAM_TRY(hasIds ? this->AskForTargets(true) : Status());
    return !this->ByIds && (this->AnyCopies || this->WeldByPlace) ? this->AskForTargets(false)
                                                                  : Status();
  }

  std::size_t HomeOf(const PointClaim& claim, bool byIds) const
  {
    std::uint64_t hash = byIds ? MixBits(static_cast<std::uint64_t>(claim.id)) : 0;
    for (const double x : claim.place)
    {
      hash = byIds ? hash : MixBits(hash ^ BitCast<std::uint64_t>(x + 0.0)); // -0.0 counts as 0.0
    }
    return static_cast<std::size_t>(hash % this->Ranks.Count());
  }

  // Whether MergePoints might accept the ids, judging only by this rank's points. This is checked
  // first, because otherwise all points with one id, however many, would be sent to one rank.
  bool AreIdsOfPoints(const SharedArray& ids, const Box& box) const
  {
    std::vector<std::pair<std::int64_t, VertexId>> sorted;
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      if (this->Input.points.isPresent[v])
      {
        sorted.emplace_back(IdOf(ids, this->Input.TupleOf(v)), v);
      }
    }
    std::sort(sorted.begin(), sorted.end());
    const double most = 5 * MostApart(box); // of squares; two points within MostApart of a third: 4
                                            // at most
    const std::vector<Vec3>& places = this->Input.points.places;
    return std::adjacent_find(sorted.begin(), sorted.end(),
             [&](const auto& one, const auto& other)
             {
               return one.first == other.first &&
                      SquaredDistance(places[one.second], places[other.second]) > most;
             }) == sorted.end();
  }

  // Asks the other ranks, by ids or by place. By ids: sets ByIds if the ids are consistent;
  // otherwise changes nothing.
  Status AskForTargets(bool byIds)
  {
    Box all = BoxOfPoints(this->Input.points.places);
    KDSTREAM_TRY(this->Ranks.JoinBoxes(std::span(&all, 1)));
    const SharedArray* const ids = byIds ? FindGlobalIds(this->PointArrays.here) : nullptr;
    const Result<bool> areOfPoints = this->Ranks.AllHave(!ids || this->AreIdsOfPoints(*ids, all));
    KDSTREAM_TRY(areOfPoints);
    if (!*areOfPoints)
    {
      return {};
    }
    std::vector<std::vector<PointClaim>> claims(this->Ranks.Count());
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      if (this->Input.points.isPresent[v])
      {
        const TupleOfPart tuple = this->Input.TupleOf(v);
        const PointClaim claim{ this->Input.points.places[v], ids ? IdOf(*ids, tuple) : 0,
          HashOfTuple(this->PointArrays.here, tuple),
          static_cast<std::uint32_t>(this->FirstPart + tuple.part),
          this->Input.points.isCopy[v] ? 1U : 0U, v };
        claims[this->HomeOf(claim, byIds)].push_back(claim);
      }
    }
    const auto asked = this->Ranks.Exchange(claims);
    KDSTREAM_TRY(asked);
    std::vector<std::vector<PointTarget>> answers;
    const Result<bool> believed =
      this->Ranks.AllHave(this->MergeClaims(*asked, byIds, all, answers) || !byIds);
    KDSTREAM_TRY(believed);
    if (!*believed)
    {
      return {};
    }
    this->ByIds = byIds;
    const auto reported = this->Ranks.Exchange(std::move(answers));
    KDSTREAM_TRY(reported);
    for (std::size_t home = 0; home < claims.size(); ++home)
    {
      for (std::size_t i = 0; i < claims[home].size(); ++i)
      {
        this->Targets[claims[home][i].index] = (*reported)[home][i];
      }
    }
    return {};
  }

  // Merges the claims of all ranks: they are points of all parts, in order. Returns false if the
  // ids are not plausible.
  bool MergeClaims(const std::vector<std::vector<PointClaim>>& asked, bool byIds, const Box& box,
    std::vector<std::vector<PointTarget>>& answers) const
  {
    PartPoints points;
    points.box = box;
    std::vector<std::pair<std::uint32_t, const PointClaim*>> all; // each with its rank
    for (std::size_t rank = 0; rank < asked.size(); ++rank)
    {
      for (const PointClaim& claim : asked[rank])
      {
        points.first.resize(
          std::max<std::size_t>(points.first.size(), claim.part + std::size_t{ 1 }),
          static_cast<VertexId>(all.size()));
        points.places.push_back(claim.place);
        points.isCopy.push_back(claim.isCopy != 0);
        if (byIds)
        {
          points.ids.push_back(claim.id);
        }
        all.emplace_back(static_cast<std::uint32_t>(rank), &claim);
      }
    }
    points.first.resize(this->AllParts + 1, static_cast<VertexId>(all.size()));
    points.isPresent.assign(all.size(), true);
    points.hashOfArrays = [&](VertexId v) { return all[v].second->hashOfArrays; };
    const MergedPoints merged = MergePoints(points, this->WeldByPlace);
    std::size_t next = 0;
    for (const std::vector<PointClaim>& theirs : asked)
    {
      answers.emplace_back();
      for (std::size_t i = 0; i < theirs.size(); ++i)
      {
        const auto& [rank, target] = all[merged.kept[merged.becomes[next++]]];
        answers.back().push_back({ target->place, rank, target->index });
      }
    }
    return merged.byIds || all.empty();
  }

  // Reads the points that stay on this rank, and their arrays.
  void ReadKept()
  {
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      const PointTarget& target = this->Targets[v];
      if (this->Input.points.isPresent[v] && target.rank == this->Ranks.Rank() && target.index == v)
      {
        this->Kept.push_back(v);
      }
    }
    vtkNew<vtkPolyData> mesh;
    vtkNew<vtkPoints> points;
    points->SetNumberOfPoints(static_cast<vtkIdType>(this->Kept.size()));
    mesh->SetPoints(points); // only their number is used
    std::vector<TupleOfPart> tuples;
    for (const VertexId v : this->Kept)
    {
      this->Share.mesh.points.push_back(this->Input.points.places[v]);
      tuples.push_back(this->Input.TupleOf(v));
    }
    this->PointArrays.AddTo(*mesh->GetPointData(), tuples);
    if (!this->ByIds && !this->IsWhole)
    {
      mesh->GetPointData()->SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
    }
    this->AddAttributes(*mesh, {});
  }

  void AddAttributes(vtkPolyData& mesh, const PolyDataElements& elements)
  {
    PolyDataAttributes read = ReadAttributes(mesh, elements);
    std::move(read.attributes.begin(), read.attributes.end(),
      std::back_inserter(this->Share.mesh.attributes));
    this->Share.leftOut.insert(this->Share.leftOut.end(), read.skipped.begin(), read.skipped.end());
  }

  Status NumberPoints()
  {
    this->Number.assign(this->Targets.size(), noVertex);
    std::vector<VertexId> numbers(this->Kept.size()); // of the points that stay
    if (this->ByIds)
    {
      KDSTREAM_TRY(this->OrderPoints(numbers));
    }
    else
    {
      const auto counted = this->CountPoints(numbers.size());
      KDSTREAM_TRY(counted);
      std::iota(numbers.begin(), numbers.end(), *counted);
    }
    for (std::size_t i = 0; i < numbers.size(); ++i)
    {
      this->Number[this->Kept[i]] = numbers[i];
    }
    return this->AskForNumbers();
  }

  // The number of this rank's first point, if it has `count` points.
  Result<VertexId> CountPoints(std::size_t count) const
  {
    const auto counted = this->Ranks.CountBefore(count);
    KDSTREAM_TRY(counted);
    if (counted->second >= noVertex)
    {
      return Error{ ErrorCode::LimitExceeded,
        "all ranks together have more than 4294967294 points" };
    }
    return static_cast<VertexId>(counted->first);
  }

  // Orders points by ids: replaces this rank's points by those in its interval of ids.
  Status OrderPoints(std::vector<VertexId>& numbers)
  {
    const SharedArray* const ids = FindGlobalIds(this->PointArrays.here);
    std::vector<OrderOfAll> order;
    for (const VertexId v : this->Kept)
    {
      order.push_back({ 0, IdOf(*ids, this->Input.TupleOf(v)) });
    }
    std::vector<Column> columns{ ColumnOf(this->Share.mesh.points) };
    this->MoveAttributes(AttributeAssociation::Point, columns);
    std::vector<std::vector<std::uint64_t>> rowsOf; // where the rows from each rank are now
    KDSTREAM_TRY(this->Scatter(order, columns, rowsOf));
    this->Share.mesh.points = ValuesOf<Vec3>(columns[0]);
    this->PutAttributes(AttributeAssociation::Point, columns);
    const auto first = this->CountPoints(this->Share.mesh.points.size());
    KDSTREAM_TRY(first);
    for (std::vector<std::uint64_t>& rows : rowsOf)
    {
      std::for_each(rows.begin(), rows.end(), [&](std::uint64_t& row) { row += *first; });
    }
    const auto reported = this->Ranks.Exchange(std::move(rowsOf));
    KDSTREAM_TRY(reported);
    std::vector<std::size_t> next(this->Ranks.Count(), 0);
    for (std::size_t i = 0; i < numbers.size(); ++i)
    {
      const std::size_t rank = this->ScatteredTo[i];
      numbers[i] = static_cast<VertexId>((*reported)[rank][next[rank]++]);
    }
    return {};
  }

  // Asks other ranks for the numbers of points that have become other points.
  Status AskForNumbers()
  {
    std::vector<std::vector<VertexId>> wanted(this->Ranks.Count());
    const auto isOther = [&](VertexId v)
    { return this->Input.points.isPresent[v] && this->Number[v] == noVertex; };
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      if (isOther(v))
      {
        wanted[this->Targets[v].rank].push_back(this->Targets[v].index);
      }
    }
    auto asked = this->Ranks.Exchange(std::move(wanted));
    KDSTREAM_TRY(asked);
    for (std::vector<VertexId>& theirs : *asked)
    {
      std::transform(
        theirs.begin(), theirs.end(), theirs.begin(), [&](VertexId v) { return this->Number[v]; });
    }
    const auto reported = this->Ranks.Exchange(std::move(*asked));
    KDSTREAM_TRY(reported);
    std::vector<std::size_t> next(this->Ranks.Count(), 0);
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      if (isOther(v))
      {
        const std::size_t rank = this->Targets[v].rank;
        this->Number[v] = (*reported)[rank][next[rank]++];
      }
    }
    return {};
  }

  // Cuts polygons as one process would for the whole mesh: at the places of the points that their
  // corners become. Frees memory as soon as possible.
  Status ReadTriangles()
  {
    KDSTREAM_TRY(this->FindCellIds());
    vtkNew<vtkPolyData> mesh;
    this->MovePoints(*mesh);
    this->MoveCells(*mesh);
    Result<PolyDataElements> elements = ReadElements(*mesh);
    KDSTREAM_TRY(this->Ranks.Agree(elements ? Status() : Status(elements.GetError())));
    KDSTREAM_TRY(this->DropCellIds(*elements, *mesh));
    this->AddAttributes(*mesh, *elements);
    mesh->Initialize();
    this->Share.mesh.triangles.reserve(elements->Triangles().size());
    for (const Triangle& t : elements->Triangles())
    {
      this->Share.mesh.triangles.push_back(
        { this->Number[t[0]], this->Number[t[1]], this->Number[t[2]] });
    }
    elements->corners = {};
    this->Number = {};
    this->CellOfTriangle = std::move(elements->cells);
    this->CellOfTriangle.erase(this->CellOfTriangle.begin(),
      this->CellOfTriangle.begin() + std::ptrdiff_t(elements->vertices + elements->segments));
    return {};
  }

  void MovePoints(vtkPolyData& mesh)
  {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(static_cast<vtkIdType>(this->Targets.size()));
    for (VertexId v = 0; v < this->Targets.size(); ++v)
    {
      points->SetPoint(vtkIdType{ v }, this->Targets[v].place.data());
    }
    mesh.SetPoints(points);
    this->Targets = {};
    this->Input.points = {};
  }

  void MoveCells(vtkPolyData& mesh)
  {
    std::array<vtkNew<vtkCellArray>, 4> cells;
    std::vector<TupleOfPart> tuples;
    for (std::size_t kind = 0; kind < cells.size(); ++kind)
    {
      const KeptCells kept = std::exchange(this->Input.cells[kind], {});
      const std::size_t count = kept.from.size();
      this->CellCounts[kind] = static_cast<vtkIdType>(count);
      if (!this->CellArrays.kinds.empty())
      {
        tuples.insert(tuples.end(), kept.from.begin(), kept.from.end());
      }
      cells[kind]->AllocateExact(
        static_cast<vtkIdType>(count), static_cast<vtkIdType>(kept.corners.size()));
      for (std::size_t cell = 0; cell < count; ++cell)
      {
        cells[kind]->InsertNextCell(static_cast<int>(kept.begin[cell + 1] - kept.begin[cell]));
        for (std::size_t i = kept.begin[cell]; i < kept.begin[cell + 1]; ++i)
        {
          cells[kind]->InsertCellPoint(vtkIdType{ kept.corners[i] });
        }
      }
    }
    mesh.SetVerts(cells[0]);
    mesh.SetLines(cells[1]);
    mesh.SetPolys(cells[2]);
    mesh.SetStrips(cells[3]);
    this->CellArrays.AddTo(*mesh.GetCellData(), tuples);
  }

  // Determines whether cells have global ids, and no two cells of all ranks have the same.
  Status FindCellIds()
  {
    const bool has = std::any_of(this->CellArrays.kinds.begin(), this->CellArrays.kinds.end(),
      [](const ArrayKind& kind)
      {
        return std::count(kind.attributes.begin(), kind.attributes.end(),
                 int(vtkDataSetAttributes::GLOBALIDS)) > 0;
      });
    if (!has)
    {
      return {};
    }
    const SharedArray* const ids = FindGlobalIds(this->CellArrays.here);
    for (const KeptCells& kept : this->Input.cells)
    {
      std::transform(kept.from.begin(), kept.from.end(), std::back_inserter(this->CellIds),
        [&](const TupleOfPart& cell) { return IdOf(*ids, cell); });
    }
    // Checks the ids of this rank first; otherwise all cells with one id would be sent to one rank.
    const Result<bool> differ = this->Ranks.AllHave(AreDifferent(this->CellIds));
    KDSTREAM_TRY(differ);
    if (!*differ)
    {
      return {};
    }
    std::vector<std::vector<std::int64_t>> claims(this->Ranks.Count());
    for (const std::int64_t id : this->CellIds)
    {
      claims[MixBits(static_cast<std::uint64_t>(id)) % claims.size()].push_back(id);
    }
    const auto asked = this->Ranks.Exchange(std::move(claims));
    KDSTREAM_TRY(asked);
    std::vector<std::int64_t> all;
    for (const std::vector<std::int64_t>& theirs : *asked)
    {
      all.insert(all.end(), theirs.begin(), theirs.end());
    }
    return Take(this->Ranks.AllHave(AreDifferent(std::move(all))), this->HasCellIds);
  }

  static bool AreDifferent(std::vector<std::int64_t> ids)
  {
    std::sort(ids.begin(), ids.end());
    return std::adjacent_find(ids.begin(), ids.end()) == ids.end();
  }

  // Ids that are not accepted become an ordinary array. If any rank has split cells, all ranks drop
  // the ids of cells.
  Status DropCellIds(const PolyDataElements& elements, vtkPolyData& mesh)
  {
    vtkCellData& data = *mesh.GetCellData();
    const auto cells = std::span(elements.cells).subspan(elements.vertices + elements.segments);
    const Result<bool> whole =
      this->Ranks.AllHave(std::adjacent_find(cells.begin(), cells.end()) == cells.end());
    KDSTREAM_TRY(whole);
    if (!this->HasCellIds && !this->IsWhole)
    {
      data.SetActiveAttribute(-1, vtkDataSetAttributes::GLOBALIDS);
    }
    else if (vtkAbstractArray* const ids = data.GetGlobalIds(); ids && !*whole)
    {
      const std::string name = ids->GetName() ? ids->GetName() : "";
      this->Share.leftOut.push_back(
        "cell array \"" + name + "\": cells were split, so several would have the same global id");
      for (int i = data.GetNumberOfArrays() - 1; i >= 0; --i)
      {
        if (data.GetAbstractArray(i) == ids)
        {
          data.RemoveArray(i);
          break;
        }
      }
    }
    return {};
  }

  // Orders triangles: those of polygons, then those of strips; by ids if there are any.
  Status OrderTriangles()
  {
    const vtkIdType strips = this->CellCounts[0] + this->CellCounts[1] + this->CellCounts[2];
    const std::vector<vtkIdType>& cells = this->CellOfTriangle;
    const auto firstOfStrips = std::lower_bound(cells.begin(), cells.end(), strips);
    const std::uint64_t counts[] = { static_cast<std::uint64_t>(firstOfStrips - cells.begin()),
      static_cast<std::uint64_t>(cells.end() - firstOfStrips) };
    std::array<std::pair<std::uint64_t, std::uint64_t>, 2> before;
    for (std::size_t kind = 0; kind < 2; ++kind)
    {
      KDSTREAM_TRY(Take(this->Ranks.CountBefore(counts[kind]), before[kind]));
    }
    const bool byIds = this->HasCellIds && !this->IsWhole;
    if (!byIds && (before[0].second == 0 || before[1].second == 0))
    {
      return {};
    }
    std::vector<OrderOfAll> order;
    std::array<std::uint64_t, 2> next{ before[0].first, before[1].first };
    for (const vtkIdType cell : cells)
    {
      const std::uint32_t kind = cell < strips ? 0 : 1;
      const auto inTurn = static_cast<std::int64_t>(next[kind]++);
      order.push_back({ kind, byIds ? this->CellIds[static_cast<std::size_t>(cell)] : inTurn });
    }
    std::vector<Column> columns{ ColumnOf(this->Share.mesh.triangles) };
    this->MoveAttributes(AttributeAssociation::Cell, columns);
    std::vector<std::vector<std::uint64_t>> rowsOf;
    KDSTREAM_TRY(this->Scatter(order, columns, rowsOf));
    this->Share.mesh.triangles = ValuesOf<Triangle>(columns[0]);
    this->PutAttributes(AttributeAssociation::Cell, columns);
    return {};
  }

  void MoveAttributes(AttributeAssociation association, std::vector<Column>& columns)
  {
    for (Attribute& attribute : this->Share.mesh.attributes)
    {
      if (attribute.association == association)
      {
        columns.push_back({ attribute.TupleSize(), std::move(attribute.values) });
      }
    }
  }
  // Puts the moved columns back into the attributes, beginning with the second column.
  void PutAttributes(AttributeAssociation association, std::vector<Column>& columns)
  {
    std::size_t next = 1;
    for (Attribute& attribute : this->Share.mesh.attributes)
    {
      if (attribute.association == association)
      {
        attribute.values = std::move(columns[next++].bytes);
      }
    }
  }

  // Distributes the rows of all ranks in order, the first ones to rank 0. Then the columns hold
  // this rank's rows. rowsOf: where the rows received from each rank are now. Rows with the same
  // key stay in the order of ranks.
  Status Scatter(const std::vector<OrderOfAll>& order, std::vector<Column>& columns,
    std::vector<std::vector<std::uint64_t>>& rowsOf)
  {
    std::vector<OrderOfAll> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    const auto ends = this->Ranks.PartInOrder(std::span<const OrderOfAll>(sorted));
    KDSTREAM_TRY(ends);
    sorted = {};
    this->ScatteredTo.clear();
    std::vector<std::vector<std::size_t>> rowsTo(this->Ranks.Count());
    for (std::size_t i = 0; i < order.size(); ++i)
    {
      this->ScatteredTo.push_back(RankGroup::ShareOf(order[i], *ends));
      rowsTo[this->ScatteredTo.back()].push_back(i);
    }
    std::vector<Bytes> out;
    for (const std::vector<std::size_t>& rows : rowsTo)
    {
      RankMessage message;
      std::vector<OrderOfAll> theirs;
      std::transform(rows.begin(), rows.end(), std::back_inserter(theirs),
        [&](std::size_t row) { return order[row]; });
      message.Put(theirs);
      for (const Column& column : columns)
      {
        message.Put(RowsOf(column, rows).bytes);
      }
      out.push_back(message.Release());
    }
    auto received = this->Ranks.Exchange(std::move(out));
    KDSTREAM_TRY(received);
    this->SortScattered(std::move(*received), columns, rowsOf);
    return {};
  }

  static void SortScattered(std::vector<Bytes> received, std::vector<Column>& columns,
    std::vector<std::vector<std::uint64_t>>& rowsOf)
  {
    std::vector<OrderOfAll> order;
    std::vector<std::size_t> counts;
    for (Column& column : columns)
    {
      column.bytes.clear();
    }
    for (Bytes& bytes : received)
    {
      RankMessage message(std::move(bytes));
      const std::vector<OrderOfAll> theirs = message.Take<OrderOfAll>();
      order.insert(order.end(), theirs.begin(), theirs.end());
      counts.push_back(theirs.size());
      for (Column& column : columns)
      {
        const std::vector<unsigned char> values = message.Take<unsigned char>();
        column.bytes.insert(column.bytes.end(), values.begin(), values.end());
      }
    }
    std::vector<std::size_t> rows(order.size());
    std::iota(rows.begin(), rows.end(), std::size_t{ 0 });
    std::stable_sort(
      rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) { return order[a] < order[b]; });
    for (Column& column : columns)
    {
      column = RowsOf(column, rows);
    }
    std::vector<std::uint64_t> placeOf(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i)
    {
      placeOf[rows[i]] = i;
    }
    auto begin = placeOf.begin();
    for (const std::size_t count : counts)
    {
      rowsOf.emplace_back(begin, begin + std::ptrdiff_t(count));
      begin += std::ptrdiff_t(count);
    }
  }

  RankGroup& Ranks;
  const bool WeldByPlace;
  const Execution& Runs;
  std::vector<InputPart> Parts;
  PartsRead Input;
  std::uint64_t FirstPart = 0, AllParts = 0; // this rank's first part, and the number of all
  // The input is one part without ghosts, which JoinPolyData leaves as it is.
  bool IsWhole = false;
  bool AnyCopies = false;                 // on any rank
  bool ByIds = false, HasCellIds = false; // ids are present and plausible
  RankArrays PointArrays, CellArrays;
  std::vector<PointTarget> Targets;  // for each point of this rank's parts
  std::vector<VertexId> Number;      // of each point in the joined mesh; noVertex: none
  std::vector<VertexId> Kept;        // the points that stay
  std::vector<std::int64_t> CellIds; // of each cell that stays
  // How many cells stay: vertices, lines, polygons, strips.
  std::array<vtkIdType, 4> CellCounts{};
  std::vector<vtkIdType> CellOfTriangle; // the cell of each triangle, among the cells that stay
  std::vector<std::size_t> ScatteredTo;  // the rank that each row was sent to
  MeshShare Share;
};

}

Result<MeshShare> ShareMesh(RankGroup& ranks, const Status& ready, vtkDataObject& input,
  bool weldByPlace, const Execution& execution)
{
  return Sharing(ranks, weldByPlace, execution).Make(ready, input);
}

}
