// SPDX-License-Identifier: BSD-3-Clause
// Opens what the command line names as a source of models: a server, a store, a folder of stores,
// or a mesh, of which it first makes a store.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"
#include "viewer/desktop/ViewOptions.h"

#include <functional>
#include <memory>
#include <string_view>

namespace kdstream
{

// Whether `source` names a server, and not a file.
bool NamesServer(const std::string& source);

// Blocks until the models are known. report, warn: as for BuildStore. A copy of warn is kept; it
// may be called later, and from any thread. Errors: those of ServerClient::Connect,
// LocalClient::Open and BuildStore; NotFound for something that is neither a file nor a URL.
Result<std::unique_ptr<ModelSource>> OpenSource(const ViewOptions& options,
  const std::function<bool(std::string_view progress)>& report,
  const std::function<void(std::string_view sentence)>& warn);

}
