// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/Serving/CrowdViewer.h"

#include "filters/codec/Seal.h"
#include "filters/protocol/ControlMessage.h"
#include "filters/protocol/ResourcePath.h"
#include "viewer/client/HttpFetch.h"
#include "viewer/client/StreamConversation.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/websocket/stream.hpp>

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

namespace kdstream::benchmarks
{

namespace
{

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using protocol::BlobId;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr std::size_t slowBytes = 16384; // for each second
// Longer than the server waits for a client that does not take 64 KiB.
constexpr std::chrono::seconds deafness{ 40 };

double SecondsOf(Clock::time_point time)
{
  return Seconds(time.time_since_epoch()).count();
}

}

class CrowdViewer::Mind : public std::enable_shared_from_this<Mind>
{
  using Socket = beast::basic_stream<tcp, asio::any_io_executor, beast::simple_rate_policy>;
  // One connection, with everything that its operations use while they last.
  struct Line
  {
    explicit Line(asio::io_context& context)
      : socket(context)
    {
    }
    websocket::stream<Socket, false> socket;
    websocket::response_type answer;
    beast::flat_buffer incoming;
    std::deque<std::string> outgoing;
    std::string sending;
    bool reading = false, writing = false;
  };

  // Wraps a handler: it is called only while this is still the viewer's connection.
  template <class Handler>
  auto OfLine(Handler handler)
  {
    return
      [self = this->shared_from_this(), line = this->Current, handler](error_code error, auto...)
    {
      if (self->Current == line)
      {
        handler(error);
      }
    };
  }

public:
  Mind(asio::io_context& context, const CrowdModel& model, std::uint16_t port, Manner manner,
    std::uint32_t seed, CrowdTally& tally)
    : Context(context)
    , Model(model)
    , Server(asio::ip::address_v4::loopback(), port)
    , Nature(manner)
    , Wishes(model, seed)
    , Tally(tally)
    , Timer(context)
    , Deafness(context)
  {
  }

  void Arrive()
  {
    this->Wanted = true;
    this->Stream = {};
    this->Tasks.clear();
    this->Wishes.Forget();
    this->Opened = this->Holding = false;
    this->Current = std::make_shared<Line>(this->Context);
    auto& stream = beast::get_lowest_layer(this->Current->socket);
    error_code error;
    stream.socket().open(tcp::v4(), error);
    if (this->Nature == Manner::Slow || this->Nature == Manner::Deaf)
    {
      stream.socket().set_option(asio::socket_base::receive_buffer_size(16384), error);
    }
    if (this->Nature == Manner::Slow)
    {
      stream.rate_policy().read_limit(slowBytes);
    }
    stream.async_connect(this->Server, this->OfLine([this](error_code failed)
                                         { failed ? this->TurnedAway(0) : this->Handshake(); }));
  }

  bool IsSettled() const { return this->Opened && this->Tasks.empty(); }

  void Roam(Seconds pause)
  {
    this->Pause = pause;
    if (this->IsSettled())
    {
      this->ActLater();
    }
  }

  void Hold(std::uint64_t partitions)
  {
    if (this->Nature == Manner::Slow)
    {
      return;
    }
    this->Holding = true;
    this->Ask(this->Wishes.FinestLevel());
    this->Ask(this->Wishes.Partitions(partitions));
  }

  void GoOn()
  {
    this->Holding = false;
    this->Read();
  }

  void Leave()
  {
    this->Wanted = false;
    this->Timer.cancel();
    this->Deafness.cancel();
    const auto line = this->Current;
    if (line && this->Opened && !this->Holding && !line->writing && this->Wishes.Below(2) == 0)
    {
      line->socket.async_close(websocket::close_code::going_away,
        [self = this->shared_from_this(), line](error_code) { self->Drop(line); });
      return;
    }
    this->Drop(line);
  }

private:
  struct Task // a request whose answer is incomplete
  {
    Clock::time_point asked;
    std::size_t outstanding = 0;
    bool isRegion = false, hasBegun = false;
    bool isMoot = false; // the view has changed: cancelled when a blob has arrived
  };

  void Drop(const std::shared_ptr<Line>& line)
  {
    if (line)
    {
      beast::get_lowest_layer(line->socket).close();
    }
    if (this->Current == line)
    {
      this->Current.reset();
      this->Opened = false;
      this->Tasks.clear();
    }
  }

  void Handshake()
  {
    websocket::stream_base::timeout timeout{ std::chrono::seconds(60),
      websocket::stream_base::none(), false };
    auto& socket = this->Current->socket;
    socket.set_option(timeout);
    socket.set_option(websocket::stream_base::decorator(
      [](websocket::request_type& request)
      {
        request.set(
          beast::http::field::sec_websocket_protocol, std::string(protocol::streamSubprotocol));
      }));
    socket.read_message_max(protocol::maximumServerMessageBytes);
    socket.async_handshake(this->Current->answer, "127.0.0.1", std::string(protocol::streamPath),
      this->OfLine(
        [this](error_code error)
        {
          if (error)
          {
            this->Refused(error == websocket::error::upgrade_declined);
            return;
          }
          this->Begin();
        }));
  }

