// SPDX-License-Identifier: BSD-3-Clause
// Stores as VTK gets them: whole and in parts; each cell once, whatever the number of pieces.
#include "filters/baselines/stores/Baselines.h"
#include "filters/core/UnusedVertices.h"
#include "filters/core/tree/Region.h"
#include "filters/store/Store.h"
#include "filters/store/StoreMesh.h"
#include "viewer/sources/Testing/Cxx/ModelSourceTools.h"

#include <vtkCompositeDataPipeline.h>
#include <vtkDataArraySelection.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationDoubleVectorKey.h>
#include <vtkInformationIdTypeKey.h>
#include <vtkInformationInformationVectorKey.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationIntegerVectorKey.h>
#include <vtkInformationObjectBaseKey.h>
#include <vtkInformationStringKey.h>
#include <vtkInformationVector.h>
#include <vtkKdStoreReader.h>
#include <vtkKdTreePartition.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnsignedCharArray.h>

#include <fstream>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;
using fixtures::TemporaryFolder;

class TestKdStoreReader : public ::testing::Test
{
protected:
  void Open(const Mesh& mesh, std::uint32_t verticesPerPartition = 200,
    const PartitionMethod* partitioner = &KdTreeMethod())
  {
    BuildTo(this->File, mesh, verticesPerPartition, partitioner);
    this->Reader->SetFileName(this->File.c_str());
    this->Model = *Store::Open(this->File);
  }
  vtkDataObject* Update()
  {
    this->Reader->Update();
    return this->Reader->GetOutputDataObject(0);
  }
  // Updates, checks that the output is empty, and returns the error.
  std::string Refusal()
  {
    FilterObserver heard(this->Reader);
    this->Reader->Modified();
    EXPECT_TRUE(ContentOf(this->Update(), true).points.empty());
    return heard.error;
  }

  const Mesh Sphere = fixtures::DisplacedSphere(6);
  TemporaryFolder Folder;
  const std::filesystem::path File = this->Folder / "model.kds";
  std::shared_ptr<Store> Model;
  vtkNew<vtkKdStoreReader> Reader;
};

TEST_F(TestKdStoreReader, PartitionsAreThoseOfTheFilterToTheBit)
{
  this->Open(this->Sphere);
  const PolyData mesh = AsPolyData(this->Sphere);
  vtkNew<vtkKdTreePartition> filter;
  filter->SetInputData(mesh);
  filter->SetVerticesPerPartition(200);
  filter->Update();
  const unsigned int count = filter->GetOutput()->GetNumberOfPartitions();
  ASSERT_EQ(count, 128u);
  vtkDataObject* const output = this->Update();
  ASSERT_EQ(vtkPartitionedDataSet::SafeDownCast(output)->GetNumberOfPartitions(), count);
  for (unsigned int i = 0; i < count; ++i)
  {
    for (const bool marked : { false, true })
    {
      const Content here = ContentOfPartition(output, i, marked);
      EXPECT_TRUE(here == ContentOfPartition(filter->GetOutput(), i, marked)) << i;
      EXPECT_GT(here.cells.size(), 100u);
    }
  }
  EXPECT_TRUE(ContentOf(output) == ContentOf(mesh));
}

// One mesh is the input, without points that no triangle uses.
TEST_F(TestKdStoreReader, OneMeshIsTheInput)
{
  for (const auto& [name, mesh] : fixtures::HardMeshes())
  {
    SCOPED_TRACE(name);
    Mesh plain = mesh;
    plain.attributes.clear();
    this->Reader->SetOutputTypeToPolyData();
    BuildOptions options;
    options.bits = 0;
    options.weld = false;
    options.tree.verticesPerPartition = 20;
    ASSERT_TRUE(BuildStore(plain, "mesh", this->File, options));
    this->Reader->SetFileName(this->File.c_str());
    this->Reader->Modified();
    vtkDataObject* const output = this->Update();
    TakeUnusedVertices(plain, FindUsedVertices(plain));
    const PolyData input = AsPolyData(plain);
    EXPECT_TRUE(ContentOf(output) == ContentOf(input));
    EXPECT_EQ(vtkPolyData::SafeDownCast(output)->GetPoints()->GetDataType(),
      input->GetPoints()->GetDataType());
  }
}

