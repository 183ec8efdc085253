// SPDX-License-Identifier: BSD-3-Clause
// A program that uses a static library of KdStream, and a VTK module that uses libkdstream. Each
// must call its own code. The program writes a store with the module and reads it with the library.
// Usage:
//   mixed STORE.kds
#include "filters/store/Store.h"

#include <kdstream/Version.h>
#include <vtkKdStoreWriter.h>
#include <vtkNew.h>
#include <vtkSphereSource.h>

#include <iostream>

static_assert(KDSTREAM_VERSION_NUMBER >= KDSTREAM_VERSION_CHECK(0, 1, 0));
static_assert(KDSTREAM_VERSION_NUMBER < KDSTREAM_VERSION_CHECK(KDSTREAM_VERSION_MAJOR + 1, 0, 0));

int main(int argc, char* argv[])
{
  if (argc != 2)
  {
    return 2;
  }
  vtkNew<vtkSphereSource> sphere;
  vtkNew<vtkKdStoreWriter> writer;
  writer->SetInputConnection(sphere->GetOutputPort());
  writer->SetFileName(argv[1]);
  if (writer->Write() != 1)
  {
    return 1;
  }
  const auto store = kdstream::Store::Open(argv[1]);
  if (!store)
  {
    std::cerr << store.GetError().message << '\n';
    return 1;
  }
  return 0;
}
