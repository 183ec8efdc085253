// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Weld.h"
#include "filters/outofcore/Testing/BlockTools.h"
#include "filters/outofcore/mesh/PlaceCount.h"
#include "filters/program/TbbExecution.h"

#include <cmath>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

// The point on a coarse grid.
Vec3 Rounded(const Vec3& p)
{
  return { std::round(p[0] * 8) / 8, std::round(p[1] * 8) / 8, std::round(p[2] * 8) / 8 };
}

template <class Scalar>
void CheckCount(const std::vector<Vec3>& points)
{
  const Mesh mesh{ points, {} };
  SpillFolder folder = MakeSpillFolder();
  const SpillFile records = SpilledRecords<Scalar>(folder, points);
  const auto count = static_cast<std::uint32_t>(points.size());
  const std::size_t exact = CountPlaces(count, [&](VertexId v) { return points[v]; });
  const std::size_t rounded = CountPlaces(count, [&](VertexId v) { return Rounded(points[v]); });
  for (const std::uint64_t memory : { 1U << 20, 3000U, 1U })
  {
    for (const unsigned threads : { 1U, 3U })
    {
      const Execution execution = MakeTbbExecution(threads);
      const auto places =
        CountPlacesExternally<Scalar>(folder, records, count, {}, memory, execution);
      ASSERT_TRUE(places);
      EXPECT_EQ(*places, exact) << "with " << memory << " bytes";
      const auto together =
        CountPlacesExternally<Scalar>(folder, records, count, Rounded, memory, execution);
      ASSERT_TRUE(together);
      EXPECT_EQ(*together, rounded) << "with " << memory << " bytes";
    }
  }
}

}

TEST(CountPlacesExternally, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    CheckCount<double>(named.mesh.points);
  }
}

TEST(CountPlacesExternally, ZerosAreOnePlaceAndManyEqualTakeNoMemory)
{
  std::vector<Vec3> points;
  for (int i = 0; i < 20000; ++i)
  {
    points.push_back({ i % 2 ? 0.0 : -0.0, i % 3 ? -0.0 : 0.0, double(i < 19000 ? 7 : i) });
  }
  CheckCount<double>(points);
  CheckCount<float>(points);
}
