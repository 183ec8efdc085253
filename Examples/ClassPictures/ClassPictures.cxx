// SPDX-License-Identifier: BSD-3-Clause
// Uses each class, and draws the pictures of doc/from-vtk.md.
//   ClassPictures MESH.ply TEXTURED.kds FOLDER
#ifdef HAS_POINT_CLOUD
#include <vtkPCLSurfaceReconstruction.h>
#endif
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkDataSetSurfaceFilter.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkKMeansPartition.h>
#include <vtkKdClusterSimplification.h>
#include <vtkKdMeshReader.h>
#include <vtkKdStoreReader.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdStreamActor.h>
#include <vtkKdTextureReader.h>
#include <vtkKdTreePartition.h>
#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkOctreePartition.h>
#include <vtkPNGWriter.h>
#include <vtkPartitionMeasures.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <cmath>
#include <string>
#include <vector>

namespace
{

using Actor = vtkSmartPointer<vtkActor>;
using Color = std::vector<double>;

const Color stone{ 0.85, 0.8, 0.72 };

// Hues at steps of the golden ratio, so that neighbours differ.
Color ColorOf(unsigned int number)
{
  double rgb[3];
  vtkMath::HSVToRGB(std::fmod(0.618 * number, 1.0), 0.5, 0.95, rgb, rgb + 1, rgb + 2);
  return { rgb, rgb + 3 };
}

Actor MakeActor(vtkDataObject* surface, const Color& color, bool edges = false)
{
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkPolyData> shown;
  shown->ShallowCopy(surface);
  mapper->SetInputData(shown);
  mapper->ScalarVisibilityOff();
  auto actor = Actor::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(color[0], color[1], color[2]);
  actor->GetProperty()->SetEdgeVisibility(edges);
  actor->GetProperty()->SetEdgeColor(0.45, 0.4, 0.35);
  actor->GetProperty()->SetLineWidth(0.5);
  return actor;
}

// Each partition in a colour of its own, moved away from the middle.
std::vector<Actor> PulledApart(vtkPartitionedDataSet* parts, const double* middle, double pull)
{
  std::vector<Actor> actors;
  for (unsigned int i = 0; i < parts->GetNumberOfPartitions(); ++i)
  {
    auto* const part = vtkPolyData::SafeDownCast(parts->GetPartitionAsDataObject(i));
    actors.push_back(MakeActor(part, ColorOf(i)));
    const double* const at = part->GetCenter();
    actors.back()->SetPosition(
      pull * (at[0] - middle[0]), pull * (at[1] - middle[1]), pull * (at[2] - middle[2]));
  }
  return actors;
}

// Writes FOLDER/NAME.png.
class Painter
{
public:
  explicit Painter(std::string folder)
    : Folder(std::move(folder))
  {
    this->Window->SetSize(200, 150);
    this->Window->SetMultiSamples(8);
  }
  template <class Props>
  void Paint(const std::string& name, const Props& props, double zoom = 1.5)
  {
    vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(1, 1, 1);
    for (const auto& prop : props)
    {
      renderer->AddViewProp(prop);
    }
    this->Window->AddRenderer(renderer);
    renderer->ResetCamera();
    renderer->GetActiveCamera()->Azimuth(20);
    renderer->GetActiveCamera()->Elevation(10);
    renderer->GetActiveCamera()->Zoom(zoom);
    renderer->ResetCameraClippingRange();
    for (const auto& prop : props)
    {
      if (auto* const stream = vtkKdStreamActor::SafeDownCast(prop))
      {
        stream->Refine(renderer, 60);
      }
    }
    vtkNew<vtkWindowToImageFilter> picture;
    picture->SetInput(this->Window);
    picture->ReadFrontBufferOff();
    picture->Update();
    // Reduces each channel to 64 shades, so that the page's files are small.
    auto* const shades =
      vtkUnsignedCharArray::SafeDownCast(picture->GetOutput()->GetPointData()->GetScalars());
    for (vtkIdType i = 0; i < shades->GetNumberOfValues(); ++i)
    {
      shades->SetValue(i, static_cast<unsigned char>(shades->GetValue(i) / 4 * 85 / 21));
    }
    vtkNew<vtkPNGWriter> writer;
    writer->SetCompressionLevel(9);
    writer->SetInputData(picture->GetOutput());
    writer->SetFileName((this->Folder + "/" + name + ".png").c_str());
    writer->Write();
    this->Window->RemoveRenderer(renderer);
  }

private:
  std::string Folder;
  vtkNew<vtkRenderWindow> Window;
};

void PaintPartitions(Painter& painter, vtkAlgorithmOutput* mesh, const double* middle)
{
  vtkNew<vtkKdTreePartition> kd;
  kd->SetInputConnection(mesh);
  kd->SetNumberOfPartitions(32);
  kd->Update();
  painter.Paint("vtkKdTreePartition", PulledApart(kd->GetOutput(), middle, 0.3), 1.2);
  vtkNew<vtkOctreePartition> octree;
  octree->SetInputConnection(mesh);
  octree->SetVerticesPerPartition(20000);
  octree->Update();
  painter.Paint("vtkOctreePartition", PulledApart(octree->GetOutput(), middle, 0.3), 1.2);
  vtkNew<vtkKMeansPartition> means;
  means->SetInputConnection(mesh);
  means->SetNumberOfPartitions(32);
  means->GeneratePartitionIdsOn();
  means->Update();
  painter.Paint("vtkKMeansPartition", PulledApart(means->GetOutput(), middle, 0.3), 1.2);

  // The less compact a partition is, the redder it is drawn.
  vtkNew<vtkPartitionMeasures> measures;
  measures->SetInputConnection(means->GetOutputPort(1));
  measures->Update();
  auto* const column =
    vtkDoubleArray::SafeDownCast(measures->GetOutput()->GetColumnByName("Compactness"));
  std::vector<Actor> actors = PulledApart(means->GetOutput(), middle, 0);
  for (vtkIdType i = 0; i < vtkIdType(actors.size()); ++i)
  {
    const double* const range = column->GetRange();
    const double good = (column->GetValue(i) - range[0]) / (range[1] - range[0]);
    actors[std::size_t(i)]->GetProperty()->SetColor(0.95, 0.3 + 0.6 * good, 0.25 + 0.5 * good);
  }
  painter.Paint("vtkPartitionMeasures", actors);
}

void PaintStore(Painter& painter, const std::string& store)
{
  vtkNew<vtkKdStoreReader> reader;
  reader->SetFileName(store.c_str());
  reader->SetOutputTypeToPolyData();
  std::vector<Actor> levels;
  for (const int depth : { 8, 10, 13 })
  {
    reader->SetContentToLevel();
    reader->SetLevelDepth(depth);
    reader->Update();
    levels.push_back(MakeActor(reader->GetOutputDataObject(0), stone, depth < 13));
    const double* const bounds = levels.back()->GetBounds();
    levels.back()->SetPosition(
      (depth - 10) * (depth > 10 ? 0.35 : 0.52) * (bounds[1] - bounds[0]), 0, 0);
  }
  painter.Paint("vtkKdStoreWriter", levels, 1.4);

  auto* const whole = vtkPolyData::SafeDownCast(reader->GetOutputDataObject(0));
  const double* const bounds = whole->GetBounds();
  std::vector<Actor> region{ MakeActor(whole, stone) };
  reader->SetContentToRegion();
  reader->SetRegionPoint(bounds[0], bounds[3], bounds[5]);
  reader->SetRings(2);
  reader->Update();
  region.push_back(MakeActor(reader->GetOutputDataObject(0), { 0.9, 0.5, 0.2 }));
  painter.Paint("vtkKdStoreReader", region);

  // Only what a camera needs that sees the right half.
  reader->SetContentToView();
  reader->SetCameraPosition(bounds[1], bounds[3], bounds[5] + 0.6 * (bounds[1] - bounds[0]));
  reader->SetCameraFocalPoint(bounds[1], 0.5 * (bounds[2] + bounds[3]), bounds[4]);
  reader->SetNumberOfTriangles(5500);
  reader->Update();
  painter.Paint("vtkKdStreamSource",
    std::vector<Actor>{ MakeActor(reader->GetOutputDataObject(0), stone, true) });

  vtkNew<vtkKdStreamActor> stream;
  stream->SetSource(store);
  stream->SetColorBy("resolution");
  painter.Paint("vtkKdStreamActor", std::vector<vtkProp*>{ stream }, 2.5);
}

void PaintTextures(Painter& painter, const std::string& store)
{
  std::vector<Actor> actors;
  vtkNew<vtkKdTextureReader> reader;
  reader->SetFileName(store.c_str());
  reader->UpdateInformation();
  for (vtkIdType p = 0; p < reader->GetNumberOfModelPartitions(); ++p)
  {
    reader->SetPartition(p);
    reader->Update();
    vtkNew<vtkImageData> picture;
    picture->DeepCopy(reader->GetPicture());
    vtkNew<vtkTexture> texture;
    texture->SetInputData(picture);
    texture->InterpolateOn();
    texture->SetWrap(vtkTexture::ClampToEdge);
    actors.push_back(MakeActor(reader->GetOutput(), { 1, 1, 1 }));
    actors.back()->SetTexture(texture);
  }
  painter.Paint("vtkKdTextureReader", actors, 1.1);
}

}

