// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/core/drawing/SurfaceParts.h"

#include "Testing/Fixtures/CutWalk.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"
#include "filters/core/drawing/PartNormals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <utility>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

void ExpectSame(const SurfacePart& part, const SurfacePart& fresh)
{
  ASSERT_EQ(part.piece, fresh.piece);
  ASSERT_EQ(part.own, fresh.own);
  ASSERT_EQ(part.borrowed, fresh.borrowed);
  ASSERT_EQ(part.surface.points, fresh.surface.points);
  ASSERT_EQ(part.surface.sources, fresh.surface.sources);
  ASSERT_EQ(part.surface.triangles, fresh.surface.triangles);
  ASSERT_EQ(part.surface.attributes, fresh.surface.attributes);
}

void ExpectSame(const SurfacePartList& parts, const SurfacePartList& fresh)
{
  ASSERT_EQ(parts.size(), fresh.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    ExpectSame(*parts[i], *fresh[i]);
  }
}

// For each node of a cut: the node that stood for it in the previous cut, which is itself or an
// ancestor.
std::map<Surface::Source, std::optional<Surface::Source>> NodesBefore(
  const Model& model, const Cut& before, const Cut& now)
{
  const auto old = CutOfVertices(model, before), fresh = CutOfVertices(model, now);
  std::map<Surface::Source, std::optional<Surface::Source>> nodes;
  for (std::size_t v = 0; v < fresh.size(); ++v)
  {
    const auto [node, isNew] = nodes.try_emplace(fresh[v], old[v]);
    if (old[v].resolution > fresh[v].resolution || (!isNew && node->second != old[v]))
    {
      node->second.reset();
    }
  }
  return nodes;
}

}

TEST(SurfaceParts, AreTheSameWhateverWasShownBefore)
{
  // In the second tree levels coarser than S have many pieces; in the third level S has a few.
  const std::pair<KdTreeOptions, unsigned> trees[] = { { { 60, {}, 8 }, 11 }, { { 40, {}, 8 }, 2 },
    { { 500, {}, 8 }, 1 } };
  for (const NamedMesh& named : AllMeshes())
  {
    for (const auto& [options, onePiece] : trees)
    {
      const auto model = MakeModel(named.mesh, options, {}, {}, onePiece);
      CutWalk walk(*model, 42);
      SurfaceParts parts;
      for (unsigned step = 0; step < 150; ++step, walk.Step())
      {
        SCOPED_TRACE(named.name + ", step " + std::to_string(step));
        ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
        SurfaceParts fresh;
        ASSERT_TRUE(fresh.GoTo(walk.Now(), model->Lookup()));
        ExpectSame(parts.Parts(), fresh.Parts());
        if (testing::Test::HasFatalFailure())
        {
          return;
        }
      }
    }
  }
}

namespace
{

// Each corner of a triangle must be the vertex that `corners` names, or a coarser one that stands
// for it.
void ExpectCornersAreTheirs(const SurfacePart& part, const PieceLookup& lookup)
{
  const Piece& piece = *lookup(part.piece);
  ASSERT_EQ(part.corners.size(), part.surface.triangles.size());
  const std::set<std::uint32_t> once(part.corners.begin(), part.corners.end());
  ASSERT_EQ(once.size(), part.corners.size());
  for (std::size_t i = 0; i < part.corners.size(); ++i)
  {
    for (unsigned k = 0; k < 3; ++k)
    {
      const VertexId vertex = piece.triangles[part.corners[i] / 3][(part.corners[i] + k) % 3];
      const Surface::Source& shown = part.surface.sources[part.surface.triangles[i][k]];
      if (shown.resolution == part.piece.resolution)
      {
        ASSERT_EQ(shown.key, piece.keys[vertex]);
      }
    }
  }
}

}

