// SPDX-License-Identifier: BSD-3-Clause
// A picture of the partitions, moved apart.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"
#include "filters/adapter/Testing/WritePicture.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

int main(int argc, char* argv[])
{
  using namespace kdstream::testing;
  vtkNew<vtkKdTreePartition> filter;
  filter->SetInputData(MakeSphere(60));
  filter->SetNumberOfPartitions(32);
  filter->GeneratePartitionIdsOn();
  filter->Update();

  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  for (vtkPolyData* partition : Partitions(*filter))
  {
    const vtkIdType number = Value(partition->GetPointData(), "PartitionId", 0);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(partition);
    mapper->ScalarVisibilityOff();
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    double hsv[3] = { std::fmod(0.618 * double(number), 1.0), 0.6, 0.95 }, rgb[3];
    vtkMath::HSVToRGB(hsv, rgb);
    actor->GetProperty()->SetColor(rgb);
    const double* const center = partition->GetCenter();
    actor->SetPosition(0.25 * center[0], 0.25 * center[1], 0.25 * center[2]);
    renderer->AddActor(actor);
  }
  vtkNew<vtkRenderWindow> window;
  window->SetSize(200, 200);
  window->AddRenderer(renderer);
  renderer->GetActiveCamera()->SetPosition(3, 2, 2);
  renderer->GetActiveCamera()->SetViewUp(0, 0, 1);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(1.4);
  return argc == 2 ? kdstream::testing::WritePicture(*window, argv[1]) : 2;
}
