// SPDX-License-Identifier: BSD-3-Clause
#include "filters/meshio/OutputFile.h"

#include <cassert>
#include <utility>

namespace kdstream
{

Status OutputFile::Open(const std::filesystem::path& file, const Execution& execution)
{
  assert(!this->File);
  this->Runs = execution;
  NewFile::RemoveLeftovers(file);
  Result<NewFile> made = NewFile::Create(file);
  if (!made)
  {
    this->FirstError = made.GetError();
    return this->FirstError;
  }
  this->File.emplace(std::move(*made));
  return {};
}

void OutputFile::Flush()
{
  if (this->FirstError)
  {
    this->FirstError = this->Runs.Report("write", 0);
  }
  if (this->FirstError)
  {
    this->FirstError = this->File->Write(this->Buffer);
  }
  this->Buffer.clear();
}

Status OutputFile::Finish()
{
  assert(this->File);
  this->Flush();
  KDSTREAM_TRY(this->FirstError);
  return this->File->Finish();
}

}
