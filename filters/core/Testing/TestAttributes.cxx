// SPDX-License-Identifier: BSD-3-Clause
// Attributes through core: welding, levels, pieces, drawn surfaces, gluing.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Model.h"
#include "filters/core/Light.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/CollapseAttributes.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/pieces/Glue.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// Calls check for all small meshes of the fixtures. Only small ones, because arrays of 255
// components take many bytes.
template <class Check>
void ForAll(const Check& check)
{
  std::uint32_t seed = 0;
  for (const NamedMesh& named : AllMeshes())
  {
    if (named.mesh.points.size() > 3000)
    {
      continue;
    }
    SCOPED_TRACE(named.name);
    check(*MakeModel(WithAttributes(named.mesh, ++seed), { 90, {}, 5 }));
  }
  ASSERT_GT(seed, 8U) << "too few meshes are small";
}

// The bytes of all tuples of one point or triangle.
std::vector<std::uint8_t> Bytes(
  const std::vector<Attribute>& attributes, AttributeAssociation association, std::size_t tuple)
{
  std::vector<std::uint8_t> bytes;
  for (const Attribute& attribute : attributes)
  {
    if (attribute.association == association)
    {
      const auto own = TupleOf(attribute, tuple);
      bytes.insert(bytes.end(), own.begin(), own.end());
    }
  }
  return bytes;
}

// The triangles with their tuples, sorted.
std::vector<std::pair<Triangle, std::vector<std::uint8_t>>> Triangles(
  const Mesh& mesh, const std::vector<VertexId>& vertices)
{
  std::vector<std::pair<Triangle, std::vector<std::uint8_t>>> all;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    const Triangle& t = mesh.triangles[i];
    all.emplace_back(RotateLowestFirst({ vertices[t[0]], vertices[t[1]], vertices[t[2]] }),
      Bytes(mesh.attributes, AttributeAssociation::Cell, i));
  }
  std::sort(all.begin(), all.end());
  return all;
}

Attribute PointArray(const std::string& name, AttributeType type, std::uint8_t components,
  const std::vector<double>& values)
{
  Attribute attribute{ { name, type, AttributeAssociation::Point, components }, {} };
  attribute.values.resize(values.size() * SizeOf(type));
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    attribute.Set(i / components, i % components, values[i]);
  }
  return attribute;
}

// Levels with all vertices in one cluster.
ClusterLevels OneCluster(const Mesh& mesh)
{
  ClusterLevels levels;
  levels.finest.assign(mesh.points.size(), 0);
  levels.levels.resize(1);
  levels.levels[0].lowest = { 0 };
  return levels;
}

constexpr double notANumber = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

}

TEST(Attributes, GluingGivesEveryTupleBack)
{
  ForAll(
    [](const Model& model)
    {
      std::vector<Piece> pieces;
      for (const auto& [id, piece] : model.pieces)
      {
        const Status status = CheckPiece(piece, model.tree.depths);
        ASSERT_TRUE(status) << status.GetError().message;
        if (id.resolution.IsOriginal())
        {
          pieces.push_back(piece);
        }
      }
      const auto glued = GluePartitions(pieces, model.mesh.scalarType);
      ASSERT_TRUE(glued) << glued.GetError().message;
      ASSERT_EQ(InfosOf(glued->attributes), InfosOf(model.mesh.attributes));
      const std::vector<VertexId>& original = model.vertexTree.original;
      for (std::size_t v = 0; v < original.size(); ++v)
      {
        ASSERT_EQ(Bytes(glued->attributes, AttributeAssociation::Point, v),
          Bytes(model.mesh.attributes, AttributeAssociation::Point, original[v]));
      }
      std::vector<VertexId> same(original.size());
      std::iota(same.begin(), same.end(), VertexId{ 0 });
      ASSERT_TRUE(Triangles(*glued, original) == Triangles(model.mesh, same));
    });
}

