// SPDX-License-Identifier: BSD-3-Clause
// A session's connection to a server: see ServerClient.h.
#include "viewer/client/ServerClient.h"

#include "filters/model/ModelJson.h"
#include "filters/model/Notes.h"
#include "filters/protocol/ResourcePath.h"
#include "viewer/client/ClientThread.h"
#include "viewer/client/ConnectServer.h"
#include "viewer/client/HttpFetcher.h"
#include "viewer/client/ServerLine.h"
#include "viewer/client/ServerStream.h"
#include "viewer/client/StreamSocket.h"

#include <boost/asio/steady_timer.hpp>

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <random>
#include <string_view>
#include <thread>
#include <utility>

namespace kdstream
{

namespace asio = boost::asio;

// Runs a ServerLine on Asio. All members are used only on its one thread, except in functions that
// say otherwise.
class ServerClient::Line
{
public:
  Line(ServerUrl server, std::shared_ptr<asio::ssl::context> tls)
    : Server(std::move(server))
    , Tls(std::move(tls))
    , Fetcher(this->MakeFetcher())
  {
  }

  ~Line() { this->Thread.Stop(); }

  ClientThread& Events() { return this->Thread; }

  // Call from another thread. After an error the connection cannot be used any more.
  Result<HttpReply> FetchAndWait(
    const HttpFetch& fetch, const Execution& execution, std::optional<std::chrono::seconds> timeout)
  {
    const auto begin = std::chrono::steady_clock::now();
    auto reply = std::make_shared<std::promise<Result<HttpReply>>>();
    auto answered = reply->get_future();
    // Shared, because Asio moves what is posted, and nothing may allocate memory before Waiting is
    // set.
    auto asked = std::make_shared<const HttpFetch>(fetch);
    this->Thread.Post(
      [this, asked, reply]
      {
        this->Waiting = reply;
        this->Fetcher->Fetch(
          *asked, [this](Result<HttpReply> answer) { this->Answer(std::move(answer)); });
      });
    this->IsGivenUp = true;
    while (answered.wait_for(patience) != std::future_status::ready)
    {
      KDSTREAM_TRY(execution.Report("waiting", 0));
      if (timeout && std::chrono::steady_clock::now() - begin > *timeout)
      {
        return NothingArrived(*timeout);
      }
    }
    this->IsGivenUp = false;
    return answered.get();
  }

  // Whether FetchAndWait ended before there was an answer.
  bool HasGivenUp() const { return this->IsGivenUp; }

  // The same, but repeats the request a few times if the server is busy, as when it starts or ends.
  // Between tries it waits as long as the server asks for, within limits.
  Result<HttpReply> FetchFromBusy(
    const HttpFetch& fetch, const Execution& execution, std::optional<std::chrono::seconds> timeout)
  {
    constexpr int mostTries = 5;
    for (int tries = 1;; ++tries)
    {
      auto reply = this->FetchAndWait(fetch, execution, timeout);
      if (!reply || !IsBusy(reply->status) || tries == mostTries)
      {
        return reply;
      }
      const double pause = std::clamp(reply->retryAfter, 1.0, 8.0);
      std::uniform_real_distribution<double> chance(1, 2);
      std::random_device random;
      const auto until =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(pause * chance(random));
      while (std::chrono::steady_clock::now() < until)
      {
        std::this_thread::sleep_for(patience);
        KDSTREAM_TRY(execution.Report("waiting", 0));
      }
    }
  }

  void Start()
  {
    this->Thread.Post(
      [this]
      {
        this->Started = true;
        this->Begin();
      });
  }

  // Fetches notes over a separate connection, so that the view does not wait for them. Only the
  // notes that were requested last arrive.
  void AskForNotes(const std::string& model)
  {
    this->Thread.Post(
      [this, model]
      {
        this->NotesFetcher = this->MakeFetcher();
        this->NotesFetcher->Fetch({ protocol::NotesPath(model), maximumNotesBytes },
          [this, model](const Result<HttpReply>& reply) { this->TakeNotes(model, reply); });
      });
  }

  void Send(const SessionRequest& request)
  {
    this->Thread.Post(
      [this, request]
      {
        try
        {
          this->Protocol->Send(request, Now());
        }
        catch (...) // otherwise the request would never be answered
        {
          ClientEvent event;
          event.kind = ClientEvent::Kind::RequestFailed;
          event.request = request.id;
          event.message = whyBroken;
          this->Unpublished.push_back(std::move(event));
          throw;
        }
        this->Act();
      });
  }

private:
  static constexpr const char* whyBroken = "this program ran out of memory or failed";
  static constexpr std::chrono::milliseconds patience{ 20 }; // between two checks for an abort