TEST_F(TestKdStoreReader, ALevelIsThereOnceInPiecesOrWhole)
{
  this->Open(this->Sphere, 50);
  this->Reader->SetContentToLevel();
  const ModelDescription& info = this->Model->Info();
  for (unsigned level = 3; level <= info.depths.finest; ++level)
  {
    this->Reader->SetLevelDepth(static_cast<int>(level));
    this->Reader->SetOutputTypeToPartitionedDataSet();
    const Content pieces = ContentOf(this->Update());
    EXPECT_EQ(pieces.cells.size(), info.levels[level].triangles);
    EXPECT_EQ(pieces.points.size(), info.levels[level].vertices);
    this->Reader->SetOutputTypeToPolyData();
    EXPECT_TRUE(ContentOf(this->Update()) == pieces) << level;
  }
  this->Reader->SetLevelDepth(-1);
  EXPECT_EQ(ContentOf(this->Update()).points.size(), info.levels[PreviewLevel(info)].vertices);
  EXPECT_EQ(this->Reader->GetPreviewLevel(), static_cast<int>(PreviewLevel(info)));
  EXPECT_EQ(this->Reader->GetLevelRange()[0], -1);
  EXPECT_EQ(this->Reader->GetLevelRange()[1], static_cast<int>(info.depths.finest));
}

TEST_F(TestKdStoreReader, PiecesOfAPipelineHaveAllOfItOnce)
{
  this->Open(this->Sphere, 50);
  for (const int content : { vtkKdModelSource::Original, vtkKdModelSource::Level })
  {
    this->Reader->SetContent(content);
    this->Reader->SetLevelDepth(static_cast<int>(this->Model->Info().depths.finest));
    for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
    {
      this->Reader->SetOutputType(type);
      const Content whole = ContentOf(this->Update());
      for (const int pieces : { 2, 3, 4, 150 })
      {
        for (const int ghosts : { 0, 1 })
        {
          Content all;
          std::size_t marked = 0;
          for (int piece = 0; piece < pieces; ++piece)
          {
            this->Reader->UpdatePiece(piece, pieces, ghosts);
            const Content part = ContentOf(this->Reader->GetOutputDataObject(0));
            const Content with = ContentOf(this->Reader->GetOutputDataObject(0), true);
            all.points.insert(all.points.end(), part.points.begin(), part.points.end());
            all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
            marked += with.cells.size() - part.cells.size();
          }
          EXPECT_TRUE(all.Sort() == whole) << content << type << pieces << ghosts;
          EXPECT_EQ(marked > 0, ghosts > 0 || type == vtkKdModelSource::PartitionedDataSet)
            << content << type << pieces << ghosts;
        }
      }
      // Far more pieces than points: memory does not grow with the number of pieces.
      this->Reader->UpdatePiece(1, VTK_INT_MAX, 1);
      EXPECT_EQ(this->Reader->GetOutputDataObject(0)->GetNumberOfElements(vtkDataObject::POINT), 0);
      EXPECT_EQ(this->Reader->GetErrorCode(), 0U);
    }
  }
}

// With ghost levels, no own point lacks a cell.
TEST_F(TestKdStoreReader, GhostLevelsBringTheCellsAround)
{
  this->Open(this->Sphere, 50);
  this->Reader->SetOutputTypeToPolyData();
  const PolyData whole = AsPolyData(this->Sphere);
  std::map<std::array<double, 3>, std::size_t> cellsAt;
  for (const auto& corners : ContentOf(whole).cells)
  {
    for (const auto& corner : corners)
    {
      ++cellsAt[corner];
    }
  }
  std::size_t cells = 0;
  for (const int ghosts : { 1, 2 })
  {
    this->Reader->UpdatePiece(1, 4, ghosts);
    const Content own = ContentOf(this->Reader->GetOutputDataObject(0));
    const Content with = ContentOf(this->Reader->GetOutputDataObject(0), true);
    std::map<std::array<double, 3>, std::size_t> here;
    for (const auto& corners : with.cells)
    {
      for (const auto& corner : corners)
      {
        ++here[corner];
      }
    }
    for (const auto& point : own.points)
    {
      EXPECT_EQ(here[point], cellsAt[point]);
    }
    EXPECT_GT(with.cells.size(), cells);
    cells = with.cells.size();
  }
}

