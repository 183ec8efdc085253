// SPDX-License-Identifier: BSD-3-Clause
// Prints what is in a partition of a textured model in a store. Usage:
//   TexturedPartition STORE.kds PARTITION
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkKdTextureReader.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <cstdlib>
#include <iostream>

int main(int argc, char* argv[])
{
  if (argc != 3)
  {
    return 2;
  }
  vtkNew<vtkKdTextureReader> reader;
  reader->SetFileName(argv[1]);
  reader->SetPartition(std::atoi(argv[2]));
  reader->Update();
  if (reader->GetErrorCode() != vtkErrorCode::NoError)
  {
    return 1; // VTK has printed why
  }
  // To draw it: texture->SetInputConnection(reader->GetOutputPort(1)), actor->SetTexture(texture).
  const int* const size = reader->GetPicture()->GetDimensions();
  std::cout << reader->GetOutput()->GetNumberOfPolys() << " triangles, a picture of " << size[0]
            << " x " << size[1] << "\n";
  return 0;
}
