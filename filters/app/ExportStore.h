// SPDX-License-Identifier: BSD-3-Clause
// A store as the files that a server would send: for hosts of plain files.
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
  std::string model;           // IsModelId: what viewers call it
  std::filesystem::path notes; // notes on the model (StoreNotes.h), if the file exists; empty: none
  std::filesystem::path page;  // the folder of the page, which is copied too; empty: no page
  // Where the folder will be on the web, with a slash at its end; empty: it is not known.
  std::string address = {};
};

struct ExportReport
{
  std::uint64_t files = 0, bytes = 0; // that were written
};

// Writes every path of doc/protocol.md#get below `folder`, texts also compressed (".gz"), and the
// preview beside the blobs, "preview.glb" (PreviewGlb.h). If the
// folder has a list of models, the model is added to it, or replaced. The list is written last, so
// a host that serves the folder never lists a model that is not there. Notes are exported with the
// model; if the model has no notes any more, the old ones are removed. With the page each model
// gets one of its own (doc/protocol.md#pages), with a picture and a manifest, and all together
// m/index.html; oEmbed needs `address`. Also rules for caching, for nginx (kdstream.nginx.conf) and
// Apache (.htaccess). Reports the step "export". Errors: those of the store; InvalidInput for a
// malformed list or malformed notes; InputOutput; Cancelled. The files of a model (of one digest)
// appear all or not at all.
Result<ExportReport> ExportStore(const Store& store, const std::filesystem::path& folder,
  const ExportOptions& options, const Execution& execution = {});

}
