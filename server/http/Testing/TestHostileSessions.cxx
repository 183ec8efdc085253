// SPDX-License-Identifier: BSD-3-Clause
// Random sessions of clients that do anything: WebSocket, HTTP, TLS and a proxy's header; correct,
// wrong, cut off anywhere, ended in any way or not at all. Whatever they do, no slot is lost, and
// later clients are served.
//
// KDSTREAM_HOSTILE_SESSIONS: the number of sessions (600); KDSTREAM_HOSTILE_SEED: their seed (34).
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/Testing/ClientFrames.h"
#include "server/http/Testing/RawSocket.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/ServerTest.h"

#include <openssl/ssl.h>

#include <atomic>
#include <cstdlib>
#include <iostream>
#include <random>

using namespace kdstream;

namespace
{

using namespace std::chrono_literals;

long FromEnvironment(const char* name, long otherwise)
{
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::atol(text);
}

class RandomGenerator
{
public:
  explicit RandomGenerator(unsigned seed)
    : Random(seed)
    , Messages(seed)
  {
  }
  unsigned UpTo(unsigned most)
  {
    return std::uniform_int_distribution<unsigned>(0, most)(this->Random);
  }
  bool OneIn(unsigned n) { return this->UpTo(n - 1) == 0; }
  std::string Bytes(unsigned most)
  {
    std::string bytes(this->UpTo(most), '\0');
    for (auto& byte : bytes)
    {
      byte = static_cast<char>(this->UpTo(255));
    }
    return bytes;
  }
  std::string Mutated(const std::string& bytes)
  {
    return bytes.empty() ? bytes : this->Messages.Mutated(bytes);
  }
  std::string Message() { return protocol::WriteClientMessage(this->Messages.FromClient()); }
  std::uint32_t Word() { return static_cast<std::uint32_t>(this->Random()); }

private:
  std::mt19937 Random;
  protocol::RandomMessages Messages;
};

// Carries a session's bytes, by TCP or by TLS over it.
class Carrier
{
public:
  Carrier(RawSocket& socket, RandomGenerator& generator)
    : Socket(socket)
    , Random(generator)
  {
  }
  ~Carrier()
  {
    SSL_free(this->Tls);
    SSL_CTX_free(this->Context);
  }
  Carrier(const Carrier&) = delete;
  Carrier& operator=(const Carrier&) = delete;

  // Sends the bytes in one piece, or in several.
  void Send(const std::string& bytes)
  {
    if (this->Tls == nullptr)
    {
      this->SendPlain(bytes);
    }
    else if (!bytes.empty())
    {
      SSL_write(this->Tls, bytes.data(), static_cast<int>(bytes.size()));
      this->SendPlain(this->Damaged(this->TakeOutput()));
    }
  }

  std::string Receive(std::chrono::milliseconds time)
  {
    auto bytes = this->Socket.Receive(time);
    if (this->Tls == nullptr)
    {
      return bytes;
    }
    BIO_write(SSL_get_rbio(this->Tls), bytes.data(), static_cast<int>(bytes.size()));
    std::string plain(65536, '\0');
    const int got = SSL_read(this->Tls, plain.data(), static_cast<int>(plain.size()));
    plain.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    this->SendPlain(this->TakeOutput());
    return plain;
  }

  bool ReceiveUntil(std::string_view end, std::chrono::milliseconds time = 2000ms)
  {
    const auto until = std::chrono::steady_clock::now() + time;
    std::string received;
    while (received.find(end) == std::string::npos)
    {
      if (this->Socket.HasEnded() || std::chrono::steady_clock::now() >= until)
      {
        return false;
      }
      received += this->Receive(50ms);
    }
    return true;
  }

