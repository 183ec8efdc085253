// SPDX-License-Identifier: BSD-3-Clause
// Reads a mesh (PLY, STL, OBJ) and prints what is in it. An error message says what is wrong, and
// where. Usage:
//   MeshInfo MESH
#include <vtkDataArraySelection.h>
#include <vtkErrorCode.h>
#include <vtkKdMeshReader.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <iostream>

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    return 2;
  }
  vtkNew<vtkKdMeshReader> reader;
  reader->SetFileName(argv[1]);
  reader->Update();
  if (reader->GetErrorCode() != vtkErrorCode::NoError)
  {
    return 1; // VTK has printed why
  }
  std::cout << reader->GetOutput()->GetNumberOfPoints() << " points, "
            << reader->GetOutput()->GetNumberOfPolys() << " triangles";
  vtkDataArraySelection* const arrays = reader->GetPointDataArraySelection();
  for (int i = 0; i < arrays->GetNumberOfArrays(); ++i)
  {
    std::cout << ", " << arrays->GetArrayName(i);
  }
  std::cout << "\n";
  return 0;
}
