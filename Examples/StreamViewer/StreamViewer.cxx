// SPDX-License-Identifier: BSD-3-Clause
// A viewer of models of any size, from a server or a store. It refines the model while the window
// is idle. Usage:
//   StreamViewer http://HOST:PORT|NAME.kds
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkKdStreamActor.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

int main(int argc, char* argv[])
{
  vtkNew<vtkKdStreamActor> actor;
  actor->SetSource(argc > 1 ? argv[1] : "http://127.0.0.1:8700");
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  vtkNew<vtkRenderWindow> window;
  window->AddRenderer(renderer);
  vtkNew<vtkRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(window);
  interactor->SetInteractorStyle(vtkNew<vtkInteractorStyleTrackballCamera>());
  window->Render();
  interactor->Start();
}
