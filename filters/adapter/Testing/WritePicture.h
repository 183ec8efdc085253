// SPDX-License-Identifier: BSD-3-Clause
// How the picture tests of VTK modules end.
#pragma once

#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

namespace kdstream::testing
{

// Draws the window and writes what it shows; the program's exit status.
inline int WritePicture(vtkRenderWindow& window, const char* file)
{
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(&window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(file);
  writer->Write();
  return writer->GetErrorCode() == 0 ? 0 : 1;
}

}
