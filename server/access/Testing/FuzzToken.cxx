// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to tokens and their keys. The first byte chooses what the rest is: a token as
// it is; claims, which are correctly signed, so that code after the signature check is reached; a
// header in front of such claims; a file of keys; or the fields of a request.
#include "server/access/Token.h"
#include "server/access/TokenGuard.h"
#include "server/access/TokenKeys.h"

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "server/access/Testing/ForgedToken.h"

using namespace kdstream;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  if (size == 0)
  {
    return 0;
  }
  static const TokenKeys keys = forged::Keys();
  const std::string text(reinterpret_cast<const char*>(data + 1), size - 1);
  switch (data[0] % 5)
  {
    case 0:
      if (ReadToken(text, keys, 1000)) // nobody knows the secret
      {
        std::abort();
      }
      break;
    case 1:
      (void)ReadToken(forged::Token(forged::header, text), keys, 1000).HasValue();
      break;
    case 2:
      (void)ReadToken(forged::Token(text, forged::claims), keys, 1000).HasValue();
      break;
    case 3:
      (void)ParseTokenKeys(text).HasValue();
      break;
    default:
      (void)LooksLikeToken(
        FindToken(text.substr(0, text.size() / 2), text.substr(text.size() / 2)));
  }
  return 0;
}
