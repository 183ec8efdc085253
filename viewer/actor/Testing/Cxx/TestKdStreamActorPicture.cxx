// SPDX-License-Identifier: BSD-3-Clause
// A streamed model between other actors: seen from the side, moved, and as fine as the camera
// needs.
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/WritePicture.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkKdStoreWriter.h>
#include <vtkKdStreamActor.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <string>

int main(int argc, char* argv[])
{
  using namespace kdstream::testing;
  if (argc != 2)
  {
    return 2;
  }
  const std::string store = std::string(argv[1]) + ".kds";
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputData(MakeSphere(150));
  writer->SetFileName(store.c_str());
  writer->Write();

  vtkNew<vtkKdStreamActor> actor;
  actor->SetSource(store);
  actor->SetColorBy("resolution");
  actor->RotateX(40);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(MakeSphere(20));
  mapper->ScalarVisibilityOff();
  vtkNew<vtkActor> beside;
  beside->SetMapper(mapper);
  beside->SetPosition(1.5, 0, 0.5);
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->AddActor(actor);
  renderer->AddActor(beside);
  vtkNew<vtkRenderWindow> window;
  window->SetSize(200, 200);
  window->AddRenderer(renderer);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Azimuth(30);
  renderer->GetActiveCamera()->Zoom(1.6);
  if (!actor->Refine(renderer, 60))
  {
    return 1;
  }
  return WritePicture(*window, argv[1]);
}
