// SPDX-License-Identifier: BSD-3-Clause
// Draws a model as it arrives: the preview, and then everything that the camera needs.
//   StreamPictures http://HOST:PORT|NAME.kds PREVIEW.png WHOLE.png
#include <vtkCamera.h>
#include <vtkKdStreamActor.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <iostream>

namespace
{

void Write(vtkRenderWindow* window, const char* file)
{
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(file);
  writer->Write();
}

}

int main(int argc, char* argv[])
{
  if (argc != 4)
  {
    return 2;
  }
  vtkNew<vtkKdStreamActor> actor;
  actor->SetSource(argv[1]);
  if (!actor->Open())
  {
    return 1; // VTK has reported why
  }
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 1, 1);
  renderer->AddActor(actor);
  vtkNew<vtkRenderWindow> window;
  window->SetSize(800, 600);
  window->AddRenderer(renderer);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Azimuth(30);
  renderer->GetActiveCamera()->Zoom(1.5);
  actor->SetSecondsPerFrame(0);
  Write(window, argv[2]);
  std::cout << actor->GetNumberOfDrawnTriangles() << " triangles\n";
  const bool whole = actor->Refine(renderer, 60);
  Write(window, argv[3]);
  std::cout << actor->GetNumberOfDrawnTriangles() << " triangles of "
            << actor->GetNumberOfReceivedBytes() << " bytes\n";
  return whole ? 0 : 1;
}
