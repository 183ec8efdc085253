// SPDX-License-Identifier: BSD-3-Clause
// The same surface cut by the k-d tree, the octree and k-means, side by side, as in the paper's
// Fig. 5. Each cell is drawn only once, because otherwise the driver would decide which of two
// coincident cells is visible.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"
#include "filters/adapter/Testing/WritePicture.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkMath.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

namespace
{

using namespace kdstream::testing;

void AddPartitions(vtkMeshPartition& filter, vtkRenderWindow& window, int column)
{
  filter.SetInputData(MakeSphere(60));
  filter.SetNumberOfPartitions(32);
  filter.Update();
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->SetViewport(column / 3.0, 0, (column + 1) / 3.0, 1);
  window.AddRenderer(renderer);
  const std::vector<vtkPolyData*> partitions = Partitions(filter);
  for (std::size_t p = 0; p < partitions.size(); ++p)
  {
    vtkNew<vtkPolyData> own;
    own->ShallowCopy(partitions[p]);
    own->RemoveGhostCells();
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(own);
    mapper->ScalarVisibilityOff();
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    double hsv[3] = { std::fmod(0.618 * double(p), 1.0), 0.6, 0.95 }, rgb[3];
    vtkMath::HSVToRGB(hsv, rgb);
    actor->GetProperty()->SetColor(rgb);
    renderer->AddActor(actor);
  }
  renderer->GetActiveCamera()->SetPosition(3, 2, 2);
  renderer->GetActiveCamera()->SetViewUp(0, 0, 1);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(1.4);
}

}

int main(int argc, char* argv[])
{
  vtkNew<vtkRenderWindow> window;
  window->SetSize(450, 150);
  AddPartitions(*vtkNew<vtkKdTreePartition>(), *window, 0);
  AddPartitions(*vtkNew<vtkOctreePartition>(), *window, 1);
  AddPartitions(*vtkNew<vtkKMeansPartition>(), *window, 2);
  return argc == 2 ? kdstream::testing::WritePicture(*window, argv[1]) : 2;
}
