// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdStreamSource.h"

#include "filters/adapter/RangedSetters.h"
#include "viewer/sources/RemoteModel.h"

#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkKdStreamSource);

KDSTREAM_SET_IN_RANGE(vtkKdStreamSource, Timeout, int, 1, 3600)

vtkKdStreamSource::~vtkKdStreamSource() = default;

// All that makes another connection.
std::string vtkKdStreamSource::Address() const
{
  std::string address;
  for (const std::string& part :
    { this->Url, this->ModelId, this->Token, this->CertificateAuthorities, this->CacheFolder,
      std::to_string(this->CacheSize), std::to_string(this->Timeout) })
  {
    address += part + '\n';
  }
  return address;
}

void vtkKdStreamSource::CloseModel()
{
  this->Connected.reset();
}

std::shared_ptr<const kdstream::PieceSource> vtkKdStreamSource::OpenModel(
  const kdstream::Execution& execution, kdstream::Error& error)
{
  const std::string address = this->Address();
  if (this->Connected && this->ConnectedTo == address)
  {
    const auto isPresent = this->Connected->IsPresent(execution);
    if (!isPresent)
    {
      error = isPresent.GetError();
      return nullptr;
    }
    if (*isPresent)
    {
      return this->Connected;
    }
  }
  this->Connected.reset();
  if (this->Url.empty())
  {
    error = { kdstream::ErrorCode::NotFound, "no Url is set" };
    return nullptr;
  }
  const auto model = kdstream::RemoteModel::Open(
    { this->Url, this->ModelId, this->Token, this->CertificateAuthorities, this->CacheFolder,
      this->CacheSize, std::chrono::seconds(this->Timeout) },
    execution);
  if (!model)
  {
    error = model.GetError();
    return nullptr;
  }
  this->Connected = *model;
  this->ConnectedTo = address;
  return this->Connected;
}

void vtkKdStreamSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Url: " << this->Url << "\n";
  os << indent << "ModelId: " << this->ModelId << "\n";
  os << indent << "Token: " << (this->Token.empty() ? "(none)" : "(set)") << "\n";
  os << indent << "CertificateAuthorities: " << this->CertificateAuthorities << "\n";
  os << indent << "CacheFolder: " << this->CacheFolder << "\n";
  os << indent << "CacheSize: " << this->CacheSize << "\n";
  os << indent << "Timeout: " << this->Timeout << "\n";
  os << indent << "BoundsOfPartitions: " << (this->BoundsOfPartitions ? "on" : "off") << "\n";
}
