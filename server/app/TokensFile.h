// SPDX-License-Identifier: BSD-3-Clause
// The file of --tokens: its keys guard a server, and are read again whenever it changes.
#pragma once

#include "filters/core/Result.h"
#include "server/access/TokenGuard.h"

#include <sys/types.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace kdstream
{

class TokensFile
{
public:
  // Errors: those of ReadTokenKeys.
  static Result<TokensFile> Open(std::filesystem::path file);

  std::shared_ptr<const TokenGuard> Guard() const { return this->Keeper; }

  // Whether others than its owner and group may read the file, and so sign tokens.
  bool IsForAll() const { return (this->Seen[0] & 07) != 0; }

  // Reads the file again if it was replaced or written to since the last time, or if it could not
  // be read for a temporary reason, such as a lack of descriptors. Errors: those of ReadTokenKeys,
  // once for each change; the old keys stay valid then.
  Status Look();
  // Reads it in any case.
  Status Reload();

private:
  // Mode, device, file, size, and when it was written and changed (ns).
  using Stamp = std::array<std::uint64_t, 6>;
  static Stamp StampOf(const std::filesystem::path& file);

  TokensFile(std::filesystem::path file, Stamp seen, TokenKeys keys);

  std::filesystem::path File;
  Stamp Seen{};
  bool Again = false;   // what failed may succeed
  std::string Reported; // the error of the last reading
  std::shared_ptr<TokenGuard> Keeper;
};

}