TEST_F(TestKdStoreReader, ARegionIsThatOfTheViewers)
{
  this->Open(this->Sphere, 50);
  const auto boxes = *this->Model->ReadBoxes();
  const TreeDepths& depths = this->Model->Info().depths;
  const Vec3 point{ 0.3, 0.9, 0.1 };
  this->Reader->SetContentToRegion();
  this->Reader->SetRegionPoint(point.data());
  std::size_t last = 0;
  for (const unsigned rings : { 0u, 1u, 3u })
  {
    const NodeId cell = NodeOfPartition(NearestPartition(boxes, depths, point), depths);
    const auto partitions = *FindRegion(boxes, depths, cell, rings);
    const PolyData expected = AsPolyData(*GlueStoreMesh(*this->Model, partitions));
    this->Reader->SetRings(static_cast<int>(rings));
    this->Reader->SetOutputTypeToPolyData();
    EXPECT_TRUE(ContentOf(this->Update()) == ContentOf(expected)) << rings;
    this->Reader->SetOutputTypeToPartitionedDataSet();
    vtkDataObject* const parts = this->Update();
    EXPECT_EQ(LoadedPartitions(parts), partitions.size());
    EXPECT_TRUE(ContentOf(parts).cells == ContentOf(expected).cells);
    EXPECT_GT(partitions.size(), last);
    last = partitions.size();
  }
}

// The surface is fine where the camera looks, closed, and coarser with a smaller budget.
TEST_F(TestKdStoreReader, ACameraGetsWhatItNeeds)
{
  this->Open(fixtures::DisplacedSphere(8), 200); // 327,682 vertices
  this->Reader->SetOutputTypeToPolyData();
  this->Reader->SetContentToView();
  this->Reader->SetCameraPosition(0, 0, 1.3);
  this->Reader->SetPictureSize(800, 480);
  const auto cells = [this]
  {
    const Content drawn = ContentOf(this->Update());
    std::map<std::pair<std::array<double, 3>, std::array<double, 3>>, int> edges;
    for (const auto& c : drawn.cells)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ++edges[{ c[k], c[(k + 1) % 3] }];
        --edges[{ c[(k + 1) % 3], c[k] }];
      }
    }
    for (const auto& [edge, count] : edges)
    {
      EXPECT_EQ(count, 0); // as often in both directions: closed
    }
    return drawn.cells;
  };
  const auto near = cells();
  const auto before = [](const auto& corners) { return corners[0][2] > 0; };
  const auto front = std::count_if(near.begin(), near.end(), before);
  EXPECT_GT(front, 10 * (static_cast<std::ptrdiff_t>(near.size()) - front));
  EXPECT_GT(near.size(), 20000u);
  this->Reader->SetNumberOfTriangles(10000);
  const auto few = cells();
  EXPECT_LT(few.size(), 15000u);
  EXPECT_GT(few.size(), 5000u);
  this->Reader->SetNumberOfTriangles(2000000);
  this->Reader->SetCameraPosition(0, 0, 50);
  EXPECT_LT(cells().size(), 6000u);
  // A narrower angle of view needs finer pieces, as a nearer camera does.
  this->Reader->SetCameraViewAngle(0.5);
  EXPECT_GT(cells().size(), 20000u);
  this->Reader->SetOutputTypeToPartitionedDataSet();
  EXPECT_EQ(LoadedPartitions(this->Update()), 1u);
  this->Reader->SetCameraPosition(0, 0, 50);
  {
    FilterObserver heard(this->Reader);
    this->Reader->SetCameraViewAngle(200);
    this->Reader->SetPictureSize(-800, 480);
    EXPECT_NE(heard.error.find("must be above 0 and below 180 degrees, not 200: it stays 0.5"),
      std::string::npos)
      << heard.error;
    EXPECT_NE(heard.error.find("PictureSize must be at least 1 x 1"), std::string::npos);
  }
  EXPECT_EQ(this->Reader->GetPictureSize()[0], 800);
  EXPECT_STREQ(this->Reader->GetContentAsString(), "View");
  EXPECT_STREQ(this->Reader->GetOutputTypeAsString(), "PartitionedDataSet");
  this->Reader->SetCameraPosition(0, 0, 0);
  EXPECT_NE(this->Refusal().find("camera: the eye is at the focal point"), std::string::npos);
}