  static double Now()
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
  }

  std::unique_ptr<HttpFetcher> MakeFetcher()
  {
    return std::make_unique<HttpFetcher>(this->Thread.Context(), this->Server, this->Tls);
  }

  // Call after a task has thrown: everything in flight has failed, because a step was not done.
  void Disconnect()
  {
    const Error error{ ErrorCode::InputOutput, whyBroken };
    ++this->Connection;
    this->Socket.reset();
    this->NotesFetcher.reset();
    this->Fetcher.reset();
    this->Fetcher = this->MakeFetcher();
    this->Answer(error);
    this->Ticks.cancel();
    this->TickAt = std::numeric_limits<double>::infinity();
    if (!this->Started)
    {
      return;
    }
    if (!this->Protocol)
    {
      this->Begin();
      return;
    }
    if (this->Protocol->GetState() == ServerLine::State::Getting)
    {
      this->Protocol->Fetched(error, Now());
    }
    else
    {
      this->Protocol->SocketEnded(false, error.message, Now());
    }
    this->Act();
  }

  // Passes the reply to the caller that waits in FetchAndWait.
  void Answer(Result<HttpReply> reply)
  {
    if (this->Waiting != nullptr)
    {
      std::exchange(this->Waiting, nullptr)->set_value(std::move(reply));
    }
  }

  void Begin()
  {
    ServerLineOptions options;
    options.authority = this->Server.Authority();
    options.firstRetry = 1;
    options.jitter = 3;
    options.streamRetry = 60;
    options.stallTimeout = 60;
    this->Protocol.emplace(std::move(options));
    this->Act();
  }

  // Does the actions of the ServerLine, and passes on its events for the session.
  void Act()
  {
    for (ServerLine::Action& action : this->Protocol->TakeActions())
    {
      switch (action.kind)
      {
        // This may run in a callback of the old socket, so the socket is destroyed later.
        case ServerLine::Action::Kind::Connect:
          ++this->Connection;
          this->Thread.Post([this] { this->Connect(); });
          break;
        case ServerLine::Action::Kind::Close:
          ++this->Connection;
          this->Thread.Post([this] { this->Socket.reset(); });
          break;
        case ServerLine::Action::Kind::Send:
          this->Socket->Send(std::move(action.text));
          break;
        case ServerLine::Action::Kind::Fetch:
          this->Thread.Post([this, fetch = action.fetch] { this->Fetch(fetch); });
          break;
      }
    }
    this->Thread.Publish(this->Unpublished); // left from before, for lack of memory
    this->Unpublished = this->Protocol->TakeEvents();
    this->Thread.Publish(this->Unpublished);
    this->WaitForTick();
  }

