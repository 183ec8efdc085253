// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdStoreReader.h"

#include "filters/store/Store.h"

#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkKdStoreReader);

vtkKdStoreReader::~vtkKdStoreReader()
{
  this->SetFileName(nullptr);
}

int vtkKdStoreReader::CanReadFile(const char* name)
{
  return name && kdstream::Store::Open(name) ? 1 : 0;
}

std::shared_ptr<const kdstream::PieceSource> vtkKdStoreReader::OpenModel(
  const kdstream::Execution&, kdstream::Error& error)
{
  if (!this->FileName || !*this->FileName)
  {
    error = { kdstream::ErrorCode::NotFound, "no FileName is set" };
    return nullptr;
  }
  auto store = kdstream::Store::Open(this->FileName);
  if (!store)
  {
    error = store.GetError();
    return nullptr;
  }
  return *store;
}

void vtkKdStoreReader::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "FileName: " << (this->FileName ? this->FileName : "(none)") << "\n";
  os << indent << "MeasureOriginal: " << (this->MeasureOriginal ? "on" : "off") << "\n";
}
