// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/sources/PieceOutput.h"

#include "filters/adapter/MeshPolyData.h"
#include "filters/adapter/PartitionLayout.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/Weld.h"
#include "filters/core/pieces/Glue.h"
#include "filters/core/tree/Region.h"
#include "filters/store/StoreMesh.h"

#include <vtkDataSetAttributes.h>
#include <vtkInformation.h>
#include <vtkInformationDoubleVectorKey.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::size_t piecesAtOnce = 256; // this number is read, and then converted to VTK data
constexpr std::uint8_t duplicatePoint = vtkDataSetAttributes::DUPLICATEPOINT;
constexpr std::uint8_t duplicateCell = vtkDataSetAttributes::DUPLICATECELL;

using Marks = std::vector<std::uint8_t>;

AttributeInfo MarksOf(AttributeAssociation association)
{
  return { vtkDataSetAttributes::GhostArrayName(), AttributeType::UInt8, association, 1 };
}

// Adds vtkGhostType for points and cells.
void AddMarks(std::vector<Attribute>& arrays, Marks points, Marks cells)
{
  arrays.push_back({ MarksOf(AttributeAssociation::Point), std::move(points) });
  arrays.push_back({ MarksOf(AttributeAssociation::Cell), std::move(cells) });
}

// Removes the marked cells, and the marked points that no remaining cell uses.
void DropMarked(Mesh& mesh)
{
  const auto find = [&mesh](AttributeAssociation association)
  { return FindAttribute(mesh.attributes, MarksOf(association))->values; };
  const Marks cells = find(AttributeAssociation::Cell), points = find(AttributeAssociation::Point);
  std::vector<Triangle> kept;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    if (cells[i] == 0)
    {
      kept.push_back(mesh.triangles[i]);
    }
  }
  for (Attribute& array : mesh.attributes)
  {
    if (array.association == AttributeAssociation::Cell)
    {
      Attribute fewer{ array.Info(), {} };
      for (std::size_t i = 0; i < cells.size(); ++i)
      {
        if (cells[i] == 0)
        {
          fewer.Append(array, i);
        }
      }
      array = std::move(fewer);
    }
  }
  mesh.triangles = std::move(kept);
  std::vector<bool> isKept = FindUsedVertices(mesh);
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    isKept[i] = points[i] == 0 || (isKept[i] && !mesh.triangles.empty());
  }
  TakeUnusedVertices(mesh, isKept);
}

// The owner of a triangle: the lowest of the `chosen` partitions that have it.
std::uint32_t OwnerOf(
  const Piece& piece, const Triangle& triangle, const std::set<std::uint32_t>& chosen)
{
  std::uint32_t owner = PartitionOfKey(piece.keys[0]);
  for (const VertexId v : triangle)
  {
    const std::uint32_t partition = PartitionOfKey(piece.keys[v]);
    if (partition < owner && chosen.count(partition) != 0)
    {
      owner = partition;
    }
  }
  return owner;
}

// Marks, in a partition that is output by itself, what another partition has too. isGhost: marks
// everything.
void MarkPartition(Piece& piece, const std::set<std::uint32_t>& chosen, bool isGhost)
{
  Marks points(piece.VertexCount(), duplicatePoint);
  std::fill_n(points.begin(), isGhost ? 0 : piece.ownVertices, 0);
  Marks cells;
  for (const Triangle& t : piece.triangles)
  {
    const bool isOther = OwnerOf(piece, t, chosen) != PartitionOfKey(piece.keys[0]);
    cells.push_back(isGhost || isOther ? duplicateCell : 0);
  }
  AddMarks(piece.attributes, std::move(points), std::move(cells));
}

// Marks, in a partition that will be glued to others, what belongs to another share.
void MarkForGluing(
  Piece& piece, const std::set<std::uint32_t>& chosen, const std::set<std::uint32_t>& own)
{
  const auto isOthers = [&](std::uint32_t partition)
  { return chosen.count(partition) != 0 && own.count(partition) == 0; };
  Marks points, cells;
  for (const VertexKey key : piece.keys)
  {
    points.push_back(isOthers(PartitionOfKey(key)) ? duplicatePoint : 0);
  }
  for (const Triangle& t : piece.triangles)
  {
    cells.push_back(isOthers(OwnerOf(piece, t, chosen)) ? duplicateCell : 0);
  }
  AddMarks(piece.attributes, std::move(points), std::move(cells));
}