TEST(Attributes, GluingSomePartitionsGivesTheGhostsTheirTuples)
{
  const auto model = MakeModel(WithAttributes(Torus(40, 20), 3), { 90, {}, 5 });
  std::vector<Piece> some;
  for (const auto& [id, piece] : model->pieces)
  {
    if (id.resolution.IsOriginal() && id.node % 3 != 0)
    {
      some.push_back(piece);
    }
  }
  const auto glued = GluePartitions(some, ScalarType::Float32);
  ASSERT_TRUE(glued);
  std::map<Vec3, VertexId> at; // no two points of a torus are equal
  for (VertexId v = 0; v < model->mesh.points.size(); ++v)
  {
    at[model->mesh.points[v]] = v;
  }
  std::size_t own = 0;
  for (const Piece& piece : some)
  {
    own += piece.ownVertices;
  }
  ASSERT_GT(glued->points.size(), own) << "no ghosts";
  for (std::size_t v = 0; v < glued->points.size(); ++v)
  {
    ASSERT_EQ(Bytes(glued->attributes, AttributeAssociation::Point, v),
      Bytes(model->mesh.attributes, AttributeAssociation::Point, at[glued->points[v]]));
  }
  some[1].attributes.pop_back();
  EXPECT_TRUE(FailsAt(GluePartitions(some, ScalarType::Float32), ErrorCode::InvalidInput));
}

TEST(Attributes, SurfacesShowTheTuplesOfTheirSources)
{
  std::mt19937 generator(5);
  const auto random = [&generator] { return static_cast<std::uint32_t>(generator()); };
  ForAll(
    [&](const Model& model)
    {
      const VertexTree& tree = model.vertexTree;
      const unsigned stitch = tree.depths.stitch, finest = tree.depths.finest;
      for (int round = 0; round < 6; ++round)
      {
        Cut cut{ tree.depths, Resolution::Level(random() % (finest + 1)), {} };
        cut.base = round == 0 ? Resolution::Original() : cut.base;
        if (round > 1)
        {
          for (const auto& [id, piece] : model.pieces)
          {
            if (cut.base < id.resolution && random() % 4 != 0)
            {
              cut.active.push_back(id);
            }
          }
        }
        const Result<Surface> surface = DrawSurface(cut, model.Lookup());
        ASSERT_TRUE(surface);
        bool onlyOriginal = true;
        for (std::size_t v = 0; v < surface->points.size(); ++v)
        {
          const Surface::Source& source = surface->sources[v];
          onlyOriginal = onlyOriginal && source.resolution.IsOriginal();
          const bool byPartition = source.resolution >= Resolution::Level(stitch);
          VertexId vertex = static_cast<VertexId>(source.key);
          if (byPartition)
          {
            vertex = tree.partitionBegin[PartitionOfKey(source.key)] + IndexOfKey(source.key);
          }
          const std::vector<Attribute>* attributes = &model.mesh.attributes;
          if (source.resolution.IsOriginal())
          {
            vertex = tree.original[vertex];
          }
          else
          {
            attributes = &tree.levels[source.resolution.Depth()].attributes;
            vertex = byPartition ? tree.ClusterAt(source.resolution.Depth(), vertex) : vertex;
          }
          for (const Attribute& shown : surface->attributes)
          {
            const Attribute* expected = FindAttribute(*attributes, shown);
            ASSERT_NE(expected, nullptr) << shown.name;
            ASSERT_EQ(TupleOf(shown, v), TupleOf(*expected, vertex)) << shown.name;
          }
        }
        const std::vector<AttributeInfo> all(
          model.mesh.attributes.begin(), model.mesh.attributes.end());
        const auto pointArrays = static_cast<std::size_t>(std::count_if(all.begin(), all.end(),
          [](const auto& attribute)
          { return attribute.association == AttributeAssociation::Point; }));
        const std::size_t inLevels = ArraysOfLevels(all).size();
        ASSERT_EQ(surface->attributes.size(), onlyOriginal ? pointArrays : inLevels);
        ASSERT_TRUE(CheckAttributes(surface->attributes, surface->points.size(), 0));
      }
    });
}