  // A handshake in which the client may misbehave at any stage. Returns whether it has been
  // completed.
  bool ShakeHands()
  {
    this->Context = SSL_CTX_new(TLS_client_method());
    if (this->Random.OneIn(3)) // a version that has renegotiation
    {
      SSL_CTX_set_max_proto_version(this->Context, TLS1_2_VERSION);
    }
    this->Tls = SSL_new(this->Context);
    SSL_set_bio(this->Tls, BIO_new(BIO_s_mem()), BIO_new(BIO_s_mem()));
    SSL_set_connect_state(this->Tls);
    const bool isFalse = this->Random.OneIn(5);
    for (int round = 0; round < 10; ++round)
    {
      const int done = SSL_do_handshake(this->Tls);
      auto output = this->TakeOutput();
      if (isFalse && this->Random.OneIn(2))
      {
        this->SendPlain(this->Random.OneIn(2) ? output.substr(0, this->Random.UpTo(200))
                                              : this->Random.Mutated(output));
        return false;
      }
      this->SendPlain(output);
      if (done == 1)
      {
        return true;
      }
      const auto input = this->Socket.Receive(2000ms);
      if (input.empty())
      {
        return false;
      }
      BIO_write(SSL_get_rbio(this->Tls), input.data(), static_cast<int>(input.size()));
    }
    return false;
  }

  // Misbehaves in ways that only TLS allows.
  void Misbehave()
  {
    if (this->Tls == nullptr || !this->Random.OneIn(4))
    {
      return;
    }
    switch (this->Random.UpTo(5))
    {
      case 0:
        SSL_shutdown(this->Tls); // but the session continues
        break;
      case 1:
        SSL_renegotiate(this->Tls);
        SSL_do_handshake(this->Tls);
        break;
      case 2:
        for (int i = 0; i < 40; ++i)
        {
          SSL_key_update(this->Tls, SSL_KEY_UPDATE_REQUESTED);
          SSL_do_handshake(this->Tls);
        }
        break;
      case 3:
        this->SendPlain(std::string("\x15\x03\x03\x00\x02\x02\x28", 7)); // an alert
        break;
      case 4:
        this->SendPlain(std::string("\x17\x03\x03\x40\x00", 5) + this->Random.Bytes(200));
        break;
      default:
        this->SendPlain(this->Random.Bytes(100));
    }
    this->SendPlain(this->TakeOutput());
  }

  void SendPlain(const std::string& bytes)
  {
    std::string_view left = bytes;
    // Sometimes byte by byte, or in small pieces; after 200 pieces, the rest at once.
    const unsigned most = this->Random.OneIn(8) ? 1 : this->Random.OneIn(3) ? 40 : 1u << 20;
    for (int pieces = 0; !left.empty(); ++pieces)
    {
      const auto count = std::min<std::size_t>(
        left.size(), pieces > 200 ? left.size() : 1 + this->Random.UpTo(most - 1));
      if (!this->Socket.Send(left.substr(0, count), 100ms))
      {
        return;
      }
      left.remove_prefix(count);
    }
  }

private:
  std::string TakeOutput()
  {
    BIO* output = SSL_get_wbio(this->Tls);
    std::string bytes(BIO_ctrl_pending(output), '\0');
    BIO_read(output, bytes.data(), static_cast<int>(bytes.size()));
    return bytes;
  }
  std::string Damaged(std::string bytes)
  {
    if (this->Random.OneIn(30))
    {
      bytes = this->Random.Mutated(bytes);
    }
    else if (this->Random.OneIn(30))
    {
      bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), 1 + this->Random.UpTo(30)));
    }
    return bytes;
  }

  RawSocket& Socket;
  RandomGenerator& Random;
  SSL_CTX* Context = nullptr;
  SSL* Tls = nullptr;
};

class Session
{
public:
  Session(RawSocket& socket, RandomGenerator& generator, std::string blob)
    : Below(socket, generator)
    , Random(generator)
    , Blob(std::move(blob))
  {
  }

  // Sends a header of the PROXY protocol.
  void Introduce()
  {
    std::string header = "PROXY TCP4 10." + std::to_string(this->Random.UpTo(255)) + ".0." +
                         std::to_string(this->Random.UpTo(255)) + " 10.0.0.1 4000 443\r\n";
    switch (this->Random.UpTo(7))
    {
      case 0:
        header = "PROXY UNKNOWN\r\n";
        break;
      case 1:
      case 2:
        header = std::string("\r\n\r\n\0\r\nQUIT\n\x21\x11\0\x0c", 16) + this->Random.Bytes(3);
        header.resize(28, '\1');
        break;
      case 3:
        header = this->Random.Mutated(header);
        break;
      case 4:
        header = std::string("\r\n\r\n\0\r\nQUIT\n\x21\x11\xff\xff", 16) + this->Random.Bytes(300);
        break;
      case 5:
        header.resize(this->Random.UpTo(static_cast<unsigned>(header.size())));
        break;
      default:
        break;
    }
    this->Below.SendPlain(header);
  }