// Marks what other pieces of a level own. Keys ascend from piece to piece, and the lowest piece
// owns a triangle.
void MarkLevelPiece(Piece& piece)
{
  Marks points(piece.VertexCount(), duplicatePoint);
  std::fill_n(points.begin(), piece.ownVertices, 0);
  Marks cells;
  for (const Triangle& t : piece.triangles)
  {
    const bool isOther =
      std::any_of(t.begin(), t.end(), [&](VertexId v) { return piece.keys[v] < piece.keys[0]; });
    cells.push_back(isOther ? duplicateCell : 0);
  }
  AddMarks(piece.attributes, std::move(points), std::move(cells));
}

Mesh MeshOf(Piece piece, ScalarType scalarType)
{
  return { std::move(piece.positions), std::move(piece.triangles), scalarType,
    std::move(piece.attributes) };
}

void AddToRange(const Attribute* array, std::optional<std::pair<double, double>>& range)
{
  for (std::size_t i = 0; array && array->components == 1 && i < array->TupleCount(); ++i)
  {
    const double value = array->Get(i, 0);
    if (std::isfinite(value))
    {
      range = range ? std::pair(std::min(range->first, value), std::max(range->second, value))
                    : std::pair(value, value);
    }
  }
}

// Sets the box of all points of a partition.
void TellBounds(vtkPartitionedDataSet& output, unsigned int partition, vtkPolyData& part)
{
  if (part.GetNumberOfPoints() > 0)
  {
    output.GetMetaData(partition)->Set(vtkDataObject::BOUNDING_BOX(), part.GetBounds(), 6);
  }
}

// The share that a point of a level belongs to. A triangle that several shares have belongs to the
// lowest of them.
enum ShareSide : std::uint32_t
{
  LowerShares,
  ThisShare,
  HigherShares
};

// The part of a level's surface that belongs to this share, and, marked, the triangles of other
// shares that touch it.
Mesh CutShare(const Surface& surface, std::vector<std::uint32_t> sideOf, ScalarType scalarType)
{
  const PartitionLayout layout(std::move(sideOf), HigherShares + 1, surface.triangles);
  const PartitionPiece cut = layout.Cut(ThisShare);
  Mesh mesh;
  mesh.scalarType = scalarType;
  for (const Attribute& array : surface.attributes)
  {
    mesh.attributes.push_back({ array.Info(), {} });
  }
  for (const VertexId v : cut.vertices)
  {
    mesh.points.push_back(surface.points[v]);
    for (std::size_t k = 0; k < surface.attributes.size(); ++k)
    {
      mesh.attributes[k].Append(surface.attributes[k], v);
    }
  }
  mesh.triangles = cut.corners;
  Marks points(cut.vertices.size(), duplicatePoint), cells(cut.duplicate.size(), 0);
  std::fill_n(points.begin(), cut.owned, 0);
  std::transform(cut.duplicate.begin(), cut.duplicate.end(), cells.begin(),
    [](std::uint8_t isOther) { return isOther != 0 ? duplicateCell : 0; });
  AddMarks(mesh.attributes, std::move(points), std::move(cells));
  return mesh;
}

}

Result<OriginalFacts> MeasureOriginal(const PieceSource& source, const Execution& execution)
{
  const ModelDescription& info = source.Info();
  const bool isCloud = info.primitive == PrimitiveType::Points;
  OriginalFacts facts;
  facts.partitions.resize(info.partitions);
  facts.ranges.resize(info.attributes.size());
  for (std::size_t first = 0; first < info.partitions; first += piecesAtOnce)
  {
    std::vector<PieceId> ids;
    for (std::size_t p = first; p < std::min(first + piecesAtOnce, facts.partitions.size()); ++p)
    {
      ids.push_back(
        { Resolution::Original(), NodeOfPartition(static_cast<std::uint32_t>(p), info.depths) });
    }
    const auto pieces = source.ReadPieces(ids, execution);
    KDSTREAM_TRY(pieces);
    for (std::size_t i = 0; i < pieces->size(); ++i)
    {
      const Piece& piece = (*pieces)[i];
      OriginalFacts::Partition& partition = facts.partitions[first + i];
      if (piece.ownVertices > 0)
      {
        partition = { BoxOfPoints(piece.positions), piece.VertexCount(),
          isCloud ? piece.ownVertices : piece.triangles.size() };
      }
      for (std::size_t k = 0; k < facts.ranges.size(); ++k)
      {
        AddToRange(FindAttribute(piece.attributes, info.attributes[k]), facts.ranges[k]);
      }
    }
  }
  return facts;
}

