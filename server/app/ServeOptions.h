// SPDX-License-Identifier: BSD-3-Clause
// The command line of kdstream-serve (doc/cli.md#kdstream-serve).
#pragma once

#include "filters/program/Program.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace kdstream
{

struct ServeOptions
{
  std::string folder, web, accessLog, auditLog, tokens, quotaFile;
  SiteDescription site;
  QuotaLimits quotas;
  std::uint64_t slowest = 16384;
  std::uint64_t cacheBytes = BlobCache::defaultBytes;
  std::chrono::seconds::rep grace = StoreCatalog::defaultGrace.count();
  HttpServerOptions server;
};

void AddServeOptions(CLI::App& app, ServeOptions& line);

}