TEST(SurfaceParts, NameTheCornersThatTheirTrianglesHad)
{
  std::size_t triangles = 0, moved = 0, ofLevels = 0;
  bool tellsLevels = false;
  for (const NamedMesh& named : AllMeshes())
  {
    const auto model = MakeModel(named.mesh, { 40, {}, 8 }, {}, {}, 2);
    CutWalk walk(*model, 44);
    SurfaceParts parts;
    tellsLevels = !tellsLevels;
    parts.KeepCorners(true, tellsLevels);
    for (unsigned step = 0; step < 60; ++step, walk.Step())
    {
      SCOPED_TRACE(named.name + ", step " + std::to_string(step));
      ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
      for (const auto& part : parts.Parts())
      {
        if (!part->piece.resolution.IsOriginal() && !tellsLevels)
        {
          ASSERT_TRUE(part->corners.empty());
          continue;
        }
        ExpectCornersAreTheirs(*part, model->Lookup());
        ofLevels += part->piece.resolution.IsOriginal() ? 0 : part->corners.size();
        triangles += part->corners.size();
        moved +=
          static_cast<std::size_t>(std::count_if(part->borrowed.begin(), part->borrowed.end(),
            [](const auto& each) { return !each.piece.resolution.IsOriginal(); }));
        if (testing::Test::HasFatalFailure())
        {
          return;
        }
      }
    }
  }
  EXPECT_GT(triangles, 10'000u);
  EXPECT_GT(moved, 100u);
  EXPECT_GT(ofLevels, 1000u);
}

// The parents of points are the same as those found in the whole vertex tree.
TEST(SurfaceParts, NameWhatShowedTheirPointsBefore)
{
  const std::pair<KdTreeOptions, unsigned> trees[] = { { { 60, {}, 8 }, 11 }, { { 40, {}, 8 }, 2 },
    { { 500, {}, 8 }, 1 } };
  std::size_t found = 0, missed = 0;
  for (const NamedMesh& named : AllMeshes())
  {
    for (const auto& [options, onePiece] : trees)
    {
      const auto model = MakeModel(named.mesh, options, {}, {}, onePiece);
      CutWalk walk(*model, 43);
      SurfaceParts parts;
      parts.Follow(true);
      ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
      for (unsigned step = 0; step < 60; ++step)
      {
        SCOPED_TRACE(named.name + ", step " + std::to_string(step));
        const SurfacePartList before = parts.Parts();
        const Cut cutBefore = walk.Now();
        walk.Step();
        ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
        const auto expected = NodesBefore(*model, cutBefore, walk.Now());
        ASSERT_EQ(parts.Parents().size(), parts.Parts().size());
        for (std::size_t i = 0; i < parts.Parts().size(); ++i)
        {
          const ParentPoints& parents = parts.Parents()[i];
          const SurfacePart& part = *parts.Parts()[i];
          if (parents.empty())
          {
            ASSERT_EQ(std::count(before.begin(), before.end(), parts.Parts()[i]), 1);
            continue;
          }
          ASSERT_EQ(parents.size(), part.surface.points.size());
          for (std::size_t k = 0; k < parents.size(); ++k)
          {
            const auto& node = expected.at(part.surface.sources[k]);
            if (parents[k])
            {
              ASSERT_LT(parents[k]->part, before.size());
              ASSERT_LT(parents[k]->point, before[parents[k]->part]->own.size());
              ASSERT_EQ(before[parents[k]->part]->surface.sources[parents[k]->point], node)
                << "point " << k << " of part " << i;
            }
            else if (node)
            {
              // A point without a parent is only possible if the base has changed.
              ASSERT_NE(BaseOf(walk.Now()), BaseOf(cutBefore)) << "point " << k << " of part " << i;
              ++missed;
            }
            found += parents[k].has_value();
          }
        }
      }
    }
  }
  EXPECT_GT(found, 5 * missed);
}

// A sphere in many partitions: one partition becomes the original; only it and its neighbours are
// rebuilt.
TEST(SurfaceParts, OnlyWhatDiffersIsDrawnAnew)
{
  const auto model = MakeModel(DisplacedSphere(5), { 50, {}, 8 }, {}, {}, 2);
  const TreeDepths& depths = model->tree.depths;
  const std::size_t partitions = std::size_t{ 1 } << depths.partition;
  ASSERT_GE(partitions, 128U);
  Cut cut{ depths, Resolution::Level(depths.finest) };
  SurfaceParts parts;
  ASSERT_TRUE(parts.GoTo(cut, model->Lookup()));
  EXPECT_EQ(parts.Parts().size(), partitions);
  const SurfacePartList before = parts.Parts();
  ASSERT_TRUE(parts.GoTo(cut, model->Lookup()));
  EXPECT_EQ(parts.Parts(), before);

  cut.active.push_back(PieceOfPartition(Resolution::Original(), 77, depths));
  ASSERT_TRUE(parts.GoTo(cut, model->Lookup()));
  const auto drawnAnew = std::count_if(parts.Parts().begin(), parts.Parts().end(),
    [&before](const auto& part)
    { return std::find(before.begin(), before.end(), part) == before.end(); });
  EXPECT_GE(drawnAnew, 3);
  EXPECT_LE(drawnAnew, 14);
}

TEST(SurfaceParts, StayWhereAPieceIsMissing)
{
  const auto model = MakeModel(DisplacedSphere(3), { 50, {}, 8 });
  Cut cut{ model->tree.depths, Resolution::Original() };
  SurfaceParts parts;
  ASSERT_TRUE(parts.GoTo(cut, model->Lookup()));
  const SurfacePartList before = parts.Parts();
  const PieceLookup nothing = [](PieceId) -> const Piece* { return nullptr; };
  EXPECT_TRUE(FailsAt(
    parts.GoTo({ model->tree.depths, Resolution::Level(2) }, nothing), ErrorCode::NotFound));
  EXPECT_EQ(parts.Parts(), before);
}

namespace
{

// The normal of each point of the whole surface, in its order.
std::vector<Vec3> NormalsOfWhole(const Surface& surface)
{
  std::vector<Vec3> sums(surface.points.size(), Vec3{});
  for (const Triangle& t : surface.triangles)
  {
    const Vec3& a = surface.points[t[0]];
    const Vec3 area = Cross(Minus(surface.points[t[1]], a), Minus(surface.points[t[2]], a));
    for (const VertexId corner : t)
    {
      sums[corner] = Plus(sums[corner], area);
    }
  }
  return sums;
}

void ExpectNormals(
  const SurfacePartList& parts, const std::vector<PartNormals::Normals>& normals, double scale)
{
  const Surface whole = MergeParts(parts);
  const std::vector<Vec3> expected = NormalsOfWhole(whole);
  std::map<Surface::Source, Vec3> bySource;
  for (std::size_t v = 0; v < expected.size(); ++v)
  {
    bySource[whole.sources[v]] = expected[v];
  }
  for (std::size_t i = 0; i < parts.size(); ++i)
  {
    const Surface& part = parts[i]->surface;
    ASSERT_EQ(normals[i]->size(), part.points.size());
    for (std::size_t v = 0; v < part.points.size(); ++v)
    {
      const Vec3 off = Minus((*normals[i])[v], bySource.at(part.sources[v]));
      ASSERT_LE(Length(off), 1e-12 * scale * scale);
    }
  }
}

}

TEST(PartNormals, AreThoseOfTheWholeSurfaceWhateverWasShownBefore)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const auto model = MakeModel(named.mesh, { 40, {}, 8 }, {}, {}, 2);
    const Box& box = model->tree.boxes[1];
    const double scale = Length(Minus(box.hi, box.lo)) + Length(box.hi);
    CutWalk walk(*model, 7);
    SurfaceParts parts;
    PartNormals normals;
    std::size_t kept = 0;
    for (unsigned step = 0; step < 100; ++step, walk.Step())
    {
      SCOPED_TRACE(named.name + ", step " + std::to_string(step));
      const std::vector<PartNormals::Normals> before = normals.Of();
      ASSERT_TRUE(parts.GoTo(walk.Now(), model->Lookup()));
      normals.GoTo(parts.Parts());
      PartNormals fresh;
      fresh.GoTo(parts.Parts());
      ASSERT_EQ(normals.Of().size(), parts.Parts().size());
      for (std::size_t i = 0; i < parts.Parts().size(); ++i)
      {
        ASSERT_EQ(*normals.Of()[i], *fresh.Of()[i]);
        kept += std::find(before.begin(), before.end(), normals.Of()[i]) != before.end();
      }
      ExpectNormals(parts.Parts(), normals.Of(), scale);
    }
    EXPECT_GT(kept, 0U) << named.name;
  }
}

