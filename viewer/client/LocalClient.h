// SPDX-License-Identifier: BSD-3-Clause
// Stores on this machine as a session's source: reads from the file what a server would send, on a
// thread of its own. Step "receive" of the pipeline picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

class ServedModel;

class LocalClient final : public ModelSource
{
public:
  // Models by id. notes: the files of notes, by the model's id, for models that have notes.
  explicit LocalClient(std::vector<std::shared_ptr<const ServedModel>> models,
    std::map<std::string, std::filesystem::path> notes = {});
  // Opens a store as a model with the file's name, without extension (ModelIdLike); or all stores
  // of a folder. Errors: those of Store::Open and of StoreCatalog::Reload; NotFound for a folder
  // without a readable store, with the error of the first store. held: an object that must live as
  // long as the path is used.
  static Result<std::unique_ptr<LocalClient>> Open(
    const std::filesystem::path& storeOrFolder, std::shared_ptr<const void> held = nullptr);
  // Ends the thread.
  ~LocalClient() override;

  const std::vector<ModelSummary>& Models() const override { return this->ModelList; }
  void Send(const SessionRequest& request) override;
  void AskForNotes(const std::string& model) override;
  std::vector<ClientEvent> Take() override;
  bool Wait(std::chrono::milliseconds atMost) override;

private:
  class Reader;

  std::shared_ptr<const void> Held; // outlives Kept
  std::vector<ModelSummary> ModelList;
  std::unique_ptr<Reader> Kept;
};

}