  bool ShakeHands() { return this->Below.ShakeHands(); }

  void Run()
  {
    if (this->Random.UpTo(9) < 3)
    {
      this->SpeakHttp();
      return;
    }
    this->Below.Send(
      this->Random.OneIn(30) ? this->Random.Mutated(UpgradeRequest()) : UpgradeRequest());
    if (this->Random.OneIn(30) || !this->Below.ReceiveUntil("\r\n\r\n"))
    {
      return;
    }
    this->Below.Misbehave();
    for (unsigned n = this->Random.UpTo(3); n < 4; ++n)
    {
      this->SpeakWebSocket();
    }
    this->Below.Misbehave();
  }

private:
  std::string Get(const std::string& target)
  {
    return "GET " + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";
  }

  void SpeakHttp()
  {
    this->Below.Misbehave();
    std::string bytes;
    switch (this->Random.UpTo(11))
    {
      case 0: // pipelined requests
        for (unsigned n = this->Random.UpTo(20); n > 0; --n)
        {
          bytes += this->Get(this->Random.OneIn(2) ? this->Blob : "/api/models.json");
        }
        break;
      case 1:
        bytes = this->Random.Mutated(this->Get(this->Blob));
        break;
      case 2:
        bytes = this->Get("/healthz");
        bytes.resize(this->Random.UpTo(static_cast<unsigned>(bytes.size())));
        break;
      case 3:
        bytes =
          "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 99999\r\n\r\n" + this->Random.Bytes(5000);
        break;
      case 4:
        bytes = "GET / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\nff\r\n";
        break;
      case 5:
        bytes = this->Random.Bytes(2000);
        break;
      case 6:
        bytes = "GET / HTTP/1.1\r\nX: " + std::string(20000, 'x');
        break;
      case 7:
        bytes = UpgradeRequest() + TextFrame(this->Random.Message());
        break;
      case 8:
        bytes = "HEAD " + this->Blob + " HTTP/1.0\r\n\r\n" + this->Get("/");
        break;
      case 9: // many answers, few of which are read
        for (int n = 0; n < 60; ++n)
        {
          bytes += this->Get(this->Blob);
        }
        break;
      case 10:
        bytes = this->Get(this->Blob + "\r\nRange: bytes=1-") + this->Get("/metrics");
        break;
      default:
        break; // nothing at all
    }
    this->Below.Send(bytes);
    if (this->Random.OneIn(2))
    {
      this->Below.Receive(20ms);
    }
    if (this->Random.OneIn(4))
    {
      this->Below.Send(this->Random.Bytes(3000));
    }
  }

