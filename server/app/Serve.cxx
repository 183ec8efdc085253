// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve: streams the stores of a folder. The contract is doc/cli.md#kdstream-serve; the
// protocol is doc/protocol.md.
#include "filters/program/Program.h"
#include "server/app/AccessLog.h"
#include "server/app/FolderWatch.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"

#include <poll.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <iostream>
#include <thread>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Serves every store (NAME.kds) of a folder, as the model NAME, over HTTP and WebSocket.\n"
  "When it is ready it prints one line: listening on http://HOST:PORT\n"
  "Stores that come, change or go are seen by themselves; SIGHUP makes it read the folder and the\n"
  "pages again and open its log anew; SIGTERM and SIGINT end it, what is under way first.";

constexpr const char* examples = "Example:\n"
                                 "  kdstream-serve stores --port 8700 --access-log -";

struct CommandLine
{
  std::string folder, web, accessLog;
  std::uint64_t slowest = 16384;
  std::uint64_t cacheBytes = BlobCache::defaultBytes;
  std::chrono::seconds::rep grace = StoreCatalog::defaultGrace.count();
  HttpServerOptions server;
};

void AddOptions(CLI::App& app, CommandLine& line)
{
  auto& server = line.server;
  server.port = 8700;
  server.threads = std::max(2U, std::thread::hardware_concurrency());
  app.add_option("DIR", line.folder, "the folder of the stores")->required();
  const char* const address = "Address";
  app.add_option("--host", server.host, "name or address to listen at; 0.0.0.0: the whole network")
    ->type_name("ADDRESS")
    ->capture_default_str()
    ->group(address);
  app.add_option("--port", server.port, "port to listen at; 0: any that is free")
    ->check(CLI::Range(0, 65535))
    ->type_name("N")
    ->capture_default_str()
    ->group(address);
  auto* certificate =
    app.add_option("--tls-cert", server.tlsCertificate, "serve HTTPS with this certificate (PEM)")
      ->type_name("FILE")
      ->group(address);
  auto* key = app.add_option("--tls-key", server.tlsKey, "its private key (PEM, no passphrase)")
                ->type_name("FILE")
                ->group(address);
  certificate->needs(key);
  key->needs(certificate);

  app
    .add_option("--trusted-proxy", server.trustedProxies,
      "address or network of a proxy, whose X-Forwarded-For is believed; may be repeated")
    ->type_name("ADDRESS")
    ->allow_extra_args(false)
    ->group(address);
  app
    .add_option("--allow-host", server.allowedHosts,
      "host that requests may name; may be repeated [default: any]")
    ->type_name("HOST")
    ->allow_extra_args(false)
    ->group(address);

  const char* const pages = "Pages";
  app
    .add_option("--web", line.web,
      "serve the files of this folder at / [default: the web viewer installed with this program]")
    ->type_name("DIR")
    ->group(pages);
  app
    .add_option("--allow-origin", server.allowOrigin,
      "let pages of this origin read from here (CORS); *: of any")
    ->type_name("ORIGIN")
    ->group(pages);

  const char* const load = "Load";
  app
    .add_option(
      "--max-connections", server.maximumConnections, "clients at once; more are answered 503")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1000000 }))
    ->capture_default_str()
    ->group(load);
  app
    .add_option("--max-per-address", server.connectionsOfAddress,
      "clients of one address at once; more are answered 429; 0: any number [default: 100, for "
      "others than this machine]")
    ->type_name("N")
    ->group(load);
  app
    .add_option("--requests-per-minute", server.requestsOfAddress,
      "requests of one address; more are answered 429; 0: any number [default: 6000, for others "
      "than this machine]")
    ->type_name("N")
    ->group(load);
  app
    .add_option(
      "--max-region", server.regionPartitions, "most partitions of a region that is asked for")
    ->check(CLI::Range(std::size_t{ 1 }, std::size_t{ 1 } << 30))
    ->type_name("N")
    ->capture_default_str()
    ->group(load);
  const auto seconds = [&](const char* name, std::chrono::milliseconds& time, const char* text)
  {
    app
      .add_option_function<double>(
        name,
        [&time](double value) { time = std::chrono::milliseconds(std::llround(value * 1000)); },
        text)
      ->check(CLI::Range(0.001, 1e6))
      ->type_name("SECONDS")
      ->default_str(std::to_string(time.count() / 1000))
      ->group(load);
  };
  seconds("--request-timeout", server.requestTimeout, "for the handshake of TLS and a request");
  seconds("--answer-timeout", server.answerTimeout,
    "for taking an answer, or 64 KiB of a stream, and a second more for each --slowest");
  AddSizeOption(app, "--slowest", line.slowest, "bytes a second that a client must take")
    ->default_str("16K")
    ->group(load);
  seconds("--stream-timeout", server.streamTimeout, "until a stream that says nothing is closed");
  seconds("--idle-timeout", server.idleTimeout,
    "after which an idle stream is closed where its place is needed");
  app.add_option("--threads", server.threads, "threads that answer")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str()
    ->group(load);
  app.add_option("--readers", server.readers, "threads that wait for disks")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str()
    ->group(load);
  AddSizeOption(app, "--cache-memory", line.cacheBytes, "memory for blobs that clients share")
    ->default_str("256M")
    ->group(load);
  app
    .add_option(
      "--grace", line.grace, "seconds for which a replaced store's old digest is still answered")
    ->check(CLI::Range(std::chrono::seconds::rep{ 0 }, std::chrono::seconds::rep{ 1000000 }))
    ->type_name("SECONDS")
    ->capture_default_str()
    ->group(load);
  app.add_option("--access-log", line.accessLog, "write a line for every request; -: on stderr")
    ->type_name("FILE")
    ->group(load);
}