TEST(Attributes, LevelsCarryTheMeansOfNormalsAndColours)
{
  std::size_t compared = 0;
  ForAll(
    [&](const Model& model)
    {
      const VertexTree& tree = model.vertexTree;
      std::vector<VertexId> cluster(tree.original.size()); // of each numbered vertex
      const Attribute* const vertexColors = FindVertexColors(model.mesh.attributes);
      const std::vector<AttributeInfo> inLevels = ArraysOfLevels(
        std::vector<AttributeInfo>(model.mesh.attributes.begin(), model.mesh.attributes.end()));
      for (unsigned d = tree.depths.finest + 1; d-- > 0;)
      {
        const VertexTreeLevel& level = tree.levels[d];
        for (VertexId v = 0; v < cluster.size(); ++v)
        {
          cluster[v] =
            d == tree.depths.finest ? tree.ClusterAt(d, v) : tree.levels[d + 1].parents[cluster[v]];
        }
        for (const Attribute& attribute : model.mesh.attributes)
        {
          const AttributeRole role = RoleOf(attribute);
          const Attribute* means = FindAttribute(level.attributes, attribute);
          const bool isOfSpace = role == AttributeRole::Normals || role == AttributeRole::Colors;
          ASSERT_EQ(
            means != nullptr, std::count(inLevels.begin(), inLevels.end(), attribute.Info()) == 1)
            << attribute.name;
          if (!isOfSpace)
          {
            continue;
          }
          ASSERT_EQ(means->TupleCount(), level.first.size());
          const std::size_t n = attribute.components;
          std::vector<double> sums(level.first.size() * n);
          std::vector<double> counts(level.first.size());
          std::vector<double> least(sums.size(), infinite), most(sums.size(), -infinite);
          for (VertexId v = 0; v < cluster.size(); ++v)
          {
            double length = 0;
            for (std::size_t k = 0; k < n; ++k)
            {
              length = std::hypot(length, attribute.Get(tree.original[v], k));
            }
            const bool color = role == AttributeRole::Colors;
            if (!color && (!std::isfinite(length) || length == 0))
            {
              continue;
            }
            ++counts[cluster[v]];
            for (std::size_t k = 0; k < n; ++k)
            {
              const double value = attribute.Get(tree.original[v], k);
              const std::size_t at = cluster[v] * n + k;
              sums[at] += color && k < 3 ? ToLinear(value / 255) : value / (color ? 1 : length);
              least[at] = std::min(least[at], value);
              most[at] = std::max(most[at], value);
            }
          }
          for (std::size_t c = 0; c < level.first.size(); ++c)
          {
            const double length =
              n == 3 ? std::hypot(sums[c * n], sums[c * n + 1], sums[c * n + 2]) : 0;
            for (std::size_t k = 0; k < n; ++k)
            {
              const double sum = sums[c * n + k];
              const bool isVertexColors = role == AttributeRole::Colors && k < 3 &&
                                          &attribute == vertexColors && d < tree.depths.finest;
              if (isVertexColors) // set by the collapse, in the range of the originals' colours
              {
                ASSERT_GE(means->Get(c, k), least[c * n + k]);
                ASSERT_LE(means->Get(c, k), most[c * n + k]);
                ++compared;
              }
              else if (role == AttributeRole::Colors)
              {
                const double mean = sum / counts[c];
                const double shown = k < 3 ? 255 * FromLinear(mean) : mean;
                ASSERT_NEAR(means->Get(c, k), shown, 0.5001);
                ++compared;
              }
              else if (counts[c] == 0)
              {
                ASSERT_EQ(means->Get(c, k), 0);
              }
              else if (length > 1e-6 * counts[c])
              {
                ASSERT_NEAR(means->Get(c, k), sum / length, 2e-6);
                ++compared;
              }
            }
          }
        }
      }
    });
  EXPECT_GT(compared, 10000U);
}