TEST_F(TestKdStoreReader, InvalidNumbersAreRefused)
{
  using Source = vtkKdModelSource;
  Source& source = *this->Reader;
  EXPECT_EQ(
    NotFiniteTakenBy(source, "RegionPoint", &Source::SetRegionPoint, &Source::GetRegionPoint), "");
  EXPECT_EQ(NotFiniteTakenBy(
              source, "CameraPosition", &Source::SetCameraPosition, &Source::GetCameraPosition),
    "");
  EXPECT_EQ(NotFiniteTakenBy(source, "CameraFocalPoint", &Source::SetCameraFocalPoint,
              &Source::GetCameraFocalPoint),
    "");
  EXPECT_EQ(
    NotFiniteTakenBy(source, "CameraViewUp", &Source::SetCameraViewUp, &Source::GetCameraViewUp),
    "");
  FilterObserver heard(this->Reader);
  this->Reader->SetLevelDepth(-2);
  EXPECT_NE(heard.error.find("LevelDepth must be from -1 to 62, not -2"), std::string::npos);
  const double finite[] = { 7, 8, 9 };
  this->Reader->SetRegionPoint(finite);
  EXPECT_EQ(this->Reader->GetRegionPoint()[2], 9);
}

TEST_F(TestKdStoreReader, OnlyWhatIsAskedForIsLoaded)
{
  this->Open(this->Sphere);
  this->Reader->SetContentToPartitions();
  for (const vtkIdType partition : { 9, 3, 9 })
  {
    this->Reader->AddPartition(partition);
  }
  EXPECT_EQ(LoadedPartitions(this->Update()), 2u);
  this->Reader->UpdatePiece(0, 2, 2); // no requested partition is around them
  EXPECT_EQ(LoadedPartitions(this->Reader->GetOutputDataObject(0)), 2u);
  this->Reader->RemoveAllPartitions();
  EXPECT_EQ(LoadedPartitions(this->Update()), 0u);

  this->Reader->SetContentToOriginal();
  this->Reader->UpdateInformation();
  vtkInformation* const info = this->Reader->GetOutputInformation(0);
  const int indices[] = { 1, 6, 128 };
  info->Set(vtkCompositeDataPipeline::LOAD_REQUESTED_BLOCKS(), 1);
  info->Set(vtkCompositeDataPipeline::UPDATE_COMPOSITE_INDICES(), indices, 3);
  vtkDataObject* const output = this->Update();
  EXPECT_EQ(LoadedPartitions(output), 3u);
  auto* const parts = vtkPartitionedDataSet::SafeDownCast(output);
  for (const unsigned int i : { 0u, 5u, 127u })
  {
    EXPECT_NE(parts->GetPartitionAsDataObject(i), nullptr) << i;
  }
}

// By default, only the store's metadata is read for this.
TEST_F(TestKdStoreReader, InformationIsReportedWithoutDecoding)
{
  this->Open(this->Sphere);
  FilterObserver heard(this->Reader);
  this->Reader->UpdateInformation();
  const std::size_t steps = heard.progress.size();
  const auto reported = [this]
  {
    return vtkPartitionedDataSet::SafeDownCast(this->Reader->GetOutputInformation(0)->Get(
      vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA()));
  };
  ASSERT_NE(reported(), nullptr);
  ASSERT_EQ(reported()->GetNumberOfPartitions(), 128u);
  const auto boxes = *this->Model->ReadBoxes();
  for (unsigned int i = 0; i < 128; ++i)
  {
    const Box& own = boxes[NodeOfPartition(i, this->Model->Info().depths)];
    const double* const box = reported()->GetMetaData(i)->Get(vtkDataObject::BOUNDING_BOX());
    ASSERT_NE(box, nullptr);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_EQ(box[2 * k], own.lo[k]);
      EXPECT_EQ(box[2 * k + 1], own.hi[k]);
    }
    EXPECT_FALSE(reported()->GetMetaData(i)->Has(vtkKdModelSource::NUMBER_OF_POINTS()));
  }
  this->Reader->MeasureOriginalOn();
  this->Reader->UpdateInformation();
  EXPECT_GT(heard.progress.size(), 2 * steps + 2) << "it is decoded now";
  EXPECT_TRUE(reported()->GetMetaData(0u)->Has(vtkKdModelSource::NUMBER_OF_POINTS()));
  this->Reader->MeasureOriginalOff();
  this->Reader->UpdateInformation();
  EXPECT_FALSE(reported()->GetMetaData(0u)->Has(vtkKdModelSource::NUMBER_OF_POINTS()));
}

