// SPDX-License-Identifier: BSD-3-Clause
// kdstream-serve: streams the stores of a folder. doc/cli.md#kdstream-serve describes the program,
// doc/protocol.md the protocol.
#include "filters/core/CaughtError.h"
#include "filters/page/PagePlace.h"
#include "filters/program/Program.h"
#include "kdstream/Version.h"
#include "server/app/AccessLog.h"
#include "server/app/BackgroundJob.h"
#include "server/app/Descriptors.h"
#include "server/app/FolderFollower.h"
#include "server/app/Messages.h"
#include "server/app/ServeOptions.h"
#include "server/app/TokenCommand.h"
#include "server/app/TokensFile.h"
#include "server/http/HttpServer.h"
#include "server/session/StoreCatalog.h"

#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <future>
#include <iostream>
#include <string_view>
#include <thread>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Serves every store (NAME.kds) of a folder as the model NAME, over HTTP and WebSocket.\nWhen it "
  "is ready it prints one line: listening on http://HOST:PORT\nIt notices new, changed and removed "
  "stores and keys by itself. SIGHUP makes it read the folder,\nthe pages, the keys and the "
  "certificate again, and reopen its logs. SIGTERM and SIGINT end it\nafter the requests in "
  "flight; a second signal ends it at once.";

constexpr const char* examples = "Example:\n"
                                 "  kdstream-serve stores --port 8700 --access-log -";

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

// Blocks the signals for ending and reloading in this thread and in all threads that it starts, so
// that only WaitForEnd receives them.
sigset_t BlockSignals()
{
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN); // so a log beyond the file size limit fails like a full disk
  return signals;
}

void WarnOfEmptyFolder(Messages& messages, const std::string& folder, const StoreCatalog& catalog)
{
  if (catalog.Models().empty())
  {
    messages.Warn(folder, "this folder has no stores (NAME.kds) yet");
  }
}

void Reopen(Messages& messages, const std::string& file, const std::shared_ptr<AccessLog>& log)
{
  if (const auto status = log->Reopen(); !status)
  {
    messages.Warn(file, status.GetError().message + "; the earlier file stays in use");
  }
}

// The access log and the audit log; null if not requested.
struct Logs
{
  std::shared_ptr<AccessLog> access, audit;
};

std::uint64_t LostLines(const Messages& messages, const Logs& logs)
{
  std::uint64_t lost = messages.Lost();
  for (const auto& log : { logs.access, logs.audit })
  {
    lost += log ? log->Lost() : 0;
  }
  return lost;
}

// Reports which log loses lines, and why: at once, then once a minute.
class LossTeller
{
public:
  void Look(Messages& messages, const std::string& file, const std::shared_ptr<AccessLog>& log)
  {
    constexpr std::chrono::minutes between{ 1 };
    const auto now = std::chrono::steady_clock::now();
    const std::uint64_t lost = log ? log->Lost() : 0;
    if (lost == this->Reported || (this->Reported > 0 && now - this->Since < between))
    {
      return;
    }
    const std::string why = log->WhyLost();
    messages.Warn(file, std::to_string(lost - this->Reported) + " log lines were lost" +
                          (why.empty() ? "" : ": " + why));
    this->Reported = lost;
    this->Since = now;
  }

private:
  std::uint64_t Reported = 0;
  std::chrono::steady_clock::time_point Since;
};

// The parts of the program that run beside the server.
struct Environment
{
  const ServeOptions& line;
  Messages& messages;
  StoreCatalog& catalog;
  FolderFollower& folder;
  const Logs& logs;
  std::deque<BackgroundJob>& jobs; // each reads a file that SIGHUP reloads, and may block
  HttpServer& server;
};

void Reload(const Environment& around)
{
  around.folder.ReadAnew(
    [&around] { WarnOfEmptyFolder(around.messages, around.line.folder, around.catalog); });
  if (around.line.server.web)
  {
    around.line.server.web->Forget();
  }
  for (BackgroundJob& job : around.jobs)
  {
    job.Ask();
  }
}

// Does the work. If memory runs out, the work is left unfinished, which is reported, and the server
// continues.
template <class Work>
void Try(Messages& messages, std::string_view what, const Work& work)
{
  try
  {
    try
    {
      work();
    }
    catch (...)
    {
      messages.Fail(std::string(what) + ": " + CaughtError().message);
    }
  }
  catch (...) // there is no memory for a message either
  {
  }
}

constexpr const char* notAllRead = "SIGHUP: not everything could be read again";

