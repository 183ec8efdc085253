// SPDX-License-Identifier: BSD-3-Clause
// A server's certificate and its key: read from files, and read again while the server runs.
// Internal to the server.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <memory>
#include <mutex>

struct ssl_ctx_st;

namespace kdstream
{

// Functions: from any thread.
class TlsCertificate
{
public:
  // Loads PEM files. From now on new connections use these; earlier ones keep theirs. Errors:
  // InputOutput if a file cannot be read; InvalidInput if it holds something else, or the key of
  // another certificate. After an error nothing changes.
  Status Load(const std::filesystem::path& certificate, const std::filesystem::path& key);

  // The certificate that was loaded last; null if there is none.
  std::shared_ptr<ssl_ctx_st> Current() const;

private:
  mutable std::mutex Mutex;
  std::shared_ptr<ssl_ctx_st> Loaded;
};

}
