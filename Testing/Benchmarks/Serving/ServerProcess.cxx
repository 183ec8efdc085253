// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/Serving/ServerProcess.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <numeric>
#include <sstream>

namespace kdstream::benchmarks
{

ServerProcess::ServerProcess(const std::vector<std::string>& command,
  const std::filesystem::path& log, std::optional<rlim_t> descriptors)
{
  std::vector<char*> arguments;
  for (const std::string& word : command)
  {
    arguments.push_back(const_cast<char*>(word.c_str()));
  }
  arguments.push_back(nullptr);
  std::array<int, 2> out{ -1, -1 };
  if (::pipe2(out.data(), O_CLOEXEC) != 0)
  {
    std::cerr << "benchmark: error: no pipe\n";
    std::exit(1);
  }
  this->Id = ::fork();
  if (this->Id == 0)
  {
    const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    ::dup2(out[1], STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
    if (descriptors)
    {
      const rlimit limit{ *descriptors, *descriptors };
      ::setrlimit(RLIMIT_NOFILE, &limit);
    }
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(out[1]);
  this->Out = out[0];
}

ServerProcess::~ServerProcess()
{
  if (this->Id > 0)
  {
    (void)this->End(); // not killed at once, because nginx would leave its workers
  }
  ::close(this->Out);
}

std::uint16_t ServerProcess::ReadPort() const
{
  std::string line;
  for (char c = 0; ::read(this->Out, &c, 1) == 1 && c != '\n';)
  {
    line += c;
  }
  const auto colon = line.rfind(':');
  if (line.rfind("listening on ", 0) != 0 || colon == std::string::npos)
  {
    std::cerr << "benchmark: error: the server did not start\n";
    std::exit(1);
  }
  return static_cast<std::uint16_t>(std::atoi(line.c_str() + colon + 1));
}

double ServerProcess::ResidentMebibytes() const
{
  std::ifstream statm("/proc/" + std::to_string(this->Id) + "/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

namespace
{

// The processor time of a process and its threads, from /proc/ID/stat: fields 14 and 15 of proc(5),
// in ticks.
double SecondsOf(const std::string& id)
{
  std::ifstream file("/proc/" + id + "/stat");
  const std::string text{ std::istreambuf_iterator<char>(file), {} };
  const auto name = text.rfind(')'); // the name may contain blanks
  std::istringstream fields(name == std::string::npos ? "" : text.substr(name + 2));
  std::string field;
  for (int skipped = 3; skipped < 14; ++skipped)
  {
    fields >> field;
  }
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

}

double ServerProcess::ProcessorSeconds() const
{
  const auto id = std::to_string(this->Id);
  std::ifstream children("/proc/" + id + "/task/" + id + "/children");
  return std::accumulate(std::istream_iterator<std::string>(children),
    std::istream_iterator<std::string>(), SecondsOf(id),
    [](double sum, const std::string& child) { return sum + SecondsOf(child); });
}

std::size_t ServerProcess::Descriptors() const
{
  std::error_code error;
  const std::filesystem::directory_iterator files(
    "/proc/" + std::to_string(this->Id) + "/fd", error);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

bool ServerProcess::IsAlive() const
{
  siginfo_t ended{};
  return this->Id > 0 &&
         ::waitid(P_PID, static_cast<id_t>(this->Id), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0;
}

bool ServerProcess::End()
{
  int status = 0;
  ::kill(this->Id, SIGTERM);
  const bool ended = ::waitpid(this->Id, &status, 0) == this->Id;
  this->Id = -1;
  return ended && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string Get(std::uint16_t port, const std::string& target)
{
  namespace http = boost::beast::http;
  boost::asio::io_context context;
  boost::asio::ip::tcp::socket socket(context);
  boost::system::error_code error;
  socket.connect({ boost::asio::ip::address_v4::loopback(), port }, error);
  http::request<http::string_body> request(http::verb::get, target, 11);
  request.set(http::field::host, "127.0.0.1");
  error ? 0 : http::write(socket, request, error);
  boost::beast::flat_buffer buffer;
  http::response<http::string_body> response;
  error ? 0 : http::read(socket, buffer, response, error);
  return !error && response.result() == http::status::ok ? response.body() : "";
}

}
