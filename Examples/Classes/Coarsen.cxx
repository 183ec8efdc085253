// SPDX-License-Identifier: BSD-3-Clause
// Writes a coarser mesh, by edge collapse, and prints an estimate of its largest geometric error:
//   Coarsen MESH OUT.ply TRIANGLES
#include <vtkDataArray.h>
#include <vtkKdClusterSimplification.h>
#include <vtkKdMeshReader.h>
#include <vtkNew.h>
#include <vtkPLYWriter.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

#include <cstdlib>
#include <iostream>

int main(int argc, char* argv[])
{
  if (argc != 4)
  {
    return 2;
  }
  vtkNew<vtkKdMeshReader> mesh;
  mesh->SetFileName(argv[1]);
  vtkNew<vtkKdClusterSimplification> coarse;
  coarse->SetInputConnection(mesh->GetOutputPort());
  coarse->SetMakerToCollapse(); // or ToCluster, which is faster but less accurate
  coarse->SetTargetNumberOfTriangles(std::atoi(argv[3]));
  vtkNew<vtkPLYWriter> writer;
  writer->SetInputConnection(coarse->GetOutputPort());
  writer->SetFileName(argv[2]);
  writer->Write();
  vtkPolyData* const output = coarse->GetOutput();
  std::cout << output->GetNumberOfPolys() << " triangles; points are estimated to lie within "
            << output->GetPointData()->GetArray("Deviation")->GetRange()[1] << " of the surface\n";
  return output->GetNumberOfPolys() > 0 ? 0 : 1;
}