TEST_F(TestKdStoreReader, BoundsAreReportedBeforeAnythingIsLoaded)
{
  this->Open(this->Sphere);
  this->Reader->MeasureOriginalOn();
  this->Reader->UpdateInformation();
  auto* const reported =
    vtkPartitionedDataSet::SafeDownCast(this->Reader->GetOutputInformation(0)->Get(
      vtkCompositeDataPipeline::COMPOSITE_DATA_META_DATA()));
  ASSERT_NE(reported, nullptr);
  ASSERT_EQ(reported->GetNumberOfPartitions(), 128u);
  EXPECT_EQ(this->Reader->GetNumberOfModelPartitions(), 128);
  EXPECT_EQ(
    this->Reader->GetNumberOfModelPoints(), static_cast<vtkIdType>(this->Sphere.points.size()));
  auto* const output = vtkPartitionedDataSet::SafeDownCast(this->Update());
  for (unsigned int i = 0; i < 128; ++i)
  {
    auto* const part = vtkPolyData::SafeDownCast(output->GetPartitionAsDataObject(i));
    ASSERT_NE(part, nullptr);
    const double* const box = reported->GetMetaData(i)->Get(vtkDataObject::BOUNDING_BOX());
    const double* const loaded = output->GetMetaData(i)->Get(vtkDataObject::BOUNDING_BOX());
    ASSERT_TRUE(box && loaded);
    EXPECT_TRUE(std::equal(box, box + 6, part->GetBounds())) << i << ": not with its ghosts";
    EXPECT_TRUE(std::equal(loaded, loaded + 6, part->GetBounds())) << i;
    EXPECT_EQ(reported->GetMetaData(i)->Get(vtkKdModelSource::NUMBER_OF_POINTS()),
      part->GetNumberOfPoints());
    EXPECT_EQ(
      reported->GetMetaData(i)->Get(vtkKdModelSource::NUMBER_OF_CELLS()), part->GetNumberOfCells());
  }
}

