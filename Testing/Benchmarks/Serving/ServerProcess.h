// SPDX-License-Identifier: BSD-3-Clause
// A server as a process of its own, looked at from outside: what benchmarks of servers share.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream::benchmarks
{

class ServerProcess
{
public:
  // command: the program's path and its arguments. Its errors are appended to the file `log`.
  // descriptors: its limit; without a number the same as this process's.
  ServerProcess(const std::vector<std::string>& command, const std::filesystem::path& log,
    std::optional<rlim_t> descriptors = {});
  // Signals it to end, and waits.
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  // Waits for kdstream-serve's line; the port in it. It did not start: ends the benchmark.
  std::uint16_t ReadPort() const;

  double ResidentMebibytes() const; // now
  double ProcessorSeconds() const;  // so far, with those of its children
  std::size_t Descriptors() const;  // that are open
  bool IsAlive() const;
  // Signals it to end, and waits. Returns whether it ended without an error.
  bool End();

private:
  pid_t Id = -1;
  int Out = -1;
};

// What a server of this machine answers to GET, once it is 200; else "".
std::string Get(std::uint16_t port, const std::string& target);

}
