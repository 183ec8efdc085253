// SPDX-License-Identifier: BSD-3-Clause
// What is fetched from a server, and its answer, whoever fetches it.
#pragma once

#include <cstddef>
#include <string>

namespace kdstream
{

struct HttpFetch
{
  std::string target;        // a path
  std::size_t mostBytes = 0; // of the answer's body
};

struct HttpReply
{
  unsigned status = 0;
  std::string body;
};

}