TEST_F(TestKdStoreReader, TheModelIsReportedBeforeItIsLoaded)
{
  Mesh mesh = this->Sphere;
  const auto add = [&](const char* name, AttributeAssociation of, std::size_t count, double step)
  {
    Attribute array{ { name, AttributeType::Float64, of, 1 }, {} };
    array.values.resize(8 * count);
    for (std::size_t i = 0; i < count; ++i)
    {
      array.Set(i, 0, 5 + step * double(i));
    }
    mesh.attributes.push_back(array);
  };
  add("Heat", AttributeAssociation::Point, mesh.points.size(), 2);
  add("Weight", AttributeAssociation::Cell, mesh.triangles.size(), -1);
  this->Open(mesh);
  for (const bool measured : { false, true })
    for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
    {
      this->Reader->SetMeasureOriginal(measured);
      this->Reader->SetOutputType(type);
      this->Reader->SetContentToOriginal();
      this->Reader->UpdateInformation();
      vtkInformation* const info = this->Reader->GetOutputInformation(0);
      const Box& box = this->Model->Info().box;
      const double ends[6] = { box.lo[0], box.hi[0], box.lo[1], box.hi[1], box.lo[2], box.hi[2] };
      for (vtkInformationDoubleVectorKey* const key :
        { vtkDataObject::BOUNDING_BOX(), vtkStreamingDemandDrivenPipeline::BOUNDS() })
      {
        ASSERT_EQ(info->Length(key), 6);
        EXPECT_TRUE(std::equal(ends, ends + 6, info->Get(key)));
      }
      const auto points = static_cast<vtkIdType>(mesh.points.size());
      const auto cells = static_cast<vtkIdType>(mesh.triangles.size());
      EXPECT_EQ(info->Get(vtkKdModelSource::NUMBER_OF_POINTS()), points);
      EXPECT_EQ(info->Get(vtkKdModelSource::NUMBER_OF_CELLS()), cells);
      vtkInformationVector* const ofPoints = info->Get(vtkDataObject::POINT_DATA_VECTOR());
      ASSERT_EQ(ofPoints->GetNumberOfInformationObjects(), 1);
      vtkInformation* const heat = ofPoints->GetInformationObject(0);
      EXPECT_STREQ(heat->Get(vtkDataObject::FIELD_NAME()), "Heat");
      EXPECT_EQ(heat->Get(vtkDataObject::FIELD_ARRAY_TYPE()), VTK_DOUBLE);
      EXPECT_EQ(heat->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS()), 1);
      EXPECT_EQ(heat->Get(vtkDataObject::FIELD_NUMBER_OF_TUPLES()), points);
      ASSERT_EQ(heat->Length(vtkDataObject::FIELD_RANGE()), 2);
      EXPECT_EQ(heat->Get(vtkDataObject::FIELD_RANGE())[0], 5);
      EXPECT_EQ(heat->Get(vtkDataObject::FIELD_RANGE())[1], 5 + 2 * double(points - 1));
      vtkInformationVector* const ofCells = info->Get(vtkDataObject::CELL_DATA_VECTOR());
      ASSERT_EQ(ofCells->GetNumberOfInformationObjects(), 1);
      vtkInformation* const weight = ofCells->GetInformationObject(0);
      EXPECT_STREQ(weight->Get(vtkDataObject::FIELD_NAME()), "Weight");
      EXPECT_EQ(weight->Get(vtkDataObject::FIELD_NUMBER_OF_TUPLES()), cells);
      ASSERT_EQ(weight->Length(vtkDataObject::FIELD_RANGE()), measured ? 2 : 0);
      if (measured)
      {
        EXPECT_EQ(weight->Get(vtkDataObject::FIELD_RANGE())[0], 5 - double(cells - 1));
      }
      this->Reader->SetContentToLevel();
      this->Reader->SetLevelDepth(6);
      this->Reader->UpdateInformation();
      EXPECT_EQ(info->Get(vtkKdModelSource::NUMBER_OF_POINTS()),
        static_cast<vtkIdType>(this->Model->Info().levels[6].vertices));
      EXPECT_EQ(info->Get(vtkDataObject::CELL_DATA_VECTOR())->GetNumberOfInformationObjects(), 0);
      this->Reader->SetContentToRegion();
      this->Reader->UpdateInformation();
      EXPECT_FALSE(info->Has(vtkKdModelSource::NUMBER_OF_POINTS()));
    }
}

TEST_F(TestKdStoreReader, IdsAreIdsAgain)
{
  Mesh mesh = this->Sphere;
  for (const char* name : { "GlobalIds", "PedigreeIds" })
  {
    Attribute array{ { name, AttributeType::Int64, AttributeAssociation::Point, 1 }, {} };
    array.values.resize(8 * mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      array.Set(i, 0, double(3 * i));
    }
    mesh.attributes.push_back(array);
  }
  this->Open(mesh);
  this->Reader->SetOutputTypeToPolyData();
  auto* const output = vtkPolyData::SafeDownCast(this->Update());
  vtkDataArray* const ids = output->GetPointData()->GetGlobalIds();
  ASSERT_NE(ids, nullptr);
  EXPECT_EQ(ids->GetDataType(), VTK_ID_TYPE);
  ASSERT_NE(output->GetPointData()->GetPedigreeIds(), nullptr);
  for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
  {
    const Vec3& there = mesh.points[static_cast<std::size_t>(ids->GetComponent(i, 0)) / 3];
    ASSERT_EQ(Point(*output, i), there);
  }
  this->Reader->SetContentToLevel();
  EXPECT_EQ(vtkPolyData::SafeDownCast(this->Update())->GetPointData()->GetNumberOfArrays(), 0)
    << "levels have no ids";
}

