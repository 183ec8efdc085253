// SPDX-License-Identifier: BSD-3-Clause
// Draws a sphere where there is no screen:
//   SpherePicture PICTURE.png [auto|egl|osmesa|x11]
#include <vtkActor.h>
#include <vtkKdOffscreenRendering.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSphereSource.h>
#include <vtkWindowToImageFilter.h>

int main(int argc, char* argv[])
{
  if (argc < 2)
  {
    return 2;
  }
  vtkNew<vtkSphereSource> sphere;
  sphere->SetThetaResolution(24);
  sphere->SetPhiResolution(24);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(sphere->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->EdgeVisibilityOn();
  actor->GetProperty()->SetColor(0.9, 0.6, 0.3);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  renderer->SetBackground(1, 1, 1);

  vtkNew<vtkKdOffscreenRendering> offscreen;
  offscreen->SetBackendFromString(argc > 2 ? argv[2] : "auto");
  const auto window = offscreen->MakeWindow(300, 300);
  if (!window)
  {
    return 1; // VTK has printed why
  }
  window->AddRenderer(renderer);
  renderer->ResetCamera();
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(argv[1]);
  writer->Write();
  return writer->GetErrorCode() == 0 ? 0 : 1;
}
