// SPDX-License-Identifier: BSD-3-Clause
// Cuts a mesh into partitions of at most 2,000 vertices and draws each in a colour of its own:
//   PartitionPicture MESH.ply PICTURE.png
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCompositePolyDataMapper.h>
#include <vtkKdTreePartition.h>
#include <vtkLookupTable.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPNGWriter.h>
#include <vtkPartitionedDataSet.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <cmath>

int main(int argc, char* argv[])
{
  if (argc != 3)
  {
    return 2;
  }
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(argv[1]);

  vtkNew<vtkKdTreePartition> partition;
  partition->SetInputConnection(reader->GetOutputPort());
  partition->SetVerticesPerPartition(2000);
  partition->GeneratePartitionIdsOn();
  partition->Update();

  const unsigned int count = partition->GetOutput()->GetNumberOfPartitions();
  vtkNew<vtkLookupTable> colors;
  colors->SetNumberOfTableValues(count);
  for (unsigned int i = 0; i < count; ++i)
  {
    double hsv[3] = { std::fmod(0.618 * i, 1.0), 0.45, 0.95 }, rgb[3];
    vtkMath::HSVToRGB(hsv, rgb);
    colors->SetTableValue(i, rgb[0], rgb[1], rgb[2]);
  }

  vtkNew<vtkCompositePolyDataMapper> mapper;
  mapper->SetInputConnection(partition->GetOutputPort());
  mapper->SetScalarModeToUsePointFieldData();
  mapper->SelectColorArray("PartitionId");
  mapper->SetLookupTable(colors);
  mapper->SetScalarRange(0, count - 1);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);

  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(actor);
  renderer->SetBackground(1, 1, 1);
  renderer->ResetCamera();
  renderer->GetActiveCamera()->Zoom(1.5);
  vtkNew<vtkRenderWindow> window;
  window->SetSize(800, 600);
  window->AddRenderer(renderer);
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(picture->GetOutputPort());
  writer->SetFileName(argv[2]);
  writer->Write();
  return 0;
}
