// SPDX-License-Identifier: BSD-3-Clause
// Runs a server as a process of its own and observes it from outside, for benchmarks of servers.
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
  // descriptors: its limit; without a number, this process's limit applies.
  ServerProcess(const std::vector<std::string>& command, const std::filesystem::path& log,
    std::optional<rlim_t> descriptors = {});
  // Sends the server the signal to end, and waits for it.
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  // Waits for the line in which kdstream-serve gives its address, and returns the port. If the
  // server did not start, ends the benchmark.
  std::uint16_t ReadPort() const;

  double ResidentMebibytes() const; // now
  double ProcessorSeconds() const;  // so far, including its children's
  std::size_t Descriptors() const;  // open ones
  bool IsAlive() const;
  // Sends the server the signal to end, and waits for it. Returns whether it ended without an
  // error.
  bool End();

private:
  pid_t Id = -1;
  int Out = -1;
};

// The answer of a server on this machine to a GET, if its status is 200; else "".
std::string Get(std::uint16_t port, const std::string& target);

}
