// SPDX-License-Identifier: BSD-3-Clause
// Writes a store as the files that a server would send, for hosts of plain files.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace kdstream
{

struct ExportOptions
{
  std::string model;           // the name for viewers; REQUIRES: IsModelId
  std::filesystem::path notes; // notes on the model (StoreNotes.h), if the file exists; empty: none
  std::filesystem::path page;  // the folder of the page, which is copied too; empty: no page
  // The address that the folder will have on the web, with a slash at its end; empty: not known.
  std::string address = {};
};

struct ExportReport
{
  std::uint64_t files = 0, bytes = 0; // only files that were written
};

// Writes every path of doc/protocol.md#get below `folder`, texts also compressed (".gz"), and
// beside the blobs the preview, "preview.glb" (PreviewGlb.h). If the folder has a list of models,
// the model is added to it, or replaced. The list is written last, so a host that serves the folder
// never lists a model that is not there. Notes are exported with the model; if the model no longer
// has notes, the old ones are removed. With the page, each model gets a page of its own
// (doc/protocol.md#pages) with a picture and a manifest, and m/index.html lists all models; oEmbed
// needs `address`. Also writes rules for caching, for nginx (kdstream.nginx.conf) and Apache
// (.htaccess). Reports the step "export". Errors: those of the store; InvalidInput for a malformed
// list or malformed notes; InputOutput; Cancelled. The files of a model (of one digest) appear all
// or not at all.
Result<ExportReport> ExportStore(const Store& store, const std::filesystem::path& folder,
  const ExportOptions& options, const Execution& execution = {});

}