PieceOutput::PieceOutput(const PieceSource& source,
  std::function<bool(const AttributeInfo&)> isWanted, const Execution& execution)
  : Source(source)
  , IsWanted([wanted = std::move(isWanted)](const AttributeInfo& array)
      { return array.name == vtkDataSetAttributes::GhostArrayName() || wanted(array); })
  , Runs(execution)
{
}

// Fills `output`. In a cloud, each of the first `ownPoints` points gets a cell with the mark of the
// point.
Status PieceOutput::Fill(Mesh mesh, std::size_t ownPoints, vtkPolyData& output) const
{
  KDSTREAM_TRY(this->Runs.Report("fill", 0));
  const bool isCloud = this->Source.Info().primitive == PrimitiveType::Points;
  const std::size_t cells = isCloud ? ownPoints : 0;
  const AttributeInfo points = MarksOf(AttributeAssociation::Point);
  const Attribute* const marks = FindAttribute(mesh.attributes, points);
  for (Attribute& array : mesh.attributes)
  {
    if (isCloud && marks && array.Info() == MarksOf(AttributeAssociation::Cell))
    {
      array.values.resize(cells);
      std::transform(marks->values.begin(), marks->values.begin() + std::ptrdiff_t(cells),
        array.values.begin(), [](std::uint8_t mark) { return mark != 0 ? duplicateCell : 0; });
    }
  }
  return FillPolyData(mesh, cells, this->IsWanted, output, this->Runs);
}

// Selects the chosen partitions of this share, and the chosen partitions in the rings around them.
Result<PieceOutput::Selection> PieceOutput::Select(
  const std::vector<std::uint32_t>& chosen, const OutputShare& share) const
{
  const ModelDescription& info = this->Source.Info();
  Selection selected;
  selected.all.insert(chosen.begin(), chosen.end());
  std::copy_if(selected.all.begin(), selected.all.end(),
    std::inserter(selected.own, selected.own.end()),
    [&](std::uint32_t p)
    { return share.Has(p, info.partitions) && (!share.blocks || share.blocks->count(p) != 0); });
  std::set<std::uint32_t> wanted = selected.own;
  if (share.ghostLevels > 0 && !wanted.empty())
  {
    const auto boxes = this->Source.ReadBoxes(this->Runs);
    KDSTREAM_TRY(boxes);
    for (const std::uint32_t p : selected.own)
    {
      const auto region =
        FindRegion(*boxes, info.depths, NodeOfPartition(p, info.depths), share.ghostLevels);
      KDSTREAM_TRY(region);
      wanted.insert(region->begin(), region->end());
    }
  }
  for (const std::uint32_t p : wanted)
  {
    if (selected.all.count(p) != 0)
    {
      selected.ids.push_back({ Resolution::Original(), NodeOfPartition(p, info.depths) });
    }
  }
  return selected;
}

Status PieceOutput::AddPartitions(const std::vector<std::uint32_t>& chosen,
  const OutputShare& share, vtkPartitionedDataSet& output) const
{
  const ModelDescription& info = this->Source.Info();
  const auto selected = this->Select(chosen, share);
  KDSTREAM_TRY(selected);
  const std::vector<PieceId>& ids = selected->ids;
  output.SetNumberOfPartitions(static_cast<unsigned int>(info.partitions));
  for (std::size_t first = 0; first < ids.size(); first += piecesAtOnce)
  {
    const auto batch = std::span(ids).subspan(first, std::min(piecesAtOnce, ids.size() - first));
    Execution reading; // the progress of a batch is a part of the whole
    reading.progress = [&](std::string_view step, double fraction)
    {
      const double done = static_cast<double>(first) + fraction * static_cast<double>(batch.size());
      return this->Runs.progress(step, done / static_cast<double>(ids.size()));
    };
    auto pieces = this->Source.ReadPieces(batch, reading);
    KDSTREAM_TRY(pieces);
    for (std::size_t i = 0; i < pieces->size(); ++i)
    {
      Piece& piece = (*pieces)[i];
      const std::uint32_t partition = batch[i].node - (NodeId{ 1 } << info.depths.partition);
      vtkNew<vtkPolyData> part;
      if (piece.ownVertices > 0)
      {
        MarkPartition(piece, selected->all, selected->own.count(partition) == 0);
        const std::size_t ownPoints = piece.ownVertices;
        KDSTREAM_TRY(this->Fill(MeshOf(std::move(piece), info.grid.scalarType), ownPoints, *part));
      }
      output.SetPartition(partition, part);
      TellBounds(output, partition, *part);
    }
  }
  return {};
}

