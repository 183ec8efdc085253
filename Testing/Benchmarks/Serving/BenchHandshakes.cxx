// SPDX-License-Identifier: BSD-3-Clause
// How long connected clients wait while a crowd does full TLS handshakes, one after the other.
// Measured are a GET on an open connection, a cancel on an open stream, and the accept of a new
// connection (at the address of the metrics, which needs no TLS). Several builds of kdstream-serve
// take turns, for comparison. Each figure is also given as a ratio to the same figure without a
// crowd. At the end, the server's memory for an idle connection is measured. Usage:
//   BenchHandshakes STORES FOLDER SECONDS ROUNDS KDSTREAM-SERVE...
// STORES: a folder with dragon.kds. FOLDER: for certificates and logs. SECONDS: how long each crowd
// stays in each round.
#include "Testing/Benchmarks/Serving/ServerProcess.h"
#include "filters/protocol/ResourcePath.h"
#include "filters/store/Store.h"
#include "server/http/Testing/RawSocket.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/TlsTestClient.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::benchmarks;
using std::filesystem::path;
using Clock = std::chrono::steady_clock;
using Milliseconds = std::vector<double>;

constexpr std::size_t crowdSize = 16;
constexpr std::chrono::milliseconds pause{ 4 }; // between two requests of an observer

[[noreturn]] void Fail(const std::string& what)
{
  std::cerr << "BenchHandshakes: error: " << what << "\n";
  std::exit(1);
}

std::uint16_t FreePort()
{
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(listener, reinterpret_cast<const sockaddr*>(&address), size);
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(listener);
  return ntohs(address.sin_port);
}

struct Key
{
  const char* name;
  std::function<EVP_PKEY*()> make;
};

class Host
{
public:
  Host(const std::string& program, const path& stores, const path& folder)
    : Admin(FreePort())
    , Server(
        { program, stores, "--port", "0", "--admin", "127.0.0.1:" + std::to_string(this->Admin),
          "--tls-cert", folder / "cert.pem", "--tls-key", folder / "key.pem" },
        folder / "server.log")
    , Port(this->Server.ReadPort())
  {
  }

  struct Times
  {
    Milliseconds get, cancel, accept;
  };
  std::uint16_t Admin;
  ServerProcess Server;
  std::uint16_t Port;
  Times alone, crowded;
  std::size_t handshakes = 0;
  double idleKibibytes = 0;
};

// Does a full handshake, by a client that has no session to resume.
bool ShakeHands(SSL_CTX& context, std::uint16_t port)
{
  const std::unique_ptr<BIO, void (*)(BIO*)> plain(
    BIO_new_connect(("127.0.0.1:" + std::to_string(port)).c_str()), BIO_free_all);
  if (BIO_do_connect(plain.get()) != 1)
  {
    return false;
  }
  const std::unique_ptr<SSL, void (*)(SSL*)> session(SSL_new(&context), SSL_free);
  BIO_up_ref(plain.get());
  SSL_set_bio(session.get(), plain.get(), plain.get());
  return SSL_connect(session.get()) == 1;
}

// A masked text frame, with a mask of zeros.
std::string Frame(const std::string& text)
{
  return std::string("\x81", 1) + static_cast<char>(0x80 | text.size()) + std::string(4, '\0') +
         text;
}

