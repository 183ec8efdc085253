// SPDX-License-Identifier: BSD-3-Clause
// Draws a model from a server as finely as a camera needs it, and fetches nothing else. Usage:
//   StreamPicture http://HOST:PORT PICTURE.png
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkKdStreamSource.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

int main(int argc, char* argv[])
{
  if (argc != 3)
  {
    return 2;
  }
  vtkNew<vtkKdStreamSource> source;
  source->SetUrl(argv[1]);
  source->SetOutputTypeToPolyData();
  source->SetContentToLevel(); // the preview first, to place the camera
  if (source->UpdatePiece(0, 1, 0) == 0)
  {
    return 1;
  }
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(source->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.9, 0.6, 0.3);
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  renderer->SetBackground(1, 1, 1);
  renderer->ResetCamera();
  vtkNew<vtkRenderWindow> window;
  window->SetSize(800, 600);
  window->AddRenderer(renderer);

  vtkCamera* const camera = renderer->GetActiveCamera();
  camera->Azimuth(30);
  camera->Elevation(20);
  source->SetContentToView();
  source->SetCameraPosition(camera->GetPosition());
  source->SetCameraFocalPoint(camera->GetFocalPoint());
  source->SetCameraViewUp(camera->GetViewUp());
  source->SetCameraViewAngle(camera->GetViewAngle());
  source->SetPictureSize(800, 600);

  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(argv[2]);
  writer->Write();
  return 0;
}
