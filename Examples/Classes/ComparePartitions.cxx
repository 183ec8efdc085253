// SPDX-License-Identifier: BSD-3-Clause
// Cuts a mesh in three ways, and prints how large and how compact the partitions are. Usage:
//   ComparePartitions MESH
#include <vtkKMeansPartition.h>
#include <vtkKdMeshReader.h>
#include <vtkKdTreePartition.h>
#include <vtkNew.h>
#include <vtkOctreePartition.h>
#include <vtkPartitionMeasures.h>
#include <vtkTable.h>
#include <vtkVariant.h>

#include <iostream>

namespace
{

void Tell(const char* name, vtkMeshPartition* partition, vtkAlgorithmOutput* mesh)
{
  partition->SetInputConnection(mesh);
  partition->GeneratePartitionIdsOn(); // a point array, on port 1

  vtkNew<vtkPartitionMeasures> measures;
  measures->SetInputConnection(partition->GetOutputPort(1));
  measures->Update();
  vtkTable* const all = measures->GetOutput(1); // port 0 has a row for each partition
  std::cout << name;
  for (const char* column :
    { "Partitions", "VerticesMinimum", "VerticesMaximum", "CompactnessMean" })
  {
    std::cout << " " << all->GetValueByName(0, column).ToString();
  }
  std::cout << "\n";
}

}

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    return 2;
  }
  vtkNew<vtkKdMeshReader> mesh;
  mesh->SetFileName(argv[1]);
  vtkNew<vtkKdTreePartition> kd;
  kd->SetVerticesPerPartition(2000);
  Tell("k-d tree", kd, mesh->GetOutputPort());
  vtkNew<vtkOctreePartition> octree;
  octree->SetVerticesPerPartition(2000);
  Tell("octree", octree, mesh->GetOutputPort());
  vtkNew<vtkKMeansPartition> means;
  means->SetNumberOfPartitions(16);
  Tell("k-means", means, mesh->GetOutputPort());
  return 0;
}