  void SpeakWebSocket()
  {
    ClientFrame frame{ 1, "{}" };
    frame.mask = this->Random.Word();
    switch (this->Random.UpTo(17))
    {
      case 0: // not JSON, then part of a message; then bytes that are not UTF-8
        this->Below.Send(TextFrame("[") + ClientFrame{ 1, "aa", true, 0, true, 0, 10, 0 }.Bytes());
        if (this->Random.OneIn(2))
        {
          this->Below.ReceiveUntil("\x88", 500ms);
        }
        this->Below.Send(std::string(8, '\xff'));
        return;
      case 1: // a long message in parts
        frame.isLast = false;
        for (unsigned n = this->Random.UpTo(30); n > 0; --n)
        {
          frame.payload = std::string(this->Random.UpTo(5000), ' ');
          this->Below.Send(frame.Bytes());
          frame.opcode = 0;
        }
        return;
      case 2:
        frame.opcode = 2;
        frame.payload = this->Random.Bytes(300);
        frame.isLast = this->Random.OneIn(2);
        break;
      case 3:
        frame.isMasked = false;
        break;
      case 4:
        frame.opcode = 8 + this->Random.UpTo(2);
        frame.payload = this->Random.Bytes(400);
        break;
      case 5:
        frame.opcode = 8 + this->Random.UpTo(2);
        frame.isLast = false;
        break;
      case 6:
        frame.reserved = this->Random.UpTo(7);
        frame.opcode = this->Random.UpTo(15);
        break;
      case 7:
        this->Below.Send(CloseFrame(this->Random.UpTo(6000), this->Random.Bytes(20)));
        return;
      case 8:
        this->Below.Send(ClientFrame{ 8, "x" }.Bytes());
        return;
      case 9:
        this->Below.Send(CloseFrame(1000) + this->Random.Bytes(20000));
        return;
      case 10: // pings; nobody reads their pongs
        frame.opcode = 9;
        frame.payload = std::string(125, 'p');
        for (int n = 0; n < 500; ++n)
        {
          frame.payload.front() = static_cast<char>(n);
          this->Below.Send(frame.Bytes());
        }
        return;
      case 11: // a large answer, little of which is read
        this->Below.Send(TextFrame(R"({"type":"open","request":1,"model":"dragon"})") +
                         TextFrame(R"({"type":"region","request":2,"node":1,"rings":3})"));
        this->Below.Receive(20ms);
        if (this->Random.OneIn(2))
        {
          this->Below.Send(this->Random.OneIn(2) ? TextFrame("[") : CloseFrame(1000));
        }
        return;
      case 12:
        frame.lengthBytes = this->Random.OneIn(2) ? 2 : 8;
        frame.length = this->Random.OneIn(2) ? std::uint64_t{ this->Random.Word() } << 32 : 5;
        break;
      case 13:
      case 14:
        frame.payload = this->Random.Mutated(this->Random.Message());
        break;
      case 15: // more requests than are allowed
        for (int n = 0; n < 100; ++n)
        {
          this->Below.Send(TextFrame(this->Random.OneIn(3) ? "{}" : this->Random.Message()));
        }
        return;
      case 16:
        this->Below.Send(this->Random.Bytes(1000));
        return;
      default:
        frame.payload = this->Random.Message();
    }
    auto bytes = frame.Bytes();
    if (this->Random.OneIn(4))
    {
      bytes.resize(this->Random.UpTo(static_cast<unsigned>(bytes.size())));
    }
    this->Below.Send(bytes);
  }

  Carrier Below;
  RandomGenerator& Random;
  std::string Blob;
};

// The ways in which a client leaves.
void Leave(RawSocket& socket, RandomGenerator& generator, std::vector<RawSocket>& left)
{
  switch (generator.UpTo(11))
  {
    case 0:
    case 1:
    case 2:
      socket.Reset();
      break;
    case 3:
    case 4:
      socket.EndOutput();
      socket.AwaitEnd(20ms);
      break;
    case 5:
      socket.AwaitEnd(20ms);
      break;
    case 6: // it does not leave; it may close its sending side
      if (left.size() < 20)
      {
        if (generator.OneIn(2))
        {
          socket.EndOutput();
        }
        left.push_back(std::move(socket));
      }
      break;
    default:
      break; // closes
  }
}

class HostileSessions : public ServerTest
{
protected:
  const fixtures::TemporaryFolder folder;

  void SetUp() override
  {
    this->model = this->catalog.Add("dragon", 2, 4, 200'000);
    this->options.maximumConnections = 150; // few, so that idle clients lose their slots, too
    this->options.requestTimeout = 700ms;
    this->options.answerTimeout = 700ms;
    this->options.streamTimeout = 1500ms;
    this->options.idleTimeout = 100ms;
    this->options.slowestBytes = 1u << 20;
    this->options.requestsOfAddress = 0;
    this->options.admin = ListenAddress{};
  }

  void Attack(bool isTls, bool isIntroduced)
  {
    const auto port = this->Start();
    const auto sessions = FromEnvironment("KDSTREAM_HOSTILE_SESSIONS", 600) / 4;
    const auto seed = FromEnvironment("KDSTREAM_HOSTILE_SEED", 34);
    const auto blob = this->Blob(protocol::BlobId::Partition(3));
    std::atomic<long> next{ 0 };
    constexpr unsigned clients = 8;
    std::vector<std::vector<RawSocket>> left(clients); // kept open until the server closes them
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < clients; ++t)
    {
      threads.emplace_back(
        [&, t]
        {
          for (long i = next++; i < sessions; i = next++)
          {
            RandomGenerator generator(static_cast<unsigned>(seed * 1'000'003 + i));
            RawSocket socket(port, generator.OneIn(3) ? 4096 : 0);
            {
              Session session(socket, generator, blob);
              if (isIntroduced)
              {
                session.Introduce();
              }
              if (!isTls || session.ShakeHands())
              {
                session.Run();
              }
            }
            Leave(socket, generator, left[t]);
          }
        });
    }
    for (auto& thread : threads)
    {
      thread.join();
    }
    EXPECT_TRUE(this->HasNobody());
    // Enough sessions get far enough to open a stream.
    const auto metrics = HttpTestClient(this->AdminPort()).Get("/metrics")->body;
    const std::string name = "\nkdstream_streams_total ";
    const auto streams = std::atol(metrics.c_str() + metrics.find(name) + name.size());
    EXPECT_GT(streams, sessions / 10);
    std::cout << sessions << " sessions, " << streams << " streams\n";
  }