// Checks a level's value against the values of the cluster's vertices, by the documented rule.
void ExpectLevelValue(const Attribute& array, std::vector<double> values, double shown)
{
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty())
  {
    ASSERT_TRUE(std::isnan(shown) || shown == 0);
    return;
  }
  std::map<double, std::size_t> counts;
  std::for_each(values.begin(), values.end(), [&](double value) { ++counts[value]; });
  if (HoldsClasses(array))
  {
    const auto most = std::max_element(counts.begin(), counts.end(),
      [](const auto& a, const auto& b) { return a.second < b.second; });
    ASSERT_GE(counts[shown], 1U) << "a value that none of the vertices has: " << array.name << " "
                                 << shown << ", of " << testing::PrintToString(counts);
    const std::size_t lacks = most->second - counts[shown];
    ASSERT_LE(lacks, counts.size() <= 4 ? 0 : values.size() / 5);
    return;
  }
  double mean = 0;
  for (const double value : values)
  {
    mean += value / double(values.size());
  }
  const bool isReal = array.type == AttributeType::Float32 || array.type == AttributeType::Float64;
  const double largest =
    std::max(std::abs(counts.begin()->first), std::abs(counts.rbegin()->first));
  ASSERT_NEAR(shown, mean, largest * 1e-6 + (isReal ? 0 : 0.5));
}

TEST(Attributes, LevelsCarryTheMeansOfNumbersAndTheMostFrequentClasses)
{
  std::size_t numbers = 0, classes = 0;
  std::mt19937 random(4);
  for (const NamedMesh& named : AllMeshes())
  {
    if (named.mesh.points.size() > 3000 || named.mesh.points.empty())
    {
      continue;
    }
    SCOPED_TRACE(named.name);
    Mesh mesh = named.mesh;
    for (const AttributeInfo& info :
      { AttributeInfo{ "intensity", AttributeType::UInt16, AttributeAssociation::Point, 1 },
        AttributeInfo{ "time", AttributeType::Float64, AttributeAssociation::Point, 1 },
        AttributeInfo{ "quality", AttributeType::Int8, AttributeAssociation::Point, 1 },
        AttributeInfo{ "kind", AttributeType::UInt8, AttributeAssociation::Point, 1 },
        AttributeInfo{ "scalar_Label", AttributeType::Float32, AttributeAssociation::Point, 1 } })
    {
      Attribute& array = mesh.attributes.emplace_back(Attribute{ info, {} });
      array.values.resize(mesh.points.size() * info.TupleSize());
      for (std::size_t v = 0; v < mesh.points.size(); ++v)
      {
        const double value = HoldsClasses(info) ? double(random() % (v % 3 == 0 ? 9 : 3))
                                                : double(random() % 200) - 100;
        array.Set(v, 0, info.name == "time" && v % 5 == 0 ? notANumber : value * 1.25);
      }
    }
    const auto model = MakeModel(mesh, { 90, {}, 5 });
    const VertexTree& tree = model->vertexTree;
    std::vector<VertexId> cluster(tree.original.size());
    for (unsigned d = tree.depths.finest + 1; d-- > 0;)
    {
      const VertexTreeLevel& level = tree.levels[d];
      for (VertexId v = 0; v < cluster.size(); ++v)
      {
        cluster[v] =
          d == tree.depths.finest ? tree.ClusterAt(d, v) : tree.levels[d + 1].parents[cluster[v]];
      }
      for (const Attribute& array : model->mesh.attributes)
      {
        std::vector<std::vector<double>> values(level.first.size());
        for (VertexId v = 0; v < cluster.size(); ++v)
        {
          values[cluster[v]].push_back(array.Get(tree.original[v], 0));
        }
        const Attribute* shown = FindAttribute(level.attributes, array);
        ASSERT_TRUE(shown && shown->TupleCount() == values.size()) << array.name;
        for (std::size_t c = 0; c < values.size(); ++c)
        {
          ExpectLevelValue(array, values[c], shown->Get(c, 0));
          ++(HoldsClasses(array) ? classes : numbers);
        }
      }
    }
  }
  EXPECT_GT(numbers, 10000U);
  EXPECT_GT(classes, 10000U);
}