int main(int argc, char* argv[])
{
  if (argc != 4)
  {
    return 2;
  }
  Painter painter(argv[3]);
  vtkNew<vtkKdMeshReader> mesh;
  mesh->SetFileName(argv[1]);
  mesh->Update();
  painter.Paint("vtkKdMeshReader", std::vector<Actor>{ MakeActor(mesh->GetOutput(), stone) });
  double middle[3];
  mesh->GetOutput()->GetCenter(middle);
  PaintPartitions(painter, mesh->GetOutputPort(), middle);

  vtkNew<vtkKdClusterSimplification> level;
  level->SetInputConnection(mesh->GetOutputPort());
  level->SetTargetNumberOfTriangles(3000);
  level->Update();
  painter.Paint(
    "vtkKdClusterSimplification", std::vector<Actor>{ MakeActor(level->GetOutput(), stone, true) });
#ifdef HAS_POINT_CLOUD
  vtkNew<vtkPolyData> points;
  level->SetTargetNumberOfTriangles(20000);
  level->Update();
  points->SetPoints(level->GetOutput()->GetPoints());
  vtkNew<vtkPCLSurfaceReconstruction> surface;
  surface->SetInputData(points);
  surface->Update();
  painter.Paint("vtkPCLSurfaceReconstruction",
    std::vector<Actor>{ MakeActor(surface->GetOutput(), { 0.6, 0.75, 0.9 }) });
#endif

  const std::string store = std::string(argv[3]) + "/model.kds";
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputConnection(mesh->GetOutputPort());
  writer->SetFileName(store.c_str());
  writer->Write();
  PaintStore(painter, store);
  PaintTextures(painter, argv[2]);
  return 0;
}
