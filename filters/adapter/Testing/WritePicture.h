// SPDX-License-Identifier: BSD-3-Clause
// Shared by the picture tests of VTK modules.
#pragma once

#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkRenderWindow.h>
#include <vtkWindowToImageFilter.h>

namespace kdstream::testing
{

// Draws the window and writes its content to a file. Returns the exit status for the program.
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