TEST(Attributes, AreClassesByTypeOrName)
{
  const auto holds = [](const char* name, AttributeType type) {
    return HoldsClasses({ name, type, AttributeAssociation::Point, 1 });
  };
  EXPECT_TRUE(holds("kind", AttributeType::UInt8));
  EXPECT_TRUE(holds("scalar_Classification", AttributeType::Float32));
  EXPECT_TRUE(holds("LABEL", AttributeType::Int64));
  EXPECT_FALSE(holds("Intensity", AttributeType::UInt8));
  EXPECT_FALSE(holds("kind", AttributeType::Int16));
  EXPECT_FALSE(holds("class_confidence", AttributeType::Float32));
}

TEST(Attributes, NumbersBeyondAllSumsHaveAMean)
{
  Mesh mesh;
  mesh.points.resize(4);
  Attribute& huge = mesh.attributes.emplace_back(
    Attribute{ { "huge", AttributeType::Float64, AttributeAssociation::Point, 1 },
      std::vector<std::uint8_t>(32) });
  for (std::size_t v = 0; v < 4; ++v)
  {
    huge.Set(v, 0, std::numeric_limits<double>::max());
  }
  ClusterLevels levels = OneCluster(mesh);
  AddLevelAttributes(mesh, levels);
  EXPECT_EQ(levels.levels[0].attributes.at(0).Get(0, 0), std::numeric_limits<double>::max());
}

TEST(Attributes, MissingOrCancellingNormalsHaveADocumentedMean)
{
  const struct
  {
    std::vector<double> normals;
    Vec3 mean;
  } cases[] = {
    { { 0, 0, 2, 0, 0, notANumber, 0, 0, 2 }, { 0, 0, 1 } },
    { { notANumber, 0, 0, 0, infinite, 0, 0, 0, 0 }, { 0, 0, 0 } },
    { { 0, 0, 0, 0, 3, 0, 0, -7, 0 }, { 0, 1, 0 } }, // that of the lowest vertex that has one
    { { 3, 0, 4, -3, 0, -4, 3, 0, 4 }, { 0.6, 0, 0.8 } },
    { { 1, 1e-12, 0, -1, 0, 0, notANumber, notANumber, notANumber }, { 1, 1e-12, 0 } },
    { { 1e300, 0, 0, 0, 1e-300, 0, 0, 0, 0 }, { std::sqrt(0.5), std::sqrt(0.5), 0 } },
    { { 5e-324, 0, 0, 0, 0, 0, 0, 0, 0 }, { 1, 0, 0 } },
  };
  for (const auto& [normals, mean] : cases)
  {
    SCOPED_TRACE(::testing::PrintToString(normals));
    Mesh mesh;
    mesh.points.resize(3);
    mesh.attributes = { PointArray("Normals", AttributeType::Float64, 3, normals) };
    ClusterLevels levels = OneCluster(mesh);
    AddLevelAttributes(mesh, levels);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_NEAR(levels.levels[0].attributes.at(0).Get(0, k), mean[k], 1e-15);
    }
  }
}

// Two clusters whose order in their level is not that of their lowest vertices.
TEST(Attributes, NormalsThatCancelAcrossLevelsAreThatOfTheLowestVertex)
{
  Mesh mesh;
  mesh.points.resize(4);
  mesh.attributes = { PointArray(
    "Normals", AttributeType::Float32, 3, { notANumber, 0, 0, 0, 2, 0, 0, -1, 0, 0, 0, 0 }) };
  ClusterLevels levels;
  levels.finest = { 1, 1, 0, 0 };
  levels.levels.resize(2);
  levels.levels[0].lowest = { 0 };
  levels.levels[1].lowest = { 2, 0 };
  levels.levels[1].parents = { 0, 0 };
  AddLevelAttributes(mesh, levels);
  EXPECT_EQ(levels.levels[0].attributes.at(0).Get(0, 1), 1);
  EXPECT_EQ(levels.levels[1].attributes.at(0).Get(0, 1), -1);
  EXPECT_EQ(levels.levels[1].attributes.at(0).Get(1, 1), 1);
}

