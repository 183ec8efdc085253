// SPDX-License-Identifier: BSD-3-Clause
// A server's certificate and its key: loaded from files, and loaded again while the server runs.
// Internal to the server.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <memory>
#include <mutex>

struct ssl_ctx_st;

namespace kdstream
{

// All functions may be called from any thread.
class TlsCertificate
{
public:
  // Loads PEM files. From now on new connections use these; earlier connections keep the
  // certificate that they have. Errors: InputOutput if a file cannot be read; InvalidInput if it
  // holds something else, or if the key belongs to another certificate. After an error nothing
  // changes.
  Status Load(const std::filesystem::path& certificate, const std::filesystem::path& key);

  // The certificate that was loaded last; null if there is none.
  std::shared_ptr<ssl_ctx_st> Current() const;

private:
  mutable std::mutex Mutex;
  std::shared_ptr<ssl_ctx_st> Loaded;
};

}
