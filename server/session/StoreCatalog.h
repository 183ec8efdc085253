// SPDX-License-Identifier: BSD-3-Clause
// The stores of a folder as a catalog: every NAME.kds is the model NAME.
#pragma once

#include "server/session/Catalog.h"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace kdstream
{

class StoreCatalog : public Catalog
{
public:
  // Told of what is wrong with a file: a store that is left out, or a damaged blob (once for each).
  // Called from any thread, one at a time.
  using Report = std::function<void(const std::filesystem::path& file, const std::string& what)>;

  StoreCatalog(std::filesystem::path folder, Report report);
  ~StoreCatalog() override;

  // Reads the folder (not the folders in it), at first and whenever it may have changed. Stores
  // that cannot be opened and names that are not model ids are reported and left out. Pointers to
  // earlier models stay valid. Errors: NotFound or InputOutput where the folder cannot be read: the
  // models stay as they were. Memory: 48 bytes a node of each tree.
  Status Reload();

  std::vector<std::shared_ptr<const ServedModel>> Models() const override;
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override;

private:
  class Reporter;
  using ModelMap = std::map<std::string, std::shared_ptr<const ServedModel>, std::less<>>;
  std::shared_ptr<const ModelMap> Current() const;

  std::filesystem::path Folder;
  std::shared_ptr<Reporter> Reports;
  mutable std::mutex Mutex;
  std::shared_ptr<const ModelMap> ById;
};

}
