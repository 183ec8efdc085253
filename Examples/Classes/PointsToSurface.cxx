// SPDX-License-Identifier: BSD-3-Clause
// Makes a surface from the points of a mesh or a cloud, with PCL. Usage:
//   PointsToSurface POINTS OUT.ply
#include <vtkKdMeshReader.h>
#include <vtkNew.h>
#include <vtkPCLSurfaceReconstruction.h>
#include <vtkPLYWriter.h>
#include <vtkPolyData.h>

#include <iostream>

int main(int argc, char* argv[])
{
  if (argc != 3)
  {
    return 2;
  }
  vtkNew<vtkKdMeshReader> points;
  points->SetFileName(argv[1]);
  vtkNew<vtkPCLSurfaceReconstruction> surface;
  surface->SetInputConnection(points->GetOutputPort());
  surface->SetMethodToGreedy(); // connects the points; ToPoisson makes a closed surface near them
  vtkNew<vtkPLYWriter> writer;
  writer->SetInputConnection(surface->GetOutputPort());
  writer->SetFileName(argv[2]);
  writer->Write();
  std::cout << surface->GetOutput()->GetNumberOfPolys() << " triangles\n";
  return surface->GetOutput()->GetNumberOfPolys() > 0 ? 0 : 1;
}
