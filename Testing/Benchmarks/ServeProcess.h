// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve as a process of its own, for as long as the object lives.
#pragma once

#include <cstdint>
#include <filesystem>
#include <sys/types.h>

namespace kdstream::benchmarks
{

class ServeProcess
{
public:
  // Serves the stores of a folder on any free port of 127.0.0.1. A failure ends the benchmark with
  // a message.
  ServeProcess(const std::filesystem::path& programs, const std::filesystem::path& stores);
  ~ServeProcess(); // SIGTERM, and waits
  ServeProcess(const ServeProcess&) = delete;
  ServeProcess& operator=(const ServeProcess&) = delete;

  std::uint16_t Port() const { return this->PortNumber; }

private:
  pid_t Child = -1;
  std::uint16_t PortNumber = 0;
};

}