// Checks often whether the keys have changed: a revoked token must stop working within a second,
// even while the rest of the server reads stores or ends. Streams check their tokens equally often.
void FollowKeys(std::deque<BackgroundJob>& jobs, Messages& messages, const std::string& name,
  const std::optional<TokensFile>& tokens)
{
  constexpr std::chrono::milliseconds interval{ 250 };
  if (!tokens)
  {
    return;
  }
  const auto work = [&messages, name, file = *tokens](bool isAsked) mutable
  {
    const auto read = [&]
    {
      if (const auto status = isAsked ? file.Reload() : file.Look(); !status)
      {
        messages.Warn(name, status.GetError().message + "; the earlier keys stay valid");
      }
    };
    try
    {
      isAsked ? Try(messages, notAllRead, read) : read();
    }
    catch (...) // lack of memory: the next check follows soon
    {
    }
  };
  jobs.emplace_back(work, interval);
}

// Creates the jobs. Each has a thread of its own: if one disk hangs, files on other disks are still
// read.
void MakeJobs(std::deque<BackgroundJob>& jobs, const ServeOptions& line, Messages& messages,
  const Logs& logs, const std::optional<TokensFile>& tokens, HttpServer& server)
{
  FollowKeys(jobs, messages, line.tokens, tokens);
  if (!line.server.tlsCertificate.empty())
  {
    const auto load = [&messages, &server]
    {
      if (const auto status = server.ReloadTls(); !status)
      {
        messages.Warn("", status.GetError().message + "; the earlier certificate stays in use");
      }
    };
    jobs.emplace_back([&messages, load](bool) { Try(messages, notAllRead, load); });
  }
  for (const auto& [file, log] :
    { std::pair(line.accessLog, logs.access), { line.auditLog, logs.audit } })
  {
    if (log)
    {
      const auto reopen = [&messages, file = file, log = log] { Reopen(messages, file, log); };
      jobs.emplace_back([&messages, reopen](bool) { Try(messages, notAllRead, reopen); });
    }
  }
}

// Whether a signal to end has arrived. REQUIRES: the signals are blocked.
bool IsToEnd(const sigset_t& signals)
{
  constexpr timespec now{ 0, 0 };
  const int signal = sigtimedwait(&signals, nullptr, &now);
  return signal == SIGTERM || signal == SIGINT;
}

// Reloads at SIGHUP, until SIGTERM or SIGINT.
void WaitForEnd(const sigset_t& signals, const Environment& around)
{
  around.folder.Follow();
  const int signalFile = ::signalfd(-1, &signals, SFD_CLOEXEC);
  pollfd source{ signalFile, POLLIN, 0 };
  constexpr int untilNextLook = 1000; // ms
  LossTeller ofAccess, ofAudit;
  for (;;)
  {
    (void)::poll(&source, 1, untilNextLook);
    Try(around.messages, "lost log lines could not be reported",
      [&]
      {
        ofAccess.Look(around.messages, around.line.accessLog, around.logs.access);
        ofAudit.Look(around.messages, around.line.auditLog, around.logs.audit);
      });
    constexpr timespec now{ 0, 0 };
    const int signal = sigtimedwait(&signals, nullptr, &now);
    if (signal == SIGTERM || signal == SIGINT)
    {
      break;
    }
    if (signal == SIGHUP)
    {
      Try(around.messages, notAllRead, [&around] { Reload(around); });
    }
  }
  ::close(signalFile);
}

// Finishes the answers in flight, for at most drainTimeout; a further signal ends this.
void Drain(const sigset_t& signals, const Environment& around)
{
  const auto until = std::chrono::steady_clock::now() + around.line.server.drainTimeout;
  constexpr std::chrono::milliseconds step{ 50 };
  around.server.BeginDrain();
  while (!around.server.WaitUntilDrained(step))
  {
    if (IsToEnd(signals) || std::chrono::steady_clock::now() >= until)
    {
      around.messages.Warn("", "the server stops before all requests are answered");
      return;
    }
  }
}

// Ends everything that a disk may block, waiting for at most `time`. Returns false if a disk still
// blocks something; then the objects that this thread uses must not be destroyed.
bool EndWithin(std::chrono::milliseconds time, const Environment& around)
{
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + time;
  const auto left = [until]
  {
    return std::max(std::chrono::milliseconds(0),
      std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()));
  };
  bool isFree = around.server.StopWithin(left());
  isFree = around.folder.End(left()) && isFree;
  Try(around.messages, "the quotas are closed later",
    [&around]
    {
      if (const auto quotas = around.line.server.quotas)
      {
        around.jobs.emplace_back([quotas](bool) { quotas->Close(); }).Ask();
      }
    });
  for (BackgroundJob& job : around.jobs)
  {
    isFree = job.End(left()) && isFree;
  }
  return isFree;
}