double Since(Clock::time_point begin)
{
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// Calls `once` until `done`, and notes how long each call takes.
Milliseconds Observe(const std::atomic<bool>& done, const std::function<Clock::time_point()>& once)
{
  Milliseconds times;
  while (!done)
  {
    times.push_back(Since(once()));
    std::this_thread::sleep_for(pause);
  }
  return times;
}

// Fetches one blob repeatedly.
Milliseconds Gets(std::uint16_t port, const std::string& target, const std::atomic<bool>& done)
{
  TlsTestClient client(port);
  return Observe(done,
    [&]
    {
      const auto begin = Clock::now();
      client.Send("GET " + target + " HTTP/1.1\r\nHost: a\r\n\r\n");
      std::string answer = client.Receive("\r\n\r\n");
      const auto body = answer.find("\r\n\r\n") + 4;
      const std::string field = "Content-Length: ";
      const auto length = answer.find(field);
      if (!answer.starts_with("HTTP/1.1 200") || length == std::string::npos)
      {
        Fail("a GET was answered: " + answer);
      }
      const auto bytes =
        static_cast<std::size_t>(std::atol(answer.c_str() + length + field.size()));
      client.Receive(bytes - std::min(bytes, answer.size() - body));
      return begin;
    });
}

Milliseconds Cancels(std::uint16_t port, const std::atomic<bool>& done)
{
  TlsTestClient client(port);
  client.Send("GET /api/stream HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\n"
              "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
              "Sec-WebSocket-Protocol: kdstream.v2\r\n\r\n");
  client.Receive("\r\n\r\n");
  client.Send(Frame(R"({"type":"open","request":1,"model":"dragon"})"));
  client.Receive("\"opened\"");
  return Observe(done,
    [&]
    {
      client.Send(Frame(R"({"type":"region","request":2,"cell":9,"rings":3})"));
      client.Receive("\"begin\"");
      const auto begin = Clock::now();
      client.Send(Frame(R"({"type":"cancel","request":2})"));
      if (client.Receive("\"end\"").empty())
      {
        Fail("a cancel was not answered");
      }
      return begin;
    });
}

Milliseconds Accepts(std::uint16_t port, const std::atomic<bool>& done)
{
  return Observe(done,
    [&]
    {
      const auto begin = Clock::now();
      RawSocket client(port);
      client.Send("GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
      std::string answer;
      if (!client.ReceiveUntil("ok\n", answer, RawSocket::patience))
      {
        Fail("a new connection was not answered");
      }
      return begin;
    });
}

void Run(Host& host, const std::string& target, Host::Times& times, std::size_t crowd,
  std::chrono::duration<double> time)
{
  const std::unique_ptr<SSL_CTX, void (*)(SSL_CTX*)> context(
    SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  std::atomic<bool> done{ false };
  std::atomic<std::size_t> shaken{ 0 };
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < crowd; ++i)
  {
    threads.emplace_back(
      [&]
      {
        while (!done)
        {
          shaken += ShakeHands(*context, host.Port) ? 1U : 0U;
        }
      });
  }
  Host::Times seen;
  threads.emplace_back([&] { seen.get = Gets(host.Port, target, done); });
  threads.emplace_back([&] { seen.cancel = Cancels(host.Port, done); });
  threads.emplace_back([&] { seen.accept = Accepts(host.Admin, done); });
  std::this_thread::sleep_for(time);
  done = true;
  for (std::thread& thread : threads)
  {
    thread.join();
  }
  host.handshakes += shaken;
  const auto add = [](Milliseconds& to, Milliseconds& from)
  {
    if (from.size() > 1) // the first one includes the observer's own handshake
    {
      to.insert(to.end(), from.begin() + 1, from.end());
    }
  };
  add(times.get, seen.get);
  add(times.cancel, seen.cancel);
  add(times.accept, seen.accept);
}

// The server's memory for each connection that has made a request and is now idle.
double KibibytesOfIdleConnection(const Host& host)
{
  constexpr std::size_t count = 200;
  const double before = host.Server.ResidentMebibytes();
  std::vector<std::unique_ptr<TlsTestClient>> clients;
  for (std::size_t i = 0; i < count; ++i)
  {
    clients.push_back(std::make_unique<TlsTestClient>(host.Port));
    clients.back()->Send("GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n");
    if (clients.back()->Receive("ok\n").empty())
    {
      Fail("a connection of many was not answered");
    }
  }
  return (host.Server.ResidentMebibytes() - before) * 1024 / count;
}

double Quantile(Milliseconds times, double part)
{
  if (times.empty())
  {
    return 0;
  }
  const auto at = times.begin() + static_cast<std::ptrdiff_t>(part * double(times.size() - 1));
  std::nth_element(times.begin(), at, times.end());
  return *at;
}

void Print(const char* what, const Milliseconds& alone, const Milliseconds& crowded)
{
  const double before = Quantile(alone, 0.99), after = Quantile(crowded, 0.99);
  std::printf("    %-8s p50 %7.2f -> %7.2f ms, p99 %7.2f -> %7.2f ms (x %.1f), %zu and %zu\n", what,
    Quantile(alone, 0.5), Quantile(crowded, 0.5), before, after, after / before, alone.size(),
    crowded.size());
}

}

int main(int argc, char** argv)
{
  if (argc < 6)
  {
    std::cerr << "BenchHandshakes STORES FOLDER SECONDS ROUNDS KDSTREAM-SERVE...\n";
    return 2;
  }
  std::signal(SIGPIPE, SIG_IGN);
  const path stores = argv[1], folder = argv[2];
  const std::chrono::duration<double> time(std::atof(argv[3]));
  const int rounds = std::atoi(argv[4]);
  std::filesystem::create_directories(folder);
  const auto store = Store::Open(stores / "dragon.kds");
  if (!store)
  {
    Fail("dragon.kds: " + store.GetError().message);
  }
  const std::string target =
    protocol::BlobPath("dragon", (*store)->Info().digest, protocol::BlobId::Partition(0));
  const std::vector<Key> keys{ { "RSA 4096", [] { return EVP_RSA_gen(4096); } },
    { "RSA 2048", [] { return EVP_RSA_gen(2048); } },
    { "ECDSA P-256", [] { return EVP_EC_gen("P-256"); } } };
  for (const Key& key : keys)
  {
    const PrivateKey made(key.make(), EVP_PKEY_free);
    WriteCertificate(folder / "cert.pem", made.get(), "localhost");
    WriteKey(folder / "key.pem", made.get());
    std::vector<std::unique_ptr<Host>> hosts;
    for (int i = 5; i < argc; ++i)
    {
      hosts.push_back(std::make_unique<Host>(argv[i], stores, folder));
      hosts.back()->idleKibibytes = KibibytesOfIdleConnection(*hosts.back());
    }
    for (int round = 0; round < rounds; ++round)
    {
      for (const auto& host : hosts)
      {
        Run(*host, target, host->alone, 0, time / 2);
        Run(*host, target, host->crowded, crowdSize, time);
      }
    }
    std::printf("%s, %zu clients that do handshakes\n", key.name, crowdSize);
    for (std::size_t i = 0; i < hosts.size(); ++i)
    {
      const Host& host = *hosts[i];
      std::printf("  %s: %.0f handshakes/s, %.1f KiB an idle connection\n", argv[5 + i],
        double(host.handshakes) / (rounds * time.count()), host.idleKibibytes);
      Print("GET", host.alone.get, host.crowded.get);
      Print("cancel", host.alone.cancel, host.crowded.cancel);
      Print("accept", host.alone.accept, host.crowded.accept);
    }
    std::fflush(stdout);
  }
  return 0;
}