TEST(Attributes, SurfacesHaveOnlyWhatAllPiecesHave)
{
  const auto model = MakeModel(WithAttributes(Torus(40, 20), 3), { 90, {}, 5 });
  const Cut cut{ model->tree.depths, Resolution::Original(), {} };
  const std::size_t all = DrawSurface(cut, model->Lookup())->attributes.size();
  std::vector<Attribute>& last = model->pieces.rbegin()->second.attributes;
  last[0].name = "another name";
  last[2].type = AttributeType::Int8;
  const auto surface = DrawSurface(cut, model->Lookup());
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->attributes.size(), all - 2);
  EXPECT_TRUE(CheckAttributes(surface->attributes, surface->points.size(), 0));
}

TEST(Attributes, ColoursAreMeansOfLight)
{
  Mesh mesh;
  mesh.points.resize(4);
  mesh.attributes = { PointArray("RGBA", AttributeType::UInt8, 4,
    { 0, 255, 90, 255, 255, 255, 90, 0, 0, 255, 90, 0, 255, 255, 92, 255 }) };
  ClusterLevels levels = OneCluster(mesh);
  AddLevelAttributes(mesh, levels);
  EXPECT_EQ(
    levels.levels[0].attributes.at(0).values, (std::vector<std::uint8_t>{ 188, 255, 91, 128 }))
    << "half of white's light is shown by 188; alpha's mean is its own";
}

TEST(Attributes, SumsRefuseBytesThatNothingAddsUpTo)
{
  const std::vector<AttributeInfo> infos{ { "Normals", AttributeType::Float64,
                                            AttributeAssociation::Point, 3 },
    { "any", AttributeType::Float64, AttributeAssociation::Point, 3 },
    { "RGBA", AttributeType::UInt8, AttributeAssociation::Point, 4 } };
  AttributeSums sums(infos, 3);
  EXPECT_EQ(sums.RecordSize(), 96U);
  std::vector<Attribute> tuples;
  for (const AttributeInfo& info : infos)
  {
    tuples.push_back({ info, std::vector<std::uint8_t>(4 * info.TupleSize(), 255) });
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    tuples[0].Set(1, k, -0.5);
  }
  sums.AddVertices(tuples, std::vector<VertexId>{ 1, 1, noVertex, 2 });
  const std::vector<std::byte> good(sums.Bytes().begin(), sums.Bytes().end());
  const auto problem = [&](const std::vector<std::byte>& bytes)
  {
    const auto loaded = AttributeSums::FromBytes(infos, bytes);
    EXPECT_TRUE(!loaded || loaded->ClusterCount() == 3);
    return loaded ? "" : loaded.GetError().message;
  };
  EXPECT_EQ(problem(good), "");
  EXPECT_EQ(problem({ good.begin(), good.end() - 1 }),
    "sums of attributes: 287 bytes are not records of 96");
  // Changes a value of cluster 1 at a byte offset. Its record has the sum and the first direction
  // of normals, their count, the sums of colours, and their count.
  const auto changed = [&](std::size_t offset, auto value)
  {
    std::vector<std::byte> bytes = good;
    std::memcpy(&bytes[96 + offset], &value, sizeof(value));
    return problem(bytes);
  };
  const std::string wrong = "sums of attributes: no tuples add up to those of cluster 1";
  EXPECT_EQ(changed(8, infinite), wrong);
  EXPECT_EQ(changed(24, -infinite), wrong);
  EXPECT_EQ(changed(48, notANumber), wrong);
  EXPECT_EQ(changed(48, -1.0), wrong);
  EXPECT_EQ(changed(48, 7.0), "");
  EXPECT_EQ(changed(56, std::uint64_t{ 2 * wholeLight + 1 }), wrong) << "more than two whites";
  EXPECT_EQ(changed(80, std::uint64_t{ 511 }), wrong);
  EXPECT_EQ(changed(80, std::uint64_t{ 509 }), "");
  EXPECT_EQ(changed(88, std::uint64_t{ 1 } << 63), wrong) << "twice as many would be none";
  const std::vector<AttributeInfo> numbers{ { "time", AttributeType::Float64,
                                              AttributeAssociation::Point, 1 },
    { "kind", AttributeType::UInt8, AttributeAssociation::Point, 1 } };
  const auto ofNumbers = [&](std::size_t offset, auto value)
  {
    std::vector<std::byte> bytes(2 * 80);
    std::memcpy(&bytes[80 + offset], &value, sizeof(value));
    const auto loaded = AttributeSums::FromBytes(numbers, bytes);
    return loaded ? "" : loaded.GetError().message;
  };
  EXPECT_EQ(ofNumbers(0, 7.5), "");
  EXPECT_EQ(ofNumbers(0, notANumber), wrong);
  EXPECT_EQ(ofNumbers(8, std::uint64_t{ 1 } << 33), wrong);
  EXPECT_EQ(ofNumbers(72, std::uint64_t{ 7 }), "");
  EXPECT_EQ(ofNumbers(72, std::uint64_t{ 1 } << 32), wrong);
  EXPECT_EQ(ofNumbers(48, std::uint32_t{ 7 }), wrong) << "more than all votes";
  const std::vector<AttributeInfo> none{ infos[1] };
  EXPECT_TRUE(AttributeSums(none, 9).Empty());
  EXPECT_FALSE(AttributeSums::FromBytes(none, std::vector<std::byte>(1)));
}