  // Whether all slots become free in time; all limits above are shorter.
  bool HasNobody()
  {
    const auto until = std::chrono::steady_clock::now() + RawSocket::patience;
    while (std::chrono::steady_clock::now() < until)
    {
      HttpTestClient admin(this->AdminPort());
      if (this->MetricsHave("kdstream_connections 0\n", admin) &&
          this->MetricsHave("kdstream_streams 0\n", admin))
      {
        return true;
      }
      std::this_thread::sleep_for(20ms);
    }
    ADD_FAILURE() << HttpTestClient(this->AdminPort()).Get("/metrics")->body;
    return false;
  }

  // Checks that a well-behaved client gets everything that it asks for.
  void Serve()
  {
    StreamTestClient client(this->server->Port());
    ASSERT_TRUE(client.Open());
    client.Ask({ 1, protocol::OpenRequest{ "dragon" } });
    ASSERT_TRUE(client.Await(1).opened);
    client.Ask({ 2, protocol::RegionRequest{ 17, 1, {} } });
    EXPECT_TRUE(this->IsRegion(client.Await(2), 17, 1));
    client.Close();
  }
};

}

TEST_F(HostileSessions, OfWebSocketAndHttpKeepNoSlot)
{
  this->Attack(false, false);
  this->Serve();
  EXPECT_TRUE(this->HasNobody());
}

TEST_F(HostileSessions, OverTlsKeepNoSlot)
{
  WriteSelfSigned(this->folder / "cert.pem", this->folder / "key.pem");
  this->options.tlsCertificate = this->folder / "cert.pem";
  this->options.tlsKey = this->folder / "key.pem";
  this->Attack(true, false);
}

TEST_F(HostileSessions, ThroughAProxyKeepNoSlot)
{
  this->options.trustedProxies = { "127.0.0.1" };
  this->options.proxyProtocol = true;
  this->Attack(false, true);
}

TEST_F(HostileSessions, ThroughAProxyOverTlsKeepNoSlot)
{
  WriteSelfSigned(this->folder / "cert.pem", this->folder / "key.pem");
  this->options.tlsCertificate = this->folder / "cert.pem";
  this->options.tlsKey = this->folder / "key.pem";
  this->options.trustedProxies = { "127.0.0.1" };
  this->options.proxyProtocol = true;
  this->Attack(true, true);
}

// The server stops while hostile clients are connected, and they do not keep it from ending.
TEST_F(HostileSessions, DoNotKeepTheServerFromEnding)
{
  this->options.drainTimeout = 300ms;
  const auto port = this->Start();
  std::atomic<bool> done{ false };
  std::vector<RawSocket> left;
  std::thread attacking(
    [&]
    {
      for (unsigned i = 0; !done; ++i)
      {
        RandomGenerator generator(i);
        RawSocket socket(port);
        Session(socket, generator, "/").Run();
        Leave(socket, generator, left);
      }
    });
  std::this_thread::sleep_for(300ms);
  const auto begin = std::chrono::steady_clock::now();
  this->server->Stop();
  // Much more than the 300 ms: the machine may be busy.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 30s);
  done = true;
  attacking.join();
}
