// SPDX-License-Identifier: BSD-3-Clause
// Draws a simplified sphere where there is no screen:
//   LevelPicture PICTURE.png [auto|egl|osmesa|x11]
#include <vtkActor.h>
#include <vtkKdClusterSimplification.h>
#include <vtkKdOffscreenRendering.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSphereSource.h>
#include <vtkWindowToImageFilter.h>

#include <string>

int main(int argc, char* argv[])
{
  if (argc < 2)
  {
    return 2;
  }
  vtkNew<vtkSphereSource> sphere;
  sphere->SetThetaResolution(100);
  sphere->SetPhiResolution(100);
  vtkNew<vtkKdClusterSimplification> level;
  level->SetInputConnection(sphere->GetOutputPort());
  level->SetTargetNumberOfTriangles(300);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(level->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetInterpolationToFlat();
  actor->GetProperty()->EdgeVisibilityOn();
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);

  vtkNew<vtkKdOffscreenRendering> offscreen;
  offscreen->SetBackendFromString(argc > 2 ? argv[2] : "auto");
  const auto window = offscreen->MakeWindow(300, 300);
  if (!window)
  {
    return 1; // VTK has printed why
  }
  window->AddRenderer(renderer);
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(argv[1]);
  writer->Write();
  return writer->GetErrorCode() == 0 ? 0 : 1;
}