  void WaitForTick()
  {
    const double next = this->Protocol->NextTick();
    if (next == this->TickAt)
    {
      return;
    }
    this->TickAt = next;
    this->Ticks.cancel();
    if (!std::isfinite(next))
    {
      return;
    }
    this->Ticks.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(std::max(0.0, next - Now()))));
    this->Ticks.async_wait(
      [this](boost::system::error_code error)
      {
        if (!error)
        {
          this->TickAt = 0;
          this->Protocol->Tick(Now());
          this->Act();
        }
      });
  }

  void Connect()
  {
    // Messages of an abandoned connection are ignored.
    const auto current = [this, mine = this->Connection] { return mine == this->Connection; };
    StreamSocket::Handlers handlers;
    handlers.onOpen = [this, current]
    {
      if (current())
      {
        this->Protocol->SocketOpened(Now());
        this->Act();
      }
    };
    handlers.onMessage = [this, current](std::span<const std::uint8_t> bytes, bool isText)
    {
      if (current())
      {
        this->Receive(bytes, isText);
      }
    };
    handlers.onEnd = [this, current](bool refused, const std::string& why, double retryAfter)
    {
      if (current())
      {
        this->Protocol->SocketEnded(refused, why, Now(), retryAfter);
        this->Act();
      }
    };
    this->Socket = std::make_unique<StreamSocket>(
      this->Thread.Context(), this->Server, this->Tls, std::move(handlers));
  }

  void Receive(std::span<const std::uint8_t> bytes, bool isText)
  {
    if (isText)
    {
      this->Protocol->SocketText(
        { reinterpret_cast<const char*>(bytes.data()), bytes.size() }, Now());
    }
    else
    {
      this->Protocol->SocketFrame(bytes, Now());
    }
    this->Act();
  }

  void Fetch(const HttpFetch& fetch)
  {
    this->Fetcher->Fetch(fetch,
      [this](const Result<HttpReply>& reply)
      {
        this->Protocol->Fetched(reply, Now());
        this->Act();
      });
  }

  void TakeNotes(const std::string& model, const Result<HttpReply>& reply)
  {
    if (!reply || reply->status != 200)
    {
      return; // the model is shown without notes
    }
    ClientEvent event;
    event.kind = ClientEvent::Kind::Notes;
    event.model.id = model;
    event.bytes.assign(reply->body.begin(), reply->body.end());
    this->Unpublished.push_back(std::move(event));
    this->Thread.Publish(this->Unpublished);
  }

  ServerUrl Server;
  std::shared_ptr<asio::ssl::context> Tls; // null: no TLS
  bool IsGivenUp = false;                  // used by the thread that calls FetchAndWait
  // Before the members that need its context.
  ClientThread Thread{ [this] { this->Disconnect(); } };
  bool Started = false;
  std::optional<ServerLine> Protocol; // since Begin
  std::uint64_t Connection = 0;       // the number of the current connection
  std::unique_ptr<StreamSocket> Socket;
  std::unique_ptr<HttpFetcher> Fetcher;
  std::unique_ptr<HttpFetcher> NotesFetcher;
  std::shared_ptr<std::promise<Result<HttpReply>>> Waiting; // for FetchAndWait
  std::vector<ClientEvent> Unpublished;
  asio::steady_timer Ticks{ this->Thread.Context() };
  double TickAt = std::numeric_limits<double>::infinity(); // the time that Ticks waits for
};

ServerClient::ServerClient(std::unique_ptr<Line> line)
  : Kept(std::move(line))
{
}

ServerClient::~ServerClient() = default;

// Ends a connection on another thread, without waiting: if a name server does not answer, that may
// take long.
void ServerClient::LetGo(std::unique_ptr<Line> line)
{
  std::thread([ending = std::move(line)]() mutable { ending.reset(); }).detach();
}

Result<std::unique_ptr<ServerClient>> ServerClient::Connect(const std::string& url,
  const std::string& token, const std::string& authorities, const Execution& execution,
  std::optional<std::chrono::seconds> timeout)
{
  auto server = ParseServerUrl(url);
  KDSTREAM_TRY(server);
  if (!token.empty() && !IsToken(token))
  {
    return Error{ ErrorCode::InvalidArgument,
      "this is not a token: it is too long, or has characters other than A-Z a-z 0-9 . _ -" };
  }
  server->token = token;
  const auto tls = server->isSecure ? MakeTlsContext(authorities)
                                    : Result<std::shared_ptr<asio::ssl::context>>(nullptr);
  KDSTREAM_TRY(tls);
  const std::string authority = server->Authority();
  std::unique_ptr<ServerClient> client(new ServerClient(std::make_unique<Line>(*server, *tls)));
  auto reply = client->Kept->FetchFromBusy(
    { std::string(protocol::modelListPath), maximumModelListBytes }, execution, timeout);
  if (!reply && (client->Kept->HasGivenUp() || reply.GetError().code == ErrorCode::Cancelled))
  {
    LetGo(std::move(client->Kept));
  }
  KDSTREAM_TRY(reply);
  if (reply->status != 200)
  {
    return Error{ ErrorCode::InvalidInput,
      authority + " does not list its models: " + DescribeRefusal(*reply) };
  }
  auto models = ParseModelList(reply->body);
  if (!models)
  {
    return Error{ ErrorCode::InvalidInput,
      authority + " is not a KdStream server: " + models.GetError().message };
  }
  client->ModelList = std::move(*models);
  client->Kept->Start();
  return client;
}

void ServerClient::Send(const SessionRequest& request)
{
  this->Kept->Send(request);
}

void ServerClient::AskForNotes(const std::string& model)
{
  this->Kept->AskForNotes(model);
}

std::vector<ClientEvent> ServerClient::Take()
{
  return this->Kept->Events().Take();
}

bool ServerClient::Wait(std::chrono::milliseconds atMost)
{
  return this->Kept->Events().Wait(atMost);
}

}