// The folder of the web viewer that is installed with this program; empty if there is none.
std::string InstalledWeb()
{
  std::error_code error;
  const auto program = std::filesystem::canonical("/proc/self/exe", error);
  const auto folder =
    std::filesystem::weakly_canonical(program.parent_path() / KDSTREAM_WEB_FOLDER, error);
  return !error && std::filesystem::is_regular_file(folder / "index.html", error) ? folder.string()
                                                                                  : "";
}

// Blocks the signals for ending and reloading in this thread and all that it starts, so that only
// WaitForEnd receives them.
sigset_t BlockSignals()
{
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

// What is wrong, though the server goes on.
void PrintWarning(const std::string& program, const std::string& file, const std::string& what)
{
  std::cerr << program << ": warning: " << file << ": " << what << std::endl;
}

void WarnOfEmptyFolder(
  const std::string& program, const std::string& folder, const StoreCatalog& catalog)
{
  if (catalog.Models().empty())
  {
    PrintWarning(program, folder, "there is no store (NAME.kds) to serve in this folder yet");
  }
}

// What runs beside the server.
struct Surroundings
{
  const std::string& program;
  const CommandLine& line;
  StoreCatalog& catalog;
  const std::shared_ptr<AccessLog>& log; // may be null
};

void Reload(const Surroundings& around)
{
  const auto& [program, line, catalog, log] = around;
  if (const auto status = catalog.Reload(); !status)
  {
    PrintWarning(
      program, line.folder, status.GetError().message + "; the models of before are served");
  }
  WarnOfEmptyFolder(program, line.folder, catalog);
  if (line.server.web)
  {
    line.server.web->Forget();
  }
  if (const auto status = log ? log->Reopen() : Status{}; !status)
  {
    PrintWarning(
      program, line.accessLog, status.GetError().message + "; the file of before is kept");
  }
}

// Reloads at SIGHUP and when stores come and go, until SIGTERM or SIGINT.
void WaitForEnd(const sigset_t& signals, const Surroundings& around)
{
  auto watch = FolderWatch::Open(around.line.folder);
  if (!watch)
  {
    PrintWarning(around.program, around.line.folder,
      watch.GetError().message + ": what changes in it is seen at SIGHUP");
  }
  else
  {
    around.catalog.Look(); // what came before it was watched
  }
  const int signalFile = ::signalfd(-1, &signals, SFD_CLOEXEC);
  std::array<pollfd, 2> sources{ { { signalFile, POLLIN, 0 },
    { watch ? watch->Descriptor() : -1, POLLIN, 0 } } };
  for (;;)
  {
    (void)::poll(sources.data(), sources.size(), 1000);
    if (watch && watch->HasChanged())
    {
      around.catalog.Look();
    }
    else
    {
      around.catalog.Refresh();
    }
    constexpr timespec now{ 0, 0 };
    const int signal = sigtimedwait(&signals, nullptr, &now);
    if (signal == SIGTERM || signal == SIGINT)
    {
      break;
    }
    if (signal == SIGHUP)
    {
      Reload(around);
    }
  }
  ::close(signalFile);
}

// Takes all the descriptors that the system gives, and no more clients than they are enough for:
// one each, and what the program itself needs.
void FitDescriptors(const std::string& program, HttpServerOptions& server)
{
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0)
  {
    return;
  }
  limit.rlim_cur = limit.rlim_max;
  (void)::setrlimit(RLIMIT_NOFILE, &limit);
  (void)::getrlimit(RLIMIT_NOFILE, &limit);
  // Of what is left, half for stores where there is little.
  const std::uint64_t own = std::min<std::uint64_t>(512, limit.rlim_cur / 2);
  const std::uint64_t most = std::max<std::uint64_t>(1, limit.rlim_cur - own);
  if (limit.rlim_cur != RLIM_INFINITY && server.maximumConnections > most)
  {
    PrintWarning(program, "--max-connections " + std::to_string(server.maximumConnections),
      "this process may have " + std::to_string(limit.rlim_cur) + " descriptors, enough for " +
        std::to_string(most) + " clients");
    server.maximumConnections = static_cast<std::size_t>(most);
  }
}