  // reported: by an answer; otherwise the server only closed the connection.
  void Refused(bool reported)
  {
    const auto& answer = this->Current->answer;
    if (reported && !IsBusy(answer.result_int()))
    {
      this->Fail("the server says " + std::to_string(answer.result_int()));
    }
    const auto after = answer[beast::http::field::retry_after];
    this->TurnedAway(reported ? RetryAfterIn(std::string(after.data(), after.size())) : 0);
  }

  void Begin()
  {
    SessionRequest open;
    open.model = this->Model.description.id;
    this->Ask(std::move(open));
    this->Read();
  }

  // Connects again, as viewers do: after 1 to 3 times the delay that the server gave, or half a
  // second.
  void TurnedAway(double retryAfter)
  {
    ++this->Tally.refused;
    this->ComeBack(Seconds(std::max(retryAfter, 0.5) * this->Wishes.Uniform(1, 3)));
  }

  void ComeBack(Seconds pause)
  {
    this->Drop(this->Current);
    this->After(pause, [this] { this->Arrive(); });
  }

  template <class Work>
  void After(Seconds pause, Work work)
  {
    this->Timer.expires_after(std::chrono::duration_cast<Clock::duration>(pause));
    this->Timer.async_wait(
      [self = this->shared_from_this(), work](error_code error)
      {
        if (!error && self->Wanted)
        {
          work();
        }
      });
  }

  void Read()
  {
    const auto line = this->Current;
    if (!line || line->reading || this->Holding)
    {
      return;
    }
    line->reading = true;
    line->socket.async_read(line->incoming, this->OfLine(
                                              [this](error_code error)
                                              {
                                                this->Current->reading = false;
                                                error ? this->Ended() : this->Take();
                                                this->Read();
                                              }));
  }

  void Ended()
  {
    if (this->Nature == Manner::Deaf)
    {
      ++this->Tally.deafDropped;
    }
    else if (this->Wanted)
    {
      ++this->Tally.dropped;
    }
    this->Wanted ? this->ComeBack(Seconds(this->Wishes.Uniform(0.5, 1.5)))
                 : this->Drop(this->Current);
  }

  void Take()
  {
    const auto line = this->Current;
    if (!this->Wanted)
    {
      // The stream is closing. The message's content is not checked: Beast's flag for text may
      // belong to a later message, because a close also reads.
      line->incoming.clear();
      return;
    }
    const auto data = line->incoming.cdata();
    const auto* const bytes = static_cast<const std::uint8_t*>(data.data());
    const double now = SecondsOf(Clock::now());
    const Status status =
      line->socket.got_text()
        ? this->Stream.ReceiveText({ reinterpret_cast<const char*>(bytes), data.size() }, now)
        : this->Stream.ReceiveFrame({ bytes, data.size() }, now);
    line->incoming.consume(data.size());
    if (!status)
    {
      this->Fail(status.GetError().message);
      this->ComeBack(Seconds(1));
      return;
    }
    for (const ClientEvent& event : this->Stream.TakeEvents())
    {
      if (this->Current == line) // the viewer has not vanished meanwhile
      {
        this->Notice(event);
      }
    }
    this->Write();
  }

  void Notice(const ClientEvent& event)
  {
    switch (event.kind)
    {
      case ClientEvent::Kind::Opened:
        this->LookAtPreview();
        break;
      case ClientEvent::Kind::Blob:
        this->TakeBlob(event);
        break;
      case ClientEvent::Kind::BlobFailed:
      case ClientEvent::Kind::RequestFailed:
      case ClientEvent::Kind::RequestEnded:
        this->Fail("request failed: " + event.message);
        this->Tasks.erase(event.request);
        this->BecomeIdle();
        break;
      case ClientEvent::Kind::Notes: // not requested here
        break;
    }
  }

  void TakeBlob(const ClientEvent& event)
  {
    ++this->Tally.blobs;
    this->Tally.bytes += event.bytes.size();
    if (!IsSealed(event.bytes))
    {
      this->Fail(protocol::BlobName(event.blob) + " is damaged");
    }
    const auto found = this->Tasks.find(event.request);
    if (found == this->Tasks.end())
    {
      return; // belongs to a cancelled request
    }
    Task& task = found->second;
    const bool counts = task.isRegion && this->Nature == Manner::Eager && !task.isMoot;
    const auto since = std::chrono::duration<float>(Clock::now() - task.asked).count();
    if (!std::exchange(task.hasBegun, true))
    {
      if (counts)
      {
        this->Tally.firstBlobs.push_back(since);
      }
      if (task.isRegion && this->Nature == Manner::Vanishing)
      {
        ++this->Tally.vanished;
        this->ComeBack(Seconds(this->Wishes.Uniform(0.5, 1.5)));
        return;
      }
      if (task.isMoot)
      {
        this->Cancel(event.request);
        return;
      }
    }
    if (--task.outstanding == 0)
    {
      if (counts)
      {
        this->Tally.lastBlobs.push_back(since);
      }
      this->Tasks.erase(found);
      this->BecomeIdle();
    }
  }