TEST_F(TestKdStoreReader, SelectionsFollowTheStore)
{
  const auto build = [this](const char* file, std::vector<const char*> names)
  {
    Mesh mesh = this->Sphere;
    for (const char* name : names)
    {
      Attribute array{ { name, AttributeType::Float32, AttributeAssociation::Point, 1 }, {} };
      array.values.resize(4 * mesh.points.size());
      mesh.attributes.push_back(array);
    }
    BuildTo(this->Folder / file, mesh, 200);
  };
  build("first.kds", { "Heat", "Age" });
  build("second.kds", { "Heat", "Depth" });
  vtkDataArraySelection* const arrays = this->Reader->GetPointDataArraySelection();
  this->Reader->SetFileName((this->Folder / "first.kds").c_str());
  this->Reader->UpdateInformation();
  arrays->DisableArray("Heat");
  this->Reader->SetFileName((this->Folder / "second.kds").c_str());
  this->Reader->SetOutputTypeToPolyData();
  auto* const output = vtkPolyData::SafeDownCast(this->Update());
  EXPECT_EQ(arrays->GetNumberOfArrays(), 2);
  EXPECT_FALSE(arrays->ArrayExists("Age"));
  EXPECT_FALSE(arrays->ArrayIsEnabled("Heat"));
  ASSERT_EQ(output->GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_STREQ(output->GetPointData()->GetArrayName(0), "Depth");
}

TEST_F(TestKdStoreReader, ReportsWhatItCanRead)
{
  FilterObserver heard(this->Reader);
  BuildTo(this->File, this->Sphere, 200);
  EXPECT_EQ(this->Reader->CanReadFile(this->File.c_str()), 1);
  std::ofstream(this->Folder / "words.kds") << "no store";
  EXPECT_EQ(this->Reader->CanReadFile((this->Folder / "words.kds").c_str()), 0);
  EXPECT_EQ(this->Reader->CanReadFile("/nonexistent.kds"), 0);
  EXPECT_EQ(this->Reader->CanReadFile(nullptr), 0);
  EXPECT_EQ(heard.error + heard.warning, "");
}

TEST_F(TestKdStoreReader, ArraysCanBeChosen)
{
  Mesh mesh = this->Sphere;
  for (const char* name : { "Heat", "Age" })
  {
    Attribute array{ { name, AttributeType::Float32, AttributeAssociation::Point, 1 }, {} };
    array.values.resize(4 * mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      array.Set(i, 0, mesh.points[i][2]);
    }
    mesh.attributes.push_back(array);
  }
  this->Open(mesh);
  this->Reader->SetOutputTypeToPolyData();
  this->Reader->UpdateInformation();
  EXPECT_EQ(this->Reader->GetPointDataArraySelection()->GetNumberOfArrays(), 2);
  this->Reader->GetPointDataArraySelection()->DisableArray("Age");
  auto* const output = vtkPolyData::SafeDownCast(this->Update());
  ASSERT_EQ(output->GetPointData()->GetNumberOfArrays(), 1);
  vtkDataArray* const heat = output->GetPointData()->GetArray("Heat");
  ASSERT_NE(heat, nullptr);
  for (vtkIdType i = 0; i < output->GetNumberOfPoints(); i += 100)
  {
    EXPECT_EQ(static_cast<float>(Point(*output, i)[2]), heat->GetComponent(i, 0));
  }
}

TEST_F(TestKdStoreReader, StoresWithoutLevelsGiveTheirPartitions)
{
  this->Open(this->Sphere, 200, &OctreeMethod());
  EXPECT_TRUE(ContentOf(this->Update()) == ContentOf(AsPolyData(this->Sphere)));
  EXPECT_EQ(this->Reader->GetFinestLevel(), -1);
  this->Reader->UpdatePiece(0, 3, 0);
  this->Reader->SetContentToLevel();
  EXPECT_NE(this->Refusal().find("has no levels"), std::string::npos);
}

TEST_F(TestKdStoreReader, CloudsHaveACellForEachPoint)
{
  const Mesh cloud = fixtures::Cloud(4);
  this->Open(cloud, 100);
  for (const int type : { vtkKdModelSource::PartitionedDataSet, vtkKdModelSource::PolyData })
  {
    this->Reader->SetOutputType(type);
    EXPECT_TRUE(ContentOf(this->Update()) == ContentOf(AsPolyData(cloud)));
    for (const int ghosts : { 0, 1 })
    {
      Content all;
      for (int piece = 0; piece < 3; ++piece)
      {
        this->Reader->UpdatePiece(piece, 3, ghosts);
        const Content part = ContentOf(this->Reader->GetOutputDataObject(0));
        all.points.insert(all.points.end(), part.points.begin(), part.points.end());
        all.cells.insert(all.cells.end(), part.cells.begin(), part.cells.end());
      }
      EXPECT_TRUE(all.Sort() == ContentOf(AsPolyData(cloud)));
    }
  }
  this->Reader->SetContentToLevel();
  EXPECT_GT(ContentOf(this->Update()).cells.size(), 100u);
}

TEST_F(TestKdStoreReader, ErrorsNameTheFileAndWhatIsWrong)
{
  EXPECT_NE(this->Refusal().find("): no FileName is set"), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoFileNameError);
  this->Reader->SetFileName((this->Folder / "none.kds").c_str());
  EXPECT_NE(this->Refusal().find("none.kds: "), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::FileNotFoundError);
  this->Open(this->Sphere);
  this->Update();
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::NoError);
  this->Reader->SetContentToPartitions();
  this->Reader->AddPartition(128);
  EXPECT_NE(
    this->Refusal().find("there is no partition 128: the model has 128"), std::string::npos);
  this->Reader->SetContentToLevel();
  this->Reader->SetLevelDepth(40);
  EXPECT_NE(this->Refusal().find("there is no level 40: the finest is "), std::string::npos);
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::UnknownError);
  // Damages bytes in the second half of the file.
  const auto size = std::filesystem::file_size(this->File);
  std::fstream bytes(this->File, std::ios::in | std::ios::out | std::ios::binary);
  for (auto at = static_cast<std::streamoff>(size / 2); at < static_cast<std::streamoff>(size);
       at += 4096)
  {
    bytes.seekp(at + 100);
    bytes.put('\x5a');
  }
  bytes.close();
  this->Reader->SetContentToOriginal();
  const std::string damaged = this->Refusal();
  EXPECT_NE(damaged.find("model.kds: "), std::string::npos) << damaged;
  EXPECT_EQ(this->Reader->GetErrorCode(), vtkErrorCode::FileFormatError);
}

