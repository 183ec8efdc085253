// SPDX-License-Identifier: BSD-3-Clause
// A picture of two levels: with quadrics and sheets on the left, by the paper's method on the
// right.
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/WritePicture.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkKdClusterSimplification.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

int main(int argc, char* argv[])
{
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  for (const bool ours : { true, false })
  {
    vtkNew<vtkKdClusterSimplification> filter;
    filter->SetInputData(kdstream::testing::MakeSphere(60));
    filter->SetMakerToCluster();
    filter->SetDepth(8);
    filter->SetSheets(ours);
    filter->SetRepresentative(
      ours ? vtkKdClusterSimplification::Quadric : vtkKdClusterSimplification::Mean);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputConnection(filter->GetOutputPort());
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->SetInterpolationToFlat();
    actor->GetProperty()->SetColor(0.84, 0.81, 0.75);
    actor->SetPosition(ours ? -1.1 : 1.1, 0, 0);
    renderer->AddActor(actor);
  }
  vtkNew<vtkRenderWindow> window;
  window->SetSize(320, 160);
  window->AddRenderer(renderer);
  renderer->GetActiveCamera()->SetPosition(0, -3, 1);
  renderer->GetActiveCamera()->SetViewUp(0, 0, 1);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(2);
  return argc == 2 ? kdstream::testing::WritePicture(*window, argv[1]) : 2;
}
