// SPDX-License-Identifier: BSD-3-Clause
// The certificate that a server shows, and its key: read from files, and read again while
// connections come. Internal to the server.
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
  // PEM files. From now on new connections have these; earlier ones keep theirs. Errors:
  // InputOutput where a file cannot be read; InvalidInput where it holds something else, or the key
  // of another certificate. Then all stays as it was.
  Status Load(const std::filesystem::path& certificate, const std::filesystem::path& key);

  // What was loaded last; null if nothing was.
  std::shared_ptr<ssl_ctx_st> Current() const;

private:
  mutable std::mutex Mutex;
  std::shared_ptr<ssl_ctx_st> Loaded;
};

}
