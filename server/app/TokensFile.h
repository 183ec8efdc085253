// SPDX-License-Identifier: BSD-3-Clause
// The file of --tokens. Its keys guard a server; it is read again whenever it changes.
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

  // Whether anybody besides its owner and group may read the file, and so could sign tokens.
  bool IsForAll() const { return (this->Seen[0] & 07) != 0; }

  // Reads the file again if it was replaced or written to since the last time, or if it could not
  // be read for a temporary reason, such as a lack of descriptors. After an error the old keys stay
  // valid. Errors: those of ReadTokenKeys, reported once for each change.
  Status Look();
  // Reads the file even if it has not changed.
  Status Reload();

private:
  // Mode, device, inode, size, and the times of the last write and the last change (ns).
  using Stamp = std::array<std::uint64_t, 6>;
  static Stamp StampOf(const std::filesystem::path& file);

  TokensFile(std::filesystem::path file, Stamp seen, TokenKeys keys);

  std::filesystem::path File;
  Stamp Seen{};
  bool Again = false;   // the last reading failed, but may succeed later
  std::string Reported; // the error of the last reading
  std::shared_ptr<TokenGuard> Keeper;
};

}