Status PieceOutput::GlueInto(
  const std::vector<std::uint32_t>& chosen, const OutputShare& share, vtkPolyData& output) const
{
  const auto selected = this->Select(chosen, share);
  KDSTREAM_TRY(selected);
  auto pieces = this->Source.ReadPieces(selected->ids, this->Runs);
  KDSTREAM_TRY(pieces);
  if (share.pieces > 1)
  {
    std::erase_if(*pieces, [](const Piece& piece) { return piece.ownVertices == 0; });
    for (Piece& piece : *pieces)
    {
      KDSTREAM_TRY(this->Runs.Report("fill", 0));
      MarkForGluing(piece, selected->all, selected->own);
    }
  }
  Result<Mesh> mesh = GluePartitions(*pieces, this->Source.Info().grid.scalarType, this->Runs);
  KDSTREAM_TRY(mesh);
  pieces->clear();
  if (share.pieces > 1 && share.ghostLevels == 0 && !mesh->points.empty())
  {
    DropMarked(*mesh);
  }
  const std::size_t cells = mesh->points.size();
  return this->Fill(std::move(*mesh), cells, output);
}

Status PieceOutput::AddPieces(
  unsigned level, const OutputShare& share, vtkPartitionedDataSet& output) const
{
  const ModelDescription& info = this->Source.Info();
  const Resolution resolution = Resolution::Level(level);
  const NodeId first = NodeId{ 1 } << PieceDepth(resolution, info.depths);
  std::vector<PieceId> ids;
  for (NodeId i = 0; i < first; ++i)
  {
    const PieceId id{ resolution, first + i };
    if (info.HasPiece(id) && share.Has(i, first) && (!share.blocks || share.blocks->count(i) != 0))
    {
      ids.push_back(id);
    }
  }
  auto pieces = this->Source.ReadPieces(ids, this->Runs);
  KDSTREAM_TRY(pieces);
  output.SetNumberOfPartitions(first);
  for (std::size_t i = 0; i < ids.size(); ++i)
  {
    Piece& piece = (*pieces)[i];
    vtkNew<vtkPolyData> part;
    if (piece.ownVertices > 0)
    {
      MarkLevelPiece(piece);
      const std::size_t ownPoints = piece.ownVertices;
      KDSTREAM_TRY(this->Fill(MeshOf(std::move(piece), info.grid.scalarType), ownPoints, *part));
    }
    output.SetPartition(ids[i].node - first, part);
    TellBounds(output, ids[i].node - first, *part);
  }
  return {};
}

Status PieceOutput::DrawInto(const std::vector<PieceId>& shown, vtkPolyData& output) const
{
  const Resolution preview = Resolution::Level(PreviewLevel(this->Source.Info()));
  auto mesh = DrawStorePieces(this->Source, preview, shown, this->Runs);
  KDSTREAM_TRY(mesh);
  const std::size_t points = mesh->points.size();
  return this->Fill(std::move(*mesh), points, output);
}

Status PieceOutput::DrawInto(unsigned level, const OutputShare& share, vtkPolyData& output) const
{
  const ModelDescription& info = this->Source.Info();
  auto surface =
    DrawStoreSurface(this->Source, { info.depths, Resolution::Level(level) }, this->Runs);
  KDSTREAM_TRY(surface);
  if (share.pieces == 1)
  {
    const std::size_t cells = surface->points.size();
    return this->Fill({ std::move(surface->points), std::move(surface->triangles),
                        info.grid.scalarType, std::move(surface->attributes) },
      cells, output);
  }
  std::vector<std::uint32_t> sideOf;
  const bool byPartition = level >= info.depths.stitch;
  for (const Surface::Source& source : surface->sources)
  {
    const std::uint64_t place = byPartition ? PartitionOfKey(source.key) : source.key;
    const std::uint64_t count = byPartition ? info.partitions : info.levels[level].vertices;
    const std::uint64_t piece =
      std::min<std::uint64_t>(place * share.pieces / count, share.pieces - 1);
    sideOf.push_back(piece < share.piece    ? LowerShares
                     : piece == share.piece ? ThisShare
                                            : HigherShares);
  }
  const auto cells =
    static_cast<std::size_t>(std::count(sideOf.begin(), sideOf.end(), std::uint32_t{ ThisShare }));
  Mesh mesh = CutShare(*surface, std::move(sideOf), info.grid.scalarType);
  if (share.ghostLevels == 0)
  {
    DropMarked(mesh);
  }
  return this->Fill(std::move(mesh), cells, output);
}

}