// Ends the process at once, although threads wait for a disk. The logs' waiting lines are written
// first.
[[noreturn]] void EndAtOnce(Messages& messages, const Logs& logs)
{
  messages.Warn("", "the server stops although a disk does not respond");
  for (const auto& log : { logs.access, logs.audit })
  {
    if (log)
    {
      log->End();
    }
  }
  messages.End();
  std::cout.flush();
  std::_Exit(exitDone);
}

// Limits the number of clients to what the available descriptors allow.
Status FitDescriptors(
  Messages& messages, std::optional<std::uint64_t> limit, HttpServerOptions& server)
{
  const auto wanted = server.maximumConnections;
  const auto isShort = limit ? FitConnections(*limit, server) : false;
  KDSTREAM_TRY(isShort);
  if (*isShort)
  {
    messages.Warn("--max-connections " + std::to_string(wanted),
      "this process may open " + std::to_string(*limit) +
        " descriptors, which is enough for only " + std::to_string(server.maximumConnections) +
        " clients");
  }
  return {};
}

// Opens the log; null if none is requested.
Result<std::shared_ptr<AccessLog>> OpenLog(
  const std::string& file, AccessLog::Form form, const ServeOptions& line)
{
  if (file.empty())
  {
    return std::shared_ptr<AccessLog>();
  }
  if (file != "-")
  {
    const auto place = CheckOutput(file, OutputKind::Stream,
      { line.server.tlsCertificate, line.server.tlsKey, line.tokens, line.quotaFile });
    KDSTREAM_TRY(place);
  }
  return AccessLog::Open(file, form);
}

void SayWhoMay(Messages& messages, const std::string& file, const std::optional<TokensFile>& tokens)
{
  if (!tokens)
  {
    messages.Say("without --tokens, everybody who can reach this server can load every model");
  }
  else if (tokens->IsForAll())
  {
    messages.Warn(file, "every user of this machine can read these keys: run chmod 600");
  }
}

// Finds the files that `/` serves.
Status OpenPages(Messages& messages, ServeOptions& line)
{
  if (line.web.empty())
  {
    line.web = InstalledWeb();
  }
  if (line.web.empty())
  {
    return {};
  }
  auto web = OfFile(line.web,
    StaticFiles::Open(line.web, [&messages](const std::string& file, const std::string& what)
      { messages.Warn(file, what); }));
  KDSTREAM_TRY(web);
  if (const auto page = web->Read("/"); !page)
  {
    return page.GetError().code == ErrorCode::NotFound
             ? Error{ ErrorCode::NotFound, "there is no index.html in this folder", line.web }
             : page.GetError();
  }
  line.server.web = std::move(*web);
  return {};
}

Result<Logs> OpenLogs(ServeOptions& line)
{
  Logs logs;
  auto access = OfFile(line.accessLog, OpenLog(line.accessLog, AccessLog::Form::Text, line));
  KDSTREAM_TRY(access);
  logs.access = std::move(*access);
  auto audit = OfFile(line.auditLog, OpenLog(line.auditLog, AccessLog::Form::Json, line));
  KDSTREAM_TRY(audit);
  logs.audit = std::move(*audit);
  if (logs.access)
  {
    line.server.onAccess = [to = logs.access](const AccessRecord& record) { to->Write(record); };
  }
  if (logs.audit)
  {
    line.server.onPartition = [to = logs.audit](const PartitionRecord& record)
    { to->Write(record); };
  }
  return logs;
}

// Opens the keys and the quotas: who may have what, and how much. Without a file of keys everybody
// may have everything.
Result<std::optional<TokensFile>> OpenAccess(ServeOptions& line)
{
  if (!line.quotaFile.empty())
  {
    auto quotas = OfFile(line.quotaFile, QuotaBook::Open(line.quotaFile, line.quotas));
    KDSTREAM_TRY(quotas);
    line.server.quotas = std::move(*quotas);
  }
  if (line.tokens.empty())
  {
    return std::optional<TokensFile>();
  }
  auto tokens = OfFile(line.tokens, TokensFile::Open(line.tokens));
  KDSTREAM_TRY(tokens);
  line.server.guard = tokens->Guard();
  return std::optional(std::move(*tokens));
}

// Serves until it is asked to end.
void Run(const sigset_t& signals, const ServeOptions& line, Messages& messages,
  StoreCatalog& catalog, FolderFollower& folder, const Logs& logs,
  const std::optional<TokensFile>& tokens, HttpServer& server)
{
  if (line.server.admin)
  {
    messages.Say("metrics on " + server.AdminUrl() + "/metrics");
  }
  SayWhoMay(messages, line.tokens, tokens);
  std::cout << "listening on " << server.Url() << std::endl;
  WarnOfEmptyFolder(messages, line.folder, catalog);
  if (const auto status = messages.WaitForNobody(); !status)
  {
    messages.Warn("", status.GetError().message);
  }
  std::deque<BackgroundJob> jobs;
  MakeJobs(jobs, line, messages, logs, tokens, server);
  const Environment around{ line, messages, catalog, folder, logs, jobs, server };
  WaitForEnd(signals, around);
  Drain(signals, around);
  constexpr std::chrono::milliseconds patience{ 1000 };
  if (!EndWithin(patience, around))
  {
    EndAtOnce(messages, logs);
  }
}

