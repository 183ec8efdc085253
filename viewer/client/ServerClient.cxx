// A session's line to a server: requests out, blobs in, on a thread of its own.
#include "viewer/client/ServerClient.h"

#include "server/protocol/ResourcePath.h"
#include "viewer/client/GetConversation.h"
#include "viewer/client/HttpFetcher.h"
#include "viewer/client/StreamConversation.h"
#include "viewer/client/StreamSocket.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <condition_variable>
#include <future>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

namespace kdstream
{

namespace asio = boost::asio;

// Everything but the queue of events lives on the context's one thread.
class ServerClient::Line
{
public:
  explicit Line(ServerUrl server)
    : Server(std::move(server))
    , Work(asio::make_work_guard(this->Context))
    , Fetcher(std::make_unique<HttpFetcher>(this->Context, this->Server))
    , Thread([this] { this->Context.run(); })
  {
  }

  ~Line()
  {
    asio::post(this->Context,
      [this]
      {
        this->Socket.reset();
        this->Fetcher.reset();
        this->Context.stop();
      });
    this->Thread.join();
  }

  // From another thread.
  Result<HttpReply> FetchAndWait(const HttpFetch& fetch)
  {
    std::promise<Result<HttpReply>> promise;
    auto reply = promise.get_future();
    asio::post(this->Context,
      [this, &fetch, &promise]
      {
        this->Fetcher->Fetch(
          fetch, [&promise](Result<HttpReply> answer) { promise.set_value(std::move(answer)); });
      });
    return reply.get();
  }

  void StartStream()
  {
    asio::post(this->Context, [this] { this->Connect(); });
  }

  void Send(const SessionRequest& request)
  {
    asio::post(this->Context, [this, request] { this->SendHere(request); });
  }

  std::vector<ClientEvent> Take()
  {
    const std::lock_guard lock(this->Mutex);
    return std::exchange(this->Events, {});
  }

  bool Wait(std::chrono::milliseconds atMost)
  {
    std::unique_lock lock(this->Mutex);
    return this->Arrived.wait_for(lock, atMost, [this] { return !this->Events.empty(); });
  }

private:
  enum class State
  {
    Connecting, // to the stream, for the first time or again
    Streaming,
    Lost,   // until the next request
    Getting // the server has no stream
  };

  static double Now()
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
  }

  void SendHere(const SessionRequest& request)
  {
    if (this->Current == State::Getting)
    {
      this->Gets.Send(request, Now());
      this->GetNext();
      return;
    }
    if (!this->HasStreamed)
    {
      this->Early.push_back(request);
    }
    this->Stream.Send(request, Now());
    if (this->Current == State::Lost && this->Stream.IsWaiting())
    {
      this->Connect();
    }
    this->Flush();
  }

  void Connect()
  {
    this->Current = State::Connecting;
    StreamSocket::Handlers handlers;
    handlers.onOpen = [this]
    {
      this->Current = State::Streaming;
      this->HasStreamed = true;
      this->Early.clear();
      this->Stream.Restart(Now());
      this->Flush();
    };
    handlers.onMessage = [this](std::span<const std::uint8_t> bytes, bool isText)
    { this->Receive(bytes, isText); };
    handlers.onEnd = [this](bool refused, const std::string& why) { this->End(refused, why); };
    this->Socket = std::make_unique<StreamSocket>(this->Context, this->Server, std::move(handlers));
  }

  void Receive(std::span<const std::uint8_t> bytes, bool isText)
  {
    if (this->Ending)
    {
      return;
    }
    const Status status =
      isText ? this->Stream.ReceiveText(
                 { reinterpret_cast<const char*>(bytes.data()), bytes.size() }, Now())
             : this->Stream.ReceiveFrame(bytes, Now());
    if (!status)
    {
      this->End(false, status.GetError().message);
      return;
    }
    this->MayRetry = true;
    this->Flush();
  }