TEST_F(TestKdStoreReader, ReportsProgressAndStopsWhenAborted)
{
  this->Open(this->Sphere, 20);
  {
    FilterObserver heard(this->Reader);
    this->Update();
    EXPECT_GT(heard.progress.size(), 2u);
  }
  FilterObserver heard(this->Reader);
  heard.abortAt = 0.1;
  this->Reader->Modified();
  EXPECT_EQ(LoadedPartitions(this->Update()), 0u);
  EXPECT_EQ(heard.error, "");
  // Aborts while the pieces that were read are made into one mesh.
  this->Reader->SetOutputTypeToPolyData();
  heard.abortAt = 0.82;
  for (const int content :
    { vtkKdModelSource::Original, vtkKdModelSource::Level, vtkKdModelSource::View })
  {
    this->Reader->SetContent(content);
    this->Reader->SetLevelDepth(this->Reader->GetFinestLevel());
    EXPECT_TRUE(ContentOf(this->Update(), true).points.empty()) << content;
    EXPECT_EQ(heard.error, "");
  }
}

TEST_F(TestKdStoreReader, WhatWasStoppedBeforeItWasLoadedIsLoadedByTheNextUpdate)
{
  this->Open(this->Sphere, 20);
  this->Reader->MeasureOriginalOn();
  {
    FilterObserver heard(this->Reader);
    heard.abortAt = 0;
    this->Reader->UpdateInformation();
    EXPECT_EQ(this->Reader->GetNumberOfModelPoints(), 0) << "it was stopped";
  }
  EXPECT_GT(LoadedPartitions(this->Update()), 1000u);
  EXPECT_GT(this->Reader->GetNumberOfModelPoints(), 0);
}

}
