// SPDX-License-Identifier: BSD-3-Clause
#include "server/http/HttpConnection.h"

#include "filters/protocol/ResourcePath.h"
#include "server/http/HttpMessage.h"
#include "server/http/ProxyHeader.h"
#include "server/http/RequestInput.h"
#include "server/http/RoundTrip.h"
#include "server/http/WebSocketFrames.h"
#include "server/session/Refusal.h"

#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/string.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/rfc7230.hpp>
#include <boost/beast/websocket/rfc6455.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace kdstream
{

namespace
{

// A connection goes through these states. No client can postpone the end of a state:
//
//   a proxy's header, TLS handshake      --request-timeout for both together
//   the request's header                 --request-timeout
//   a reader (of disks) has the request  --answer-timeout, then 503 is answered. If the client has
//                                        left (its socket is reset), nothing is waited for.
//   the answer is sent                   --answer-timeout for 64 KiB, and for the whole answer,
//                                        each plus the time that --slowest allows for these bytes
//   the end: further bytes are dropped   closePatience
//
// The socket's timer ends all states but the third. If that fails, the server's reaper ends the
// state. Operations of the socket keep the connection alive; a reader never does.
constexpr const char* otherHost = "this server does not serve that host: --allow-host adds it";

constexpr const char* noHost =
  "the request must have one Host, a name or an address, with a decimal port or none";

class HttpConnection
  : public Drainable
  , public std::enable_shared_from_this<HttpConnection>
{
public:
  HttpConnection(ClientSocket socket, ServerState& state, Admission admission)
    : Executor(socket.get_executor())
    , Socket(std::move(socket))
    , State(state)
    , Admitted(std::move(admission))
  {
    this->MarkIdle(patienceWithNew);
  }

  ~HttpConnection() override { this->State.Leave(this); }

  void Run()
  {
    this->State.Enter(this->shared_from_this());
    beast::error_code error;
    auto& socket = this->Socket.Tcp();
    socket.set_option(asio::ip::tcp::no_delay(true), error);
    asio::dispatch(this->Executor,
      [self = this->shared_from_this()]
      {
        self->Guard(
          [&]
          {
            self->Expire(self->State.Options.requestTimeout);
            self->Admitted.isIntroduced ? self->ReadIntroduction(std::make_shared<ProxyHeader>())
                                        : self->ShakeHands();
          });
      });
  }

  void Drain() override
  {
    asio::post(this->Executor,
      [self = this->shared_from_this()]
      {
        // Close the connection, unless it has become a WebSocket. A client that came too late for a
        // slot is still answered.
        if (!self->Answering && self->Admitted.slot.ofAll)
        {
          self->Socket.Close();
        }
      });
  }

  void GiveUp() override
  {
    asio::post(this->Executor,
      [self = this->shared_from_this()]
      {
        if (!self->Answering)
        {
          self->Socket.Close();
        }
        else if (self->StopWaiting)
        {
          self->StopWaiting();
        }
      });
  }

  void EndIfOverdue() override
  {
    asio::post(this->Executor,
      [self = this->shared_from_this()]
      {
        if (Clock::now() >= self->End())
        {
          self->Guard([&] { self->StopWaiting ? self->StopWaiting() : self->Socket.Close(); });
        }
      });
  }

private:
  static constexpr std::size_t bytesAtOnce = 65536; // of an answer's body, for each write
  static constexpr std::chrono::milliseconds closePatience{ 2000 };
  // How long a client may take for its first request before its slot may be taken back.
  static constexpr std::chrono::seconds patienceWithNew{ 5 };
  // How long a client may wait for a disk before its slot may be taken back.
  static constexpr std::chrono::seconds patienceWithDisk{ 2 };

  // Runs the work of a handler. An exception ends this connection.
  template <class Work>
  void Guard(const Work& work) noexcept
  {
    this->State.Guard(work, [this] { this->Socket.Close(); });
  }

  // Sets the time by which the state that begins now must end.
  void Expire(std::chrono::milliseconds time)
  {
    this->Socket.ExpireAfter(time);
    this->EndBy(Clock::now() + time);
  }

  // Reads the header in which a proxy names its client. While the header's length is unknown, it is
  // read byte by byte, because the bytes after it belong to TLS or HTTP.
  void ReadIntroduction(const std::shared_ptr<ProxyHeader>& header)
  {
    const auto space = header->Space();
    if (!space.empty())
    {
      this->Socket.ReadPlain(asio::buffer(space.data(), space.size()),
        [self = this->shared_from_this(), header](beast::error_code error, std::size_t)
        {
          if (!error)
          {
            self->Guard(
              [&]
              {
                header->Take();
                self->ReadIntroduction(header);
              });
          }
        });
      return;
    }
    if (header->IsMalformed())
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Proxy);
      this->Socket.Close();
      return;
    }
    this->Meet(header->Client());
    this->ShakeHands();
  }

  // Sets the client that the proxy has named; "": the proxy itself, because it names no client.
  void Meet(const std::string& address)
  {
    auto& client = this->Admitted.client;
    client.peer = client.address = address.empty() ? client.peer : PlainAddress(address);
    client.proxied = !address.empty() && this->State.Proxies.Holds(client.peer);
    if (!client.proxied && this->Admitted.refusedWith == 0)
    {
      this->Admitted.slot.ofAddress = this->State.Clients.TakeSlot(client.address);
      if (!this->Admitted.slot.ofAddress)
      {
        this->State.Counters.CountRefusal(Metrics::Reason::Address);
        this->Admitted.refusedWith = 429;
      }
    }
  }

  void ShakeHands()
  {
    this->Socket.Handshake(
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (error == asio::error::connection_aborted || error == beast::error::timeout)
        {
          self->State.Counters.CountRefusal(Metrics::Reason::Handshake);
        }
        else if (!error)
        {
          self->Guard([&] { self->Read(); });
        }
      });
  }

  void Read()
  {
    this->Answering = false;
    this->Input.Begin();
    this->Expire(this->State.Options.requestTimeout);
    this->Parse();
  }

  // Continues with the request in the bytes that have arrived so far.
  void Parse()
  {
    if (const auto ended = this->Input.Parse())
    {
      this->OnRead(*ended);
      return;
    }
    this->Socket.async_read_some(this->Input.Prepare(),
      [self = this->shared_from_this()](beast::error_code error, std::size_t bytes)
      {
        self->Input.Commit(bytes);
        self->Guard([&] { error ? self->OnRead(error) : self->Parse(); });
      });
  }

  void OnRead(beast::error_code error)
  {
    namespace http = beast::http;
    this->Answering = true;
    this->SetBusy();
    this->Began = Clock::now();
    const bool isBegun = this->Input.IsBegun();
    if (error == asio::error::eof && !isBegun)
    {
      this->Close();
    }
    else if (error == asio::error::eof)
    {
      this->Refuse(400, "the request ends inside its header");
    }
    else if (error == http::error::header_limit || error == http::error::buffer_overflow)
    {
      this->Refuse(431, "the request's header is larger than " +
                          std::to_string(this->State.Options.headerBytes) + " bytes");
    }
    else if (error == http::error::body_limit || error == http::error::unexpected_body)
    {
      this->Refuse(413, "requests with a body are not accepted");
    }
    else if (error.category() == make_error_code(http::error::bad_method).category())
    {
      this->Refuse(400, "the request is not HTTP: " + error.message());
    }
    else if (!error)
    {
      this->OnRequest();
    }
    // The client has left, or has taken too long: no answer can be sent.
    else if (isBegun && !this->Admitted.isAdmin)
    {
      this->Answer = {};
      this->Answer.status = error == beast::error::timeout ? 408 : 400;
      this->Record(error);
    }
  }

  void OnRequest()
  {
    const auto& request = this->Input.Request();
    const auto target = this->Target();
    const bool probes = Routes::IsProbe(target.path);
    const bool draining = this->State.Draining();
    const bool isAdmin = this->Admitted.isAdmin;
    if (!isAdmin && draining && !probes)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Stopping);
      this->Refuse(503, "the server is stopping");
    }
    else if (!isAdmin && this->Admitted.refusedWith != 0 && !draining)
    {
      this->Refuse(this->Admitted.refusedWith, this->Admitted.refusedWith == 503
                                                 ? "the server has too many connections"
                                                 : "this address has too many connections");
    }
    else if (!this->NamesOneHost(target))
    {
      this->Refuse(400, noHost);
    }
    else if (!probes && !this->MayNameHost(target))
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Host);
      this->Refuse(421, otherHost);
    }
    else if (isAdmin)
    {
      this->Send(this->State.Answers.AnswerAdmin(this->Plain()), request.keep_alive());
    }
    else if (const auto wait = this->TakeRequest(); wait.count() > 0)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Requests);
      auto response = this->State.Answers.Failure(429, TooManyRequests(wait), wait);
      response.omitBody = request.method() == beast::http::verb::head;
      this->Send(std::move(response), request.keep_alive());
    }
    else if (beast::websocket::is_upgrade(request))
    {
      this->Upgrade();
    }
    else
    {
      this->Respond();
    }
  }

  RequestTarget Target() const
  {
    const auto target = this->Input.Request().target();
    return SplitTarget({ target.data(), target.size() });
  }

  // Identifies the client, and returns the time after which it may ask; 0: now.
  std::chrono::seconds TakeRequest()
  {
    auto& client = this->Admitted.client;
    if (client.proxied)
    {
      client.address = this->State.Proxies.ClientOf(client.peer, this->Joined("X-Forwarded-For"));
    }
    return this->State.Clients.TakeRequest(client.address);
  }

  std::string_view HostField() const
  {
    const auto field = this->Input.Request()[beast::http::field::host];
    return { field.data(), field.size() };
  }

  // Whether the request names its host in a form that allows only one interpretation (RFC 9112,
  // 3.2). HTTP/1.0 has no field for the host.
  bool NamesOneHost(const RequestTarget& target) const
  {
    const auto& request = this->Input.Request();
    const auto fields = request.count(beast::http::field::host);
    return (fields == 1 || (fields == 0 && request.version() < 11)) &&
           ParseHost(this->HostField()) && (!target.host || ParseHost(*target.host));
  }

  // Whether the host is one of those that --allow-host names.
  bool IsListed(std::string_view host) const
  {
    const auto& allowed = this->State.Options.allowedHosts;
    return std::any_of(allowed.begin(), allowed.end(),
      [&](const std::string& name)
      {
        const auto known = ParseHost(name).value_or(name);
        return beast::iequals(beast::string_view(known.data(), known.size()),
          beast::string_view(host.data(), host.size()));
      });
  }

  // The address under which the client has come, which pages of models name. "" unless the host is
  // listed, because nobody else may choose the address on these pages. REQUIRES:
  // NamesOneHost(target).
  std::string PublicAddress(const RequestTarget& target) const
  {
    const auto& state = this->State;
    const auto field = target.host ? std::string_view(*target.host) : this->HostField();
    if (!state.Options.publicAddress.empty() || !this->IsListed(*ParseHost(field)))
    {
      return state.Options.publicAddress;
    }
    const bool isSecure = state.IsTls() || (this->Admitted.client.proxied &&
                                             this->Joined("X-Forwarded-Proto") == "https");
    return (isSecure ? "https://" : "http://") + std::string(field) + "/";
  }

  // Whether the client may name this host. In DNS rebinding, a page's own name resolves to this
  // address, and the page's requests name the page's host. A server that listens only for this
  // machine is addressed by IP addresses, names of localhost, and names that strangers cannot have.
  // With TLS, browsers compare the name with the certificate's. REQUIRES: NamesOneHost(target).
  bool MayNameHost(const RequestTarget& target) const
  {
    const auto& state = this->State;
    const auto& allowed = state.Options.allowedHosts;
    const bool isAdmin = this->Admitted.isAdmin;
    const auto named = *ParseHost(target.host ? *target.host : this->HostField());
    const bool namesNone =
      !target.host && this->Input.Request().count(beast::http::field::host) == 0;
    const bool takesAny =
      allowed.empty() && (isAdmin ? !state.isAdminLocal : !state.isLocal || state.IsTls());
    return this->IsListed(named) || takesAny ||
           ((isAdmin || allowed.empty()) && (namesNone || CannotBeRebound(named)));
  }

  // Answers at once if no disk is needed, and passes other requests to the readers.
  void Respond()
  {
    std::optional<Routes::Reading> reading;
    const auto find = [&]() -> std::optional<HttpResponse>
    {
      auto found = this->State.Answers.Find(this->Plain());
      if (auto* response = std::get_if<HttpResponse>(&found))
      {
        return std::move(*response);
      }
      reading = std::get<Routes::Reading>(std::move(found));
      return std::nullopt;
    };
    if (auto response = this->State.Caught(find))
    {
      this->Send(std::move(*response), this->Input.Request().keep_alive());
      return;
    }
    this->SetIdle(patienceWithDisk); // other clients need the slot more than this one
    this->AwaitReader();
    this->AskReader(std::make_shared<const Routes::Reading>(std::move(*reading)));
  }

  // If the answer might not count against a quota, first asks a reader that does not wait for
  // quotas.
  void AskReader(std::shared_ptr<const Routes::Reading> reading, bool isTried = false)
  {
    auto& state = this->State;
    const auto found = std::make_shared<std::optional<HttpResponse>>();
    const bool isTrial = reading->counts == Routes::Counts::Perhaps && !isTried;
    const bool takes = reading->counts == Routes::Counts::Yes || isTried;
    this->StopWaiting = MakeRoundTrip(
      this->Executor,
      [&](WorkerPool::Work work, WorkerPool::Work giveUp)
      {
        state.Read(takes, { std::move(work), std::move(giveUp), reading->source, reading->part },
          reading->isMade);
      },
      [&state, found, isTrial, reading]
      {
        const auto answer = [&]
        { return isTrial ? reading->Uncounted() : std::optional(reading->Answer()); };
        state.Guard([&] { *found = state.Caught(answer); }, [] {});
      },
      [weak = this->weak_from_this(), found, isTrial, reading](bool isDone)
      {
        const auto self = weak.lock();
        if (!self || !self->StopWaiting) // the client has left
        {
          return;
        }
        self->Guard(
          [&]
          {
            if (isTrial && isDone && !*found) // the request counts against a quota
            {
              self->AskReader(reading, true);
            }
            else
            {
              self->OnAnswer(isDone ? std::move(*found) : std::nullopt, isDone, reading->isMade);
            }
          });
      });
  }

  // Waits for the client to leave. While a reader has the request, only this wait keeps the
  // connection alive.
  void AwaitReader()
  {
    this->Socket.ExpireNever();
    this->EndBy(Clock::now() + this->State.Options.answerTimeout);
    this->Socket.Tcp().async_wait(asio::socket_base::wait_error,
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (!error && self->StopWaiting)
        {
          self->StopWaiting = {};
          self->Answer = {};
          self->Answer.status = 400;
          self->Guard([&] { self->Record(asio::error::connection_reset); });
          self->Socket.Close();
        }
      });
  }

  void OnAnswer(std::optional<HttpResponse> answer, bool isDone, bool isMade)
  {
    this->SetBusy();
    this->StopWaiting = {};
    this->Socket.Tcp().cancel();
    if (!isDone && isMade)
    {
      this->Refuse(503, "this takes long to make: try again");
    }
    else if (!isDone)
    {
      this->State.CountGivenUp();
      this->Refuse(503, "the disk does not respond: try again");
    }
    else if (answer)
    {
      this->Send(std::move(*answer), this->Input.Request().keep_alive());
    }
    else // no memory even for the error's answer
    {
      this->Socket.Close();
    }
  }

  std::string Joined(beast::string_view name) const
  {
    return JoinedFields(this->Input.Request(), name);
  }
  HttpRequest Plain() const
  {
    auto request = PlainRequest(this->Input.Request(), this->Admitted.client.address);
    request.root = this->PublicAddress(this->Target());
    return request;
  }

  // Answers with an error and closes the connection.
  void Refuse(unsigned status, const std::string& message)
  {
    auto response = this->State.Answers.Failure(status, message);
    response.omitBody = this->Input.Request().method() == beast::http::verb::head;
    this->Send(std::move(response), false);
  }

  void Upgrade()
  {
    namespace http = beast::http;
    const auto& request = this->Input.Request();
    const auto text = [&](http::field name)
    {
      const auto value = request[name];
      return std::string(value.data(), value.size());
    };
    const auto target = this->Plain().target;
    if (target.substr(0, target.find('?')) != protocol::streamPath)
    {
      this->Refuse(404, "there is no WebSocket at this path");
      return;
    }
    if (!http::token_list(text(http::field::sec_websocket_protocol))
           .exists(std::string(protocol::streamSubprotocol)))
    {
      this->Refuse(400, "the WebSocket's subprotocol must be kdstream.v2");
      return;
    }
    if (!this->State.Answers.MayStream(text(http::field::origin), text(http::field::host)))
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Origin);
      this->Refuse(403, "pages from this origin may not open a stream");
      return;
    }
    auto permission = this->State.Answers.Admit(this->Admitted.client.address,
      text(http::field::authorization), this->Joined("Sec-WebSocket-Protocol"));
    if (!permission)
    {
      this->Send(this->State.Answers.Forbidden({ 401, permission.GetError().message }), false);
      return;
    }
    const auto key = text(http::field::sec_websocket_key);
    if (text(http::field::sec_websocket_version) != "13")
    {
      auto response = this->State.Answers.Failure(426, "the WebSocket's version must be 13");
      response.fields.emplace_back("Sec-WebSocket-Version", "13");
      this->Send(std::move(response), false);
      return;
    }
    if (!IsWebSocketKey(key))
    {
      this->Refuse(400, "Sec-WebSocket-Key must be 16 bytes in base64");
      return;
    }
    if (this->Input.HasMore())
    {
      this->Refuse(400, "the client sent data before the WebSocket was open");
      return;
    }
    auto& slot = this->Admitted.slot;
    const auto& client = this->Admitted.client;
    if (client.proxied && !slot.ofAddress)
    {
      slot.ofAddress = this->State.Clients.TakeSlot(client.address);
    }
    if (!slot.ofAddress)
    {
      this->State.Counters.CountRefusal(Metrics::Reason::Address);
      this->Refuse(429, "this address has too many streams");
      return;
    }
    ServeStream(std::move(this->Socket), this->State, std::move(slot), std::move(*permission),
      AccessRecord{ client.address, "STREAM", target, 101, 0, 0 }, key);
  }

  void Send(HttpResponse response, bool keepAlive)
  {
    this->Answer = std::move(response);
    this->KeepAlive = keepAlive && !this->State.Draining();
    const bool isSecured = this->State.IsTls() && !this->Admitted.isAdmin;
    this->Head = WriteResponseHead(this->Answer, this->Input.Request().version() == 10,
      this->KeepAlive, isSecured ? this->State.Options.strictTransport : std::chrono::seconds(0));
    const bool hasBody = this->Answer.body && !this->Answer.omitBody;
    this->BodyBytes = hasBody ? this->Answer.length : 0;
    this->BodySent = 0;
    this->Written = 0;
    this->TakenBy = Clock::now() + this->State.PatienceFor(this->BodyBytes);
    this->SendPart(asio::const_buffer(this->Head.data(), this->Head.size()));
  }

  // Sends `before` and the next part of the body. Each part has a timeout of its own: a client that
  // reads nothing at all is dropped earlier than a large answer may take.
  void SendPart(asio::const_buffer before)
  {
    const auto bytes = std::min(this->BodyBytes - this->BodySent, bytesAtOnce);
    const auto* part =
      bytes == 0 ? nullptr : this->Answer.body->data() + this->Answer.begin + this->BodySent;
    this->BodySent += bytes;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(this->TakenBy - Clock::now());
    this->Expire(std::clamp(left, {}, this->State.PatienceFor(bytes)));
    asio::async_write(
      this->Socket, std::array{ before, asio::const_buffer(part, bytes) },
      [](beast::error_code error, std::size_t) // decides how much to write at once
      { return error ? 0 : std::numeric_limits<std::size_t>::max(); },
      [self = this->shared_from_this()](beast::error_code error, std::size_t written)
      {
        self->Written += written;
        const bool goesOn = !error && self->BodySent < self->BodyBytes;
        self->Guard([&] { goesOn ? self->SendPart({}) : self->OnSent(error); });
      });
  }

  void OnSent(beast::error_code error)
  {
    const bool goesOn = !error && this->KeepAlive && !this->State.Draining();
    if (goesOn)
    {
      this->MarkIdle({}); // before counting: who sees the count must find it idle
    }
    if (!this->Admitted.isAdmin)
    {
      this->Record(error);
    }
    this->Answer = {};
    if (goesOn)
    {
      this->Read();
    }
    else if (!error)
    {
      this->Close();
    }
  }

  // Records the answer in the metrics and in the log.
  void Record(beast::error_code error)
  {
    const auto& request = this->Input.Request();
    const auto sent = this->Written - std::min(this->Written, this->Head.size());
    const auto time = Clock::now() - this->Began;
    auto& counters = this->State.Counters;
    counters.CountRequest(this->Answer.status);
    counters.CountAnswer(time);
    counters.CountBytes(sent);
    if (error == beast::error::timeout)
    {
      counters.CountRefusal(Metrics::Reason::Slow);
    }
    if (!this->State.Options.onAccess)
    {
      return;
    }
    const auto known = [](beast::string_view text) // an incomplete request may lack it
    { return text.empty() ? std::string("-") : std::string(text.data(), text.size()); };
    this->State.Log(
      { this->Admitted.client.address, known(request.method_string()), known(request.target()),
        this->Answer.status, sent, std::chrono::duration<double>(time).count() });
  }

  // If the connection has a slot, the slot may be taken back after `before`.
  void MarkIdle(Clock::duration before)
  {
    if (this->Admitted.slot.ofAll)
    {
      this->SetIdle(before);
    }
  }

  // Sends nothing more, and for a moment reads the bytes that the client still sends: if the socket
  // were closed with unread bytes, the kernel would discard an answer that is still in flight.
  void Close()
  {
    this->Expire(std::min(closePatience, this->State.PatienceFor(0)));
    this->Socket.EndOutput(
      [self = this->shared_from_this()](beast::error_code error)
      {
        if (!error)
        {
          self->Guard([&] { self->DiscardInput(); });
        }
      });
  }

  void DiscardInput()
  {
    this->Socket.async_read_some(asio::buffer(this->Discarded),
      [self = this->shared_from_this()](beast::error_code error, std::size_t)
      {
        // The socket's timer does not end this, because it is not checked while there is always
        // something to read.
        if (!error && Clock::now() < self->End())
        {
          self->Guard([&] { self->DiscardInput(); });
        }
      });
  }

  // A copy of the socket's executor, because Socket is moved away when the connection becomes a
  // WebSocket.
  ClientSocket::executor_type Executor;
  ClientSocket Socket;
  ServerState& State;
  Admission Admitted;
  RequestInput Input{ this->State.Options.headerBytes };
  HttpResponse Answer;
  std::string Head;                        // the answer's bytes before the body
  std::size_t BodyBytes = 0, BodySent = 0; // BodySent: sent, or being sent
  std::size_t Written = 0;                 // bytes of the answer, including its head
  Clock::time_point TakenBy;               // by then the client must have taken the whole answer
  bool KeepAlive = false;
  std::array<char, 4096> Discarded{};
  Clock::time_point Began;
  bool Answering = false;
  std::function<void()> StopWaiting; // stops waiting for a disk; empty: not waiting
};

}

void ServeHttp(ClientSocket socket, ServerState& state, Admission admission)
{
  std::make_shared<HttpConnection>(std::move(socket), state, std::move(admission))->Run();
}

}
