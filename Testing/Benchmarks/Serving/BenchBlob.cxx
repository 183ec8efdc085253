// SPDX-License-Identifier: BSD-3-Clause
// Requests one partition by GET repeatedly: requests a second of kdstream-serve compared with
// nginx, which has the same bytes as a file (kdstream-store export). Both have two workers, keep
// connections open, write no log and speak plain HTTP. wrk measures them in turn. The median of the
// ratios of consecutive runs counts, so that other work on the machine matters less. Usage:
//   BenchBlob PROGRAMS STORE FOLDER [ROUNDS [SECONDS]]
// PROGRAMS: the folder of kdstream-serve and kdstream-store. STORE: NAME.kds, the only store in its
// folder. FOLDER: for exported files and logs. Ends with an error if the limit is missed.
#include "Testing/Benchmarks/MeasuredRun.h"
#include "Testing/Benchmarks/Serving/ServerProcess.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/Store.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <sstream>
#include <thread>

namespace
{

using namespace kdstream;
using namespace kdstream::benchmarks;
using boost::asio::ip::tcp;
using std::filesystem::path;

constexpr double leastRatio = 0.8; // of nginx's requests a second
constexpr std::uint64_t leastBytes = 6000, mostBytes = 16000;
constexpr const char* workers = "2";
constexpr const char* connections = "32";

[[noreturn]] void Fail(const std::string& what)
{
  std::cerr << "BenchBlob: error: " << what << "\n";
  std::exit(1);
}

std::string ReadWhole(const path& file)
{
  std::ifstream in(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(in), {} };
}

std::uint16_t FreePort()
{
  boost::asio::io_context context;
  return tcp::acceptor(context, { boost::asio::ip::address_v4::loopback(), 0 })
    .local_endpoint()
    .port();
}

// nginx configured as in Debian, but without two things that kdstream-serve lacks here, too: a log,
// and a limit of requests for each connection. cache: further lines.
std::string NginxConfiguration(const path& folder, std::uint16_t port, const std::string& more)
{
  std::ostringstream text;
  text << (::geteuid() == 0 ? "user root; " : "") << "daemon off; worker_processes " << workers
       << "; pid " << (folder / "pid").string()
       << "; error_log stderr crit;\nevents { worker_connections 1024; }\nhttp {\n"
       << "include /etc/nginx/mime.types; default_type application/octet-stream;\n"
       << "access_log off; sendfile on; tcp_nopush on; keepalive_requests 1000000000;\n"
       << more;
  for (const char* const kind : { "client_body", "proxy", "fastcgi", "uwsgi", "scgi" })
  {
    text << kind << "_temp_path " << (folder / kind).string() << ";\n";
  }
  const auto root = (folder / "www").string();
  text << "server { listen 127.0.0.1:" << port << "; root " << root << "; include " << root
       << "/kdstream.nginx.conf; }\n}\n";
  return text.str();
}

struct Host
{
  std::string name;
  std::unique_ptr<ServerProcess> process;
  std::uint16_t port = 0;
  std::vector<double> rates; // requests a second
  std::vector<double> costs; // microseconds of processor time for each request
};

Host StartNginx(const std::string& name, const path& nginx, const path& folder,
  const std::string& more, std::optional<rlim_t> descriptors)
{
  Host host{ name, nullptr, FreePort(), {}, {} };
  const auto file = folder / (name + ".conf");
  std::ofstream(file) << NginxConfiguration(folder, host.port, more);
  host.process =
    std::make_unique<ServerProcess>(std::vector<std::string>{ nginx, "-e", "stderr", "-c", file },
      folder / "nginx.log", descriptors);
  return host;
}

// The figure after `name` in the output of wrk.
double FigureIn(const std::string& text, const std::string& name)
{
  const auto at = text.find(name);
  if (at == text.npos || text.find("Non-2xx") != text.npos ||
      text.find("Socket errors") != text.npos)
  {
    Fail("not all is answered: " + text);
  }
  return std::atof(text.c_str() + at + name.size());
}

// Requests a blob repeatedly for this time.
void Load(const path& wrk, Host& host, const std::string& target, const std::string& time,
  const path& folder)
{
  const auto url = "http://127.0.0.1:" + std::to_string(host.port) + target;
  const auto output = folder / "wrk.txt";
  const double before = host.process->ProcessorSeconds();
  const Cost cost =
    RunMeasured({ wrk, "-t1", std::string("-c") + connections, "-d" + time + "s", url }, output);
  const double rate = FigureIn(ReadWhole(output), "Requests/sec:");
  host.rates.push_back(rate);
  host.costs.push_back(1e6 * (host.process->ProcessorSeconds() - before) / (rate * cost.seconds));
}

double Median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// The median over the rounds of the ratio of the two hosts' requests a second.
double MedianRatio(const Host& host, const Host& other)
{
  std::vector<double> ratios;
  std::transform(host.rates.begin(), host.rates.end(), other.rates.begin(),
    std::back_inserter(ratios), std::divides<>());
  return Median(std::move(ratios));
}

// The partition with the median size, among those of a usual size.
protocol::BlobId Choose(const Store& store)
{
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sizes;
  const auto first = NodeId{ 1 } << store.Info().depths.partition;
  for (std::uint32_t partition = 0; partition < store.Info().partitions; ++partition)
  {
    const auto bytes =
      store.Size(BlobOfPiece({ Resolution::Original(), first + partition }, store.Info().depths));
    if (bytes && *bytes >= leastBytes && *bytes <= mostBytes)
    {
      sizes.emplace_back(*bytes, partition);
    }
  }
  if (sizes.empty())
  {
    Fail("the store has no partition of 6 to 16 kB");
  }
  std::sort(sizes.begin(), sizes.end());
  const auto& [bytes, partition] = sizes[sizes.size() / 2];
  std::printf("partition %u, %.1f kB\n", partition, static_cast<double>(bytes) / 1000);
  return protocol::BlobId::Partition(partition);
}

path Find(const char* program)
{
  for (const char* const folder : { "/usr/sbin", "/usr/bin", "/usr/local/sbin", "/usr/local/bin" })
  {
    if (std::filesystem::exists(path(folder) / program))
    {
      return path(folder) / program;
    }
  }
  Fail(std::string(program) + " is not installed");
}

std::vector<Host> StartHosts(
  const path& programs, const path& store, const path& folder, std::optional<rlim_t> descriptors)
{
  std::vector<Host> hosts;
  hosts.push_back({ "kdstream-serve",
    std::make_unique<ServerProcess>(std::vector<std::string>{ programs / "kdstream-serve",
                                      store.parent_path(), "--port", "0", "--threads", workers },
      folder / "serve.log", descriptors),
    0, {}, {} });
  hosts[0].port = hosts[0].process->ReadPort();
  const auto nginx = Find("nginx");
  hosts.push_back(StartNginx("nginx", nginx, folder, "", descriptors));
  hosts.push_back(StartNginx("nginx, files kept open", nginx, folder,
    "open_file_cache max=1000; open_file_cache_valid 1h;\n", descriptors));
  return hosts;
}

void Await(const std::vector<Host>& hosts, const std::string& target)
{
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::string body;
  for (const Host& host : hosts)
  {
    std::string answer;
    while ((answer = Get(host.port, target)).empty())
    {
      if (std::chrono::steady_clock::now() > until)
      {
        Fail(host.name + " does not answer");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    if (!body.empty() && answer != body)
    {
      Fail(host.name + " sends other bytes");
    }
    body = answer;
  }
}

// Returns whether the limit is met.
bool Compare(std::vector<Host>& hosts, const std::string& target, int rounds,
  const std::string& time, const path& folder)
{
  const auto wrk = Find("wrk");
  for (int round = -1; round < rounds; ++round) // round -1 only warms the servers up
  {
    for (Host& host : hosts)
    {
      Load(wrk, host, target, round < 0 ? "1" : time, folder);
      if (round < 0)
      {
        host.rates.clear();
        host.costs.clear();
      }
    }
  }
  for (const Host& host : hosts)
  {
    std::printf("  %-24s %8.0f requests/s (median of %d), %.1f us of the processors each\n",
      host.name.c_str(), Median(host.rates), rounds, Median(host.costs));
  }
  const double ratio = MedianRatio(hosts[0], hosts[1]);
  std::printf(
    "  ours over nginx's: %.2f (wanted: at least %.1f)%s; where it keeps files open: %.2f\n", ratio,
    leastRatio, ratio >= leastRatio ? "" : "  MISSED", MedianRatio(hosts[0], hosts[2]));
  std::fflush(stdout);
  return ratio >= leastRatio;
}

}

int main(int argc, char** argv)
{
  if (argc < 4)
  {
    std::cerr << "BenchBlob PROGRAMS STORE FOLDER [ROUNDS [SECONDS]]\n";
    return 2;
  }
  const path programs = argv[1], store = std::filesystem::absolute(argv[2]),
             folder = std::filesystem::absolute(argv[3]);
  const int rounds = argc > 4 ? std::atoi(argv[4]) : 5;
  const std::string time = argc > 5 ? argv[5] : "4";
  const auto opened = Store::Open(store);
  if (!opened)
  {
    Fail(store.string() + ": " + opened.GetError().message);
  }
  std::filesystem::create_directories(folder);
  RunMeasured(
    { programs / "kdstream-store", "export", store, folder / "www", "--quiet" }, "/dev/null");
  const auto target =
    protocol::BlobPath(store.stem().string(), (*opened)->Info().digest, Choose(**opened));
  bool good = true;
  for (const std::optional<rlim_t> descriptors :
    { std::optional<rlim_t>(), std::optional<rlim_t>(1024) })
  {
    std::printf(
      "%s\n", descriptors ? "with 1,024 descriptors" : "with as many descriptors as there are");
    auto hosts = StartHosts(programs, store, folder, descriptors);
    Await(hosts, target);
    good = Compare(hosts, target, rounds, time, folder) && good;
  }
  return good ? 0 : 1;
}
