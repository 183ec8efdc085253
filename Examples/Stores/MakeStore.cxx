// SPDX-License-Identifier: BSD-3-Clause
// Makes a store from a pipeline's output: here from a sphere with its heights. Usage:
//   MakeStore STORE.kds
#include <vtkElevationFilter.h>
#include <vtkKdStoreWriter.h>
#include <vtkNew.h>
#include <vtkSphereSource.h>

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    return 2;
  }
  vtkNew<vtkSphereSource> sphere;
  sphere->SetThetaResolution(400);
  sphere->SetPhiResolution(300);
  vtkNew<vtkElevationFilter> heights;
  heights->SetInputConnection(sphere->GetOutputPort());
  heights->SetLowPoint(0, 0, -0.5);
  heights->SetHighPoint(0, 0, 0.5);

  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputConnection(heights->GetOutputPort());
  writer->SetFileName(argv[1]);
  writer->SetGridBits(0); // keep the coordinates exactly
  writer->SetVerticesPerPartition(1000);
  writer->SetTitle("A sphere");
  writer->SetUp(0, 0, 1);
  return writer->Write() == 1 ? 0 : 1;
}
