// SPDX-License-Identifier: BSD-3-Clause
#include "vtkKdStreamSource.h"

#include "filters/adapter/RangedSetters.h"
#include "viewer/sources/RemoteModel.h"

#include <vtkObjectFactory.h>

#include <utility>

vtkStandardNewMacro(vtkKdStreamSource);

KDSTREAM_SET_IN_RANGE(vtkKdStreamSource, Timeout, int, 1, 3600)

vtkKdStreamSource::~vtkKdStreamSource() = default;

kdstream::ServerAddress vtkKdStreamSource::Address() const
{
  return { this->Url, this->ModelId, this->Token, this->CertificateAuthorities, this->CacheFolder,
    this->CacheSize, std::chrono::seconds(this->Timeout) };
}

void vtkKdStreamSource::CloseModel()
{
  this->Connected.reset();
}

std::shared_ptr<const kdstream::PieceSource> vtkKdStreamSource::OpenModel(
  const kdstream::Execution& execution, kdstream::Error& error)
{
  kdstream::ServerAddress address = this->Address();
  if (this->Connected && *this->ConnectedTo == address)
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
  const auto model = kdstream::RemoteModel::Open(address, execution);
  if (!model)
  {
    error = model.GetError();
    return nullptr;
  }
  this->Connected = *model;
  this->ConnectedTo = std::make_shared<kdstream::ServerAddress>(std::move(address));
  return this->Connected;
}

void vtkKdStreamSource::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Url: " << this->Url << "\n";
  for (const std::string& line : kdstream::LinesOf(this->Address()))
  {
    os << indent << line << "\n";
  }
  os << indent << "BoundsOfPartitions: " << (this->BoundsOfPartitions ? "on" : "off") << "\n";
}