int Serve(const std::string& program, CommandLine& line)
{
  line.server.slowestBytes = static_cast<std::size_t>(std::max<std::uint64_t>(1, line.slowest));
  FitDescriptors(program, line.server);
  const sigset_t signals = BlockSignals();
  StoreCatalog catalog(
    line.folder,
    [&program](const std::filesystem::path& file, const std::string& what)
    { PrintWarning(program, file.string(), what); },
    std::chrono::seconds(line.grace), line.cacheBytes);
  if (const auto status = catalog.Reload(); !status)
  {
    return PrintError(program, line.folder, status.GetError());
  }
  if (line.web.empty())
  {
    line.web = InstalledWeb();
  }
  if (!line.web.empty())
  {
    auto web = StaticFiles::Open(line.web);
    if (!web)
    {
      return PrintError(program, line.web, web.GetError());
    }
    if (const auto home = web->Read("/"); !home)
    {
      return PrintError(
        program, line.web, { ErrorCode::NotFound, "there is no index.html in this folder" });
    }
    line.server.web = std::move(*web);
  }
  std::shared_ptr<AccessLog> log;
  if (!line.accessLog.empty())
  {
    if (line.accessLog != "-")
    {
      const auto place = CheckOutput(
        line.accessLog, OutputKind::Stream, { line.server.tlsCertificate, line.server.tlsKey });
      if (!place)
      {
        return PrintError(program, line.accessLog, place.GetError());
      }
    }
    auto opened = AccessLog::Open(line.accessLog);
    if (!opened)
    {
      return PrintError(program, line.accessLog, opened.GetError());
    }
    log = std::move(*opened);
    line.server.onAccess = [log](const AccessRecord& record) { log->Write(record); };
  }
  line.server.onError = [&program](const std::string& what) {
    PrintError(program, "", { ErrorCode::InputOutput, what });
  };
  line.server.version = KDSTREAM_VERSION;

  const auto server = HttpServer::Start(catalog, line.server);
  if (!server)
  {
    PrintError(program, "", server.GetError());
    return exitFailed; // also of a --host that no name server knows today
  }
  std::cout << "listening on " << (*server)->Url() << std::endl;
  WarnOfEmptyFolder(program, line.folder, catalog);
  WaitForEnd(signals, { program, line, catalog, log });
  (*server)->Stop();
  return exitDone;
}

}

int main(int argc, char** argv)
{
  CommandLine line;
  CLI::App app(description, "kdstream-serve");
  app.footer(examples);
  AddOptions(app, line);
  return RunProgram(app, argc, argv, [&]() { return Serve(app.get_name(), line); });
}
