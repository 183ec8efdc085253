// SPDX-License-Identifier: BSD-3-Clause
// Reads a store in as many pieces as a parallel program has ranks, with one ring of ghosts, and
// counts each piece's own triangles:
//   StoreGhosts STORE.kds PIECES
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkKdStoreReader.h>
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
  vtkNew<vtkKdStoreReader> reader;
  reader->SetFileName(argv[1]);
  reader->SetOutputTypeToPolyData();
  const int pieces = std::atoi(argv[2]);
  vtkIdType all = 0;
  for (int piece = 0; piece < pieces; ++piece)
  {
    if (reader->UpdatePiece(piece, pieces, 1) == 0)
    {
      return 1;
    }
    auto* const mesh = vtkPolyData::SafeDownCast(reader->GetOutputDataObject(0));
    vtkDataArray* const ghosts =
      mesh->GetCellData()->GetArray(vtkDataSetAttributes::GhostArrayName());
    vtkIdType own = 0;
    for (vtkIdType i = 0; i < mesh->GetNumberOfCells(); ++i)
    {
      own += !ghosts || ghosts->GetTuple1(i) == 0 ? 1 : 0;
    }
    std::cout << "piece " << piece << ": " << own << " of " << mesh->GetNumberOfCells() << "\n";
    all += own;
  }
  std::cout << all << " triangles\n";
  return all == reader->GetNumberOfModelTriangles() ? 0 : 1;
}