TEST(Attributes, WeldingJoinsVerticesThatAreEqualInAllTheirArrays)
{
  std::mt19937 generator(9);
  const auto random = [&generator] { return static_cast<std::uint32_t>(generator()); };
  std::size_t joined = 0, apart = 0;
  for (int round = 0; round < 200; ++round)
  {
    Mesh mesh;
    for (unsigned i = random() % 40; i > 0; --i)
    {
      mesh.points.push_back({ double(random() % 2), random() % 2 == 0 ? 0.0 : -0.0, 0 });
    }
    for (unsigned i = random() % 30; i > 0 && !mesh.points.empty(); --i)
    {
      const auto any = [&] { return static_cast<VertexId>(random() % mesh.points.size()); };
      mesh.triangles.push_back({ any(), any(), any() });
    }
    if (round % 4 != 0)
    {
      mesh = WithAttributes(mesh, static_cast<std::uint32_t>(round));
    }
    if (round % 4 == 1)
    {
      std::erase_if(mesh.attributes, [](const Attribute& a) { return a.name != "A"; });
    }
    const Mesh before = mesh;
    const auto equal = [&](std::size_t a, std::size_t b)
    {
      return before.points[a] == before.points[b] &&
             std::signbit(before.points[a][1]) == std::signbit(before.points[b][1]) &&
             Bytes(before.attributes, AttributeAssociation::Point, a) ==
               Bytes(before.attributes, AttributeAssociation::Point, b);
    };
    std::vector<VertexId> place;
    std::vector<VertexId> kept;
    for (VertexId v = 0; v < before.points.size(); ++v)
    {
      const auto first =
        std::find_if(kept.begin(), kept.end(), [&](VertexId k) { return equal(k, v); });
      place.push_back(static_cast<VertexId>(first - kept.begin()));
      if (first == kept.end())
      {
        kept.push_back(v);
      }
      else
      {
        ++joined;
      }
      apart += std::any_of(kept.begin(), kept.end(),
        [&](VertexId k) { return k != v && before.points[k] == before.points[v]; });
    }
    EXPECT_EQ(WeldVertices(mesh), before.points.size() - kept.size());
    ASSERT_EQ(mesh.points.size(), kept.size());
    ASSERT_TRUE(CheckAttributes(mesh.attributes, mesh.points.size(), mesh.triangles.size()));
    for (std::size_t v = 0; v < kept.size(); ++v)
    {
      ASSERT_EQ(Bytes(mesh.attributes, AttributeAssociation::Point, v),
        Bytes(before.attributes, AttributeAssociation::Point, kept[v]));
    }
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ASSERT_EQ(mesh.triangles[i][k], place[before.triangles[i][k]]);
      }
      ASSERT_EQ(Bytes(mesh.attributes, AttributeAssociation::Cell, i),
        Bytes(before.attributes, AttributeAssociation::Cell, i));
    }
  }
  EXPECT_GT(joined, 500U);
  EXPECT_GT(apart, 500U);
}

