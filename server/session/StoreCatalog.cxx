// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/StoreCatalog.h"

#include "server/protocol/ResourcePath.h"
#include "server/session/StoreModel.h"

#include <algorithm>
#include <system_error>
#include <utility>

namespace kdstream
{

// Calls the report function from one thread at a time. Models keep it alive.
class StoreCatalog::Reporter
{
public:
  explicit Reporter(Report report)
    : Function(std::move(report))
  {
  }
  void Tell(const std::filesystem::path& file, const std::string& what)
  {
    const std::lock_guard lock(this->Mutex);
    this->Function(file, what);
  }

private:
  std::mutex Mutex;
  Report Function;
};

namespace
{

std::string LeftOut(const std::string& why)
{
  return why + "; it is left out, the other stores are served";
}

// The stores of a folder, by name.
Result<std::vector<std::filesystem::path>> FindStores(const std::filesystem::path& folder)
{
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
  {
    if (entry->path().extension() == ".kds")
    {
      files.push_back(entry->path());
    }
  }
  if (error)
  {
    const bool missing = error == std::errc::no_such_file_or_directory;
    return Error{ missing ? ErrorCode::NotFound : ErrorCode::InputOutput, error.message() };
  }
  std::sort(files.begin(), files.end());
  return files;
}

}

StoreCatalog::StoreCatalog(std::filesystem::path folder, Report report)
  : Folder(std::move(folder))
  , Reports(std::make_shared<Reporter>(std::move(report)))
  , ById(std::make_shared<const ModelMap>())
{
}

StoreCatalog::~StoreCatalog() = default;

Status StoreCatalog::Reload()
{
  const auto files = FindStores(this->Folder);
  KDSTREAM_TRY(files);
  auto models = std::make_shared<ModelMap>();
  for (const auto& file : *files)
  {
    const auto id = file.stem().string();
    if (!IsModelId(id))
    {
      this->Reports->Tell(file, LeftOut("a model's name has " + std::string(modelIdRule)));
      continue;
    }
    auto model = OpenStoreModel(file, id,
      [reports = this->Reports, file](const std::string& what) { reports->Tell(file, what); });
    if (model)
    {
      models->emplace(id, std::move(*model));
    }
    else
    {
      this->Reports->Tell(file, LeftOut(model.GetError().message));
    }
  }
  const std::lock_guard lock(this->Mutex);
  this->ById = std::move(models);
  return {};
}

std::shared_ptr<const StoreCatalog::ModelMap> StoreCatalog::Current() const
{
  const std::lock_guard lock(this->Mutex);
  return this->ById;
}

std::vector<std::shared_ptr<const ServedModel>> StoreCatalog::Models() const
{
  std::vector<std::shared_ptr<const ServedModel>> models;
  for (const auto& entry : *this->Current())
  {
    models.push_back(entry.second);
  }
  return models;
}

std::shared_ptr<const ServedModel> StoreCatalog::Find(std::string_view id) const
{
  const auto models = this->Current();
  const auto found = models->find(id);
  return found == models->end() ? nullptr : found->second;
}

}