// Pieces arrive one by one, in any order.
TEST(Closures, AreTheSameAsMadeAnew)
{
  for (const unsigned onePiece : { 2U, 11U })
  {
    const auto model = MakeModel(DisplacedSphere(5), { 50, {}, 8 }, {}, {}, onePiece);
    const TreeDepths& depths = model->tree.depths;
    std::mt19937 random(3);
    for (unsigned walk = 0; walk < 30; ++walk)
    {
      Closures closures;
      std::set<PieceId> loaded;
      std::vector<PieceId> wanted;
      Resolution base;
      const PieceLookup lookup = [&](PieceId id)
      { return loaded.count(id) > 0 ? model->Lookup()(id) : nullptr; };
      for (unsigned step = 0; step < 40; ++step)
      {
        if (step % 10 == 0)
        {
          base = Resolution::Level(static_cast<unsigned>(random() % (depths.stitch + 1)));
          const std::vector<PieceId> ofBase = MissingPieces({ depths, base }, lookup);
          loaded.insert(ofBase.begin(), ofBase.end());
        }
        auto any = model->pieces.begin();
        std::advance(any, static_cast<std::ptrdiff_t>(random() % model->pieces.size()));
        wanted.push_back(any->first);
        const Closure made = closures.Make(depths, base, wanted, lookup);
        const Closure anew = MakeClosure(depths, base, wanted, lookup);
        ASSERT_EQ(made.pieces, anew.pieces) << "walk " << walk << ", step " << step;
        ASSERT_EQ(made.missing, anew.missing);
        for (const PieceId id : made.missing)
        {
          if (random() % 3 > 0)
          {
            loaded.insert(id);
          }
        }
        if (random() % 8 == 0)
        {
          wanted.erase(wanted.begin());
        }
      }
    }
  }
}