// Reads the folder for the first time. Nothing if a signal to end came before the disk answered.
std::optional<Status> ReadFirst(const sigset_t& signals, FolderFollower& folder)
{
  constexpr std::chrono::milliseconds step{ 50 };
  for (;;)
  {
    if (auto status = folder.AwaitFirst(step))
    {
      return status;
    }
    if (IsToEnd(signals))
    {
      return std::nullopt;
    }
  }
}

// The result of `work`, which may wait for a disk. A signal to end then ends the program.
template <class Work>
auto AwaitDisk(const sigset_t& signals, Messages& messages, const Work& work)
{
  constexpr std::chrono::milliseconds step{ 50 };
  std::packaged_task<decltype(work())()> task(work);
  auto result = task.get_future();
  std::thread thread(std::move(task));
  while (result.wait_for(step) != std::future_status::ready)
  {
    if (IsToEnd(signals))
    {
      EndAtOnce(messages, {});
    }
  }
  thread.join();
  return result.get();
}

int Serve(const std::string& program, ServeOptions& line)
{
  Messages messages(program);
  line.server.slowestBytes = static_cast<std::size_t>(std::max<std::uint64_t>(1, line.slowest));
  const auto descriptors = TakeDescriptors();
  constexpr auto mostOpen = StoreCatalog::defaultOpenStores;
  const auto openStores =
    descriptors ? FitOpenStores(*descriptors, mostOpen, line.server) : mostOpen;
  if (!openStores)
  {
    return PrintError(program, "", openStores.GetError());
  }
  const sigset_t signals = BlockSignals();
  const auto await = [&](const auto& work) { return AwaitDisk(signals, messages, work); };
  if (const auto opened = await([&] { return OpenPages(messages, line); }); !opened)
  {
    return PrintError(program, "", opened.GetError());
  }
  StoreCatalog catalog(
    line.folder,
    [&messages](const std::filesystem::path& file, const std::string& what)
    { messages.Warn(file.string(), what); },
    std::chrono::seconds(line.grace), line.cacheBytes, *openStores);
  catalog.SetSite(line.site);
  catalog.SetPages(line.server.web ? std::string(pagesFolder) : std::string());
  FolderFollower folder(catalog, line.folder,
    [&messages, &line](const std::string& what) { messages.Warn(line.folder, what); });
  const auto status = ReadFirst(signals, folder);
  if (!status)
  {
    EndAtOnce(messages, {});
  }
  if (!*status)
  {
    Error error = status->GetError();
    if (error.code == ErrorCode::NotFound && line.folder.find('/') == std::string::npos)
    {
      error.message +=
        " (" + program + " needs the folder of the stores; its only command is token)";
    }
    return PrintError(program, line.folder, error);
  }
  const auto logs = await([&] { return OpenLogs(line); });
  if (!logs)
  {
    return PrintError(program, "", logs.GetError());
  }
  const auto tokens = await([&] { return OpenAccess(line); });
  if (!tokens)
  {
    return PrintError(program, "", tokens.GetError());
  }
  if (const auto fit = FitDescriptors(messages, descriptors, line.server); !fit)
  {
    return PrintError(program, "", fit.GetError());
  }
  line.server.onError = [&messages](const std::string& what) { messages.Fail(what); };
  line.server.lostLines = [&messages, logs = *logs] { return LostLines(messages, logs); };
  line.server.version = KDSTREAM_VERSION;

  const auto server = await([&] { return HttpServer::Start(catalog, line.server); });
  if (!server)
  {
    PrintError(program, "", server.GetError());
    return exitFailed; // for example, a --host that no name server knows today
  }
  Run(signals, line, messages, catalog, folder, *logs, *tokens, **server);
  return exitDone; // requests in flight end with the server
}

}

int main(int argc, char** argv)
try
{
  ServeOptions line;
  CLI::App app(description, "kdstream-serve");
  app.footer(examples);
  AddServeOptions(app, line);
  TokenOptions token;
  const auto* const makesToken = AddTokenCommand(app, token);
  const bool serves = argc < 2 || makesToken->get_name() != argv[1];
  FindOption(app, "DIR")->required(serves);
  return RunProgram(app, argc, argv,
    [&] { return serves ? Serve(app.get_name(), line) : PrintToken(app.get_name(), token); });
}
catch (...) // memory runs out before the work begins
{
  return kdstream::PrintError("kdstream-serve", "", kdstream::CaughtError());
}