  void End(bool refused, const std::string& why)
  {
    if (refused && !this->HasStreamed)
    {
      this->Current = State::Getting;
      for (const SessionRequest& request : std::exchange(this->Early, {}))
      {
        this->Gets.Send(request, Now());
      }
      this->GetNext();
      return;
    }
    // The socket that calls this may be in the middle of a message, and may call again: it goes
    // later.
    if (!std::exchange(this->Ending, true))
    {
      asio::post(this->Context, [this, why] { this->Lost(why); });
    }
  }

  void Lost(const std::string& why)
  {
    this->Ending = false;
    if (std::exchange(this->MayRetry, false))
    {
      this->Connect();
      return;
    }
    this->Socket.reset();
    this->Current = State::Lost;
    this->Stream.FailAll("the connection to " + this->Server.Authority() + " was lost: " + why);
    this->Flush();
  }

  void GetNext()
  {
    if (const auto fetch = this->Gets.Next())
    {
      this->Fetcher->Fetch(*fetch,
        [this](const Result<HttpReply>& reply)
        {
          this->Gets.Receive(reply, Now());
          this->Publish(this->Gets.TakeEvents());
          asio::post(this->Context, [this] { this->GetNext(); });
        });
    }
  }

  void Flush()
  {
    for (std::string& message : this->Stream.TakeMessages())
    {
      // What is said while there is no connection is said again by Restart.
      if (this->Current == State::Streaming)
      {
        this->Socket->Send(std::move(message));
      }
    }
    this->Publish(this->Stream.TakeEvents());
  }

  void Publish(std::vector<ClientEvent> events)
  {
    if (events.empty())
    {
      return;
    }
    const std::lock_guard lock(this->Mutex);
    for (ClientEvent& event : events)
    {
      this->Events.push_back(std::move(event));
    }
    this->Arrived.notify_all();
  }

  ServerUrl Server;
  asio::io_context Context;
  asio::executor_work_guard<asio::io_context::executor_type> Work;
  State Current = State::Connecting;
  bool HasStreamed = false;
  bool MayRetry = true;              // the connection brought something since it was made
  bool Ending = false;               // Lost will be called
  std::vector<SessionRequest> Early; // before it is known whether there is a stream
  StreamConversation Stream;
  GetConversation Gets;
  std::unique_ptr<StreamSocket> Socket;
  std::unique_ptr<HttpFetcher> Fetcher;

  std::mutex Mutex;
  std::condition_variable Arrived;
  std::vector<ClientEvent> Events;

  std::thread Thread; // last: it uses all of the above
};

ServerClient::ServerClient(std::unique_ptr<Line> line)
  : Kept(std::move(line))
{
}

ServerClient::~ServerClient() = default;

Result<std::unique_ptr<ServerClient>> ServerClient::Connect(const std::string& url)
{
  auto server = ParseServerUrl(url);
  if (!server)
  {
    return server.GetError();
  }
  const std::string authority = server->Authority();
  std::unique_ptr<ServerClient> client(new ServerClient(std::make_unique<Line>(*server)));
  auto reply = client->Kept->FetchAndWait(
    { std::string(protocol::modelListPath), protocol::maximumModelListBytes });
  if (!reply)
  {
    return reply.GetError();
  }
  if (reply->status != 200)
  {
    return Error{ ErrorCode::InvalidInput,
      authority + " has no list of models: " + DescribeRefusal(*reply) };
  }
  auto models = protocol::ParseModelList(reply->body);
  if (!models)
  {
    return Error{ ErrorCode::InvalidInput,
      authority + " is no KdStream server: " + models.GetError().message };
  }
  client->ModelList = std::move(*models);
  client->Kept->StartStream();
  return client;
}

void ServerClient::Send(const SessionRequest& request)
{
  this->Kept->Send(request);
}

std::vector<ClientEvent> ServerClient::Take()
{
  return this->Kept->Take();
}

bool ServerClient::Wait(std::chrono::milliseconds atMost)
{
  return this->Kept->Wait(atMost);
}

}