TEST(Attributes, HaveSaneNumbersAndNames)
{
  const Attribute good = PointArray("good", AttributeType::Float32, 2, { 1, 2, 3, 4 });
  const auto problem = [](const std::vector<Attribute>& attributes)
  {
    const Status status = CheckAttributes(attributes, 2, 5);
    return status ? "" : status.GetError().message;
  };
  EXPECT_EQ(problem({ good }), "");
  const auto changed = [&](auto&& change)
  {
    Attribute attribute = good;
    change(attribute);
    return problem({ attribute });
  };
  EXPECT_TRUE(
    fixtures::Mentions(changed([](Attribute& a) { a.name = ""; }), { "attribute 0 ", " 0 bytes" }));
  EXPECT_EQ(changed([](Attribute& a) { a.name = std::string(255, 'x'); }), "");
  EXPECT_EQ(changed([](Attribute& a) { a.name = std::string(256, 'x'); }),
    "attribute 0 has a name of 256 bytes");
  EXPECT_EQ(changed([](Attribute& a) { a.components = 0; }), "attribute 0, \"good\", has 16 bytes");
  EXPECT_EQ(
    changed([](Attribute& a) { a.values.pop_back(); }), "attribute 0, \"good\", has 15 bytes");
  EXPECT_EQ(changed([](Attribute& a) { a.association = AttributeAssociation::Cell; }),
    "attribute 0, \"good\", has 16 bytes");
  EXPECT_EQ(changed(
              [](Attribute& a)
              {
                a.components = 0;
                a.values.clear();
              }),
    "attribute 0, \"good\", has 0 bytes");
  Attribute cell = PointArray("good", AttributeType::Int8, 1, { 1, 2, 3, 4, 5 });
  cell.association = AttributeAssociation::Cell;
  EXPECT_EQ(problem({ good, cell }), "");
  EXPECT_TRUE(fixtures::Mentions(problem({ good, cell, good }), { "attribute 2 ", "attribute 0" }));
  std::vector<Attribute> many;
  for (int i = 0; i < 255; ++i)
  {
    many.push_back(good);
    many.back().name = std::to_string(i);
  }
  EXPECT_EQ(problem(many), "");
  many.push_back(good);
  EXPECT_EQ(problem(many), "256 attributes; the maximum is 255");
}

TEST(Attributes, NamesAreTexts)
{
  for (const char* name :
    { "a", "Größe", "温度", "\xF0\x9F\x90\x89", "a b", "\xC2\xA0", "\xED\x9F\xBF" })
  {
    EXPECT_TRUE(IsAttributeName(name)) << name;
  }
  EXPECT_TRUE(IsAttributeName(std::string(255, 'x')));
  EXPECT_FALSE(IsAttributeName(std::string(256, 'x')));
  for (const char* name : { "", "\n", "a\x7F", "\x80", "\xC0\xAF", "\xC3", "a\xC3(", "\xE0\x80\xAF",
         "\xED\xA0\x80", "\xF0\x80\x80\x80", "\xF4\x90\x80\x80", "\xF8\x88\x80\x80\x80", "\xC2\x85",
         "caf\xE9", "\xE6\xB8", "\xFF" })
  {
    EXPECT_FALSE(IsAttributeName(name)) << ::testing::PrintToString(std::string(name));
  }
}