  void Cancel(std::uint32_t request)
  {
    this->Tasks.erase(request);
    SessionRequest cancel;
    cancel.kind = SessionRequest::Kind::Cancel;
    cancel.id = request;
    this->Ask(std::move(cancel));
    this->BecomeIdle();
  }

  // The viewer has everything that it has requested.
  void BecomeIdle()
  {
    if (this->Tasks.empty() && this->Pause.count() > 0)
    {
      this->ActLater();
    }
  }

  // ---- the viewer's requests

  void LookAtPreview()
  {
    this->Opened = true;
    this->Ask(this->Wishes.Preview());
    this->Ask(this->Wishes.BrowseTree());
  }

  void ActLater()
  {
    this->After(Seconds(this->Wishes.Exponential(this->Pause.count())),
      [this] { this->Opened ? this->Act() : void(); });
  }

  void Act()
  {
    ++this->Tally.acts;
    const double what = this->Wishes.Uniform(0, 1);
    const bool isMoot = this->Wishes.Below(8) == 0;
    if (what < 0.6)
    {
      this->Ask(this->Wishes.Zoom(), isMoot);
    }
    else if (what < 0.85)
    {
      this->Ask(this->Wishes.Tap(), isMoot, true);
      this->Nature == Manner::Deaf ? this->GoDeaf() : void();
    }
    else
    {
      this->Ask(this->Wishes.BrowseTree());
    }
  }

  void GoDeaf()
  {
    this->Holding = true;
    this->Deafness.expires_after(deafness);
    this->Deafness.async_wait(
      [self = this->shared_from_this()](error_code error) { error ? void() : self->GoOn(); });
  }

  void Ask(SessionRequest request, bool isMoot = false, bool isRegion = false)
  {
    if (request.kind != SessionRequest::Kind::Cancel)
    {
      request.id = ++this->LastRequest;
    }
    if (!request.blobs.empty())
    {
      this->Tasks[request.id] = { Clock::now(), request.blobs.size(), isRegion, false, isMoot };
    }
    this->Stream.Send(request, SecondsOf(Clock::now()));
    this->Write();
  }

  void Write()
  {
    const auto line = this->Current;
    for (std::string& message : this->Stream.TakeMessages())
    {
      line ? line->outgoing.push_back(std::move(message)) : void();
    }
    if (!line || line->writing || line->outgoing.empty())
    {
      return;
    }
    line->writing = true;
    line->sending = std::move(line->outgoing.front());
    line->outgoing.pop_front();
    line->socket.text(true);
    line->socket.async_write(asio::buffer(line->sending),
      this->OfLine(
        [this](error_code error)
        {
          this->Current->writing = false;
          error ? void() : this->Write(); // the reader gets the error, too
        }));
  }

  void Fail(const std::string& what)
  {
    if (this->Tally.failures++ == 0)
    {
      this->Tally.firstFailure = what;
    }
  }

  asio::io_context& Context;
  const CrowdModel& Model;
  const tcp::endpoint Server;
  const Manner Nature;
  CrowdWishes Wishes;
  CrowdTally& Tally;
  asio::steady_timer Timer, Deafness;
  bool Wanted = false; // true from connecting until it leaves on purpose
  std::shared_ptr<Line> Current;
  StreamConversation Stream;
  std::map<std::uint32_t, Task> Tasks; // by request
  std::uint32_t LastRequest = 0;
  bool Opened = false, Holding = false;
  Seconds Pause{ 0 };
};

CrowdViewer::CrowdViewer(asio::io_context& context, const CrowdModel& model, std::uint16_t port,
  Manner manner, std::uint32_t seed, CrowdTally& tally)
  : Kept(std::make_shared<Mind>(context, model, port, manner, seed, tally))
{
}

CrowdViewer::~CrowdViewer() = default;
CrowdViewer::CrowdViewer(CrowdViewer&&) noexcept = default;

void CrowdViewer::Arrive()
{
  this->Kept->Arrive();
}

bool CrowdViewer::IsSettled() const
{
  return this->Kept->IsSettled();
}

void CrowdViewer::Roam(std::chrono::duration<double> pause)
{
  this->Kept->Roam(pause);
}

void CrowdViewer::Hold(std::uint64_t partitions)
{
  this->Kept->Hold(partitions);
}

void CrowdViewer::GoOn()
{
  this->Kept->GoOn();
}

void CrowdViewer::Leave()
{
  this->Kept->Leave();
}

}
