// SPDX-License-Identifier: BSD-3-Clause
// For tests: tokens with any header and claims, correctly signed. This is a second implementation
// of what Token.cxx writes, by other means, so that each checks the other.
#pragma once

#include "server/access/TokenKeys.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <string>
#include <vector>

namespace kdstream::forged
{

inline const std::string secret = "0123456789abcdef0123456789abcdef";
inline const std::string header = R"({"alg":"HS256","typ":"JWT"})";
inline const std::string claims =
  R"({"sub":"ann","exp":2000,"models":["dragon","vase"],"detail":"levels"})";

inline TokenKeys Keys()
{
  return { { { "", secret } }, {}, {} };
}

inline std::string Base64(const std::string& bytes)
{
  std::vector<unsigned char> out(4 * bytes.size() / 3 + 8);
  const int size = EVP_EncodeBlock(out.data(), reinterpret_cast<const unsigned char*>(bytes.data()),
    static_cast<int>(bytes.size()));
  std::string text(out.begin(), out.begin() + size);
  for (char& c : text)
  {
    c = c == '+' ? '-' : c == '/' ? '_' : c;
  }
  return text.substr(0, text.find('='));
}

inline std::string Hmac(
  const std::string& text, const std::string& key, const EVP_MD* digest = EVP_sha256())
{
  unsigned char out[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  HMAC(digest, key.data(), static_cast<int>(key.size()),
    reinterpret_cast<const unsigned char*>(text.data()), text.size(), out, &size);
  return std::string(out, out + size);
}

inline std::string Token(const std::string& head, const std::string& body,
  const std::string& key = secret, const EVP_MD* digest = EVP_sha256())
{
  const std::string text = Base64(head) + "." + Base64(body);
  return text + "." + Base64(Hmac(text, key, digest));
}

}
