// SPDX-License-Identifier: BSD-3-Clause
// The server on one port: HTTP/1.1 routes and the WebSocket stream, with or without TLS. Step
// "serve" of the pipeline picture. This header hides Boost.
#pragma once

#include "filters/core/Result.h"
#include "server/access/TokenGuard.h"
#include "server/http/StaticFiles.h"
#include "server/session/Catalog.h"
#include "server/session/Conversation.h"
#include "server/session/PartitionLedger.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// One line of an access log: an answered request, or a stream that has ended.
struct AccessRecord
{
  std::string client; // address
  std::string method; // "GET"; "STREAM" for a stream's end
  std::string target; // as the client sent it: any bytes
  unsigned status = 0;
  std::uint64_t bytes = 0; // of the body, or of the stream's messages
  double seconds = 0;
};

struct ListenAddress
{
  std::string host = "127.0.0.1"; // an address, or a name that resolves to an address
  std::uint16_t port = 0;         // 0: any that is free
};

struct HttpServerOptions
{
  ListenAddress address;
  // The address for metrics, in plain HTTP, without connection slots or limits; they are then not
  // at `address`.
  std::optional<ListenAddress> admin;
  unsigned threads = 2; // of the event loop, at least 1
  unsigned readers = 8; // threads that wait for disks, at least 1
  // Threads that make tiles and pictures, and may wait for disks.
  unsigned Makers() const { return std::max(2u, this->readers / 2); }
  std::size_t maximumConnections = 1000;
  // Connections in addition to the maximum, which are answered that no slot is free; and
  // the same number for the admin address. Further ones are closed without an answer.
  std::size_t extraConnections = 64;
  // Limits of one address: connections at a time, and requests a minute, including messages of
  // streams. 0: no limit. Without a number: the defaults of ClientLimits, which do not apply to
  // this machine itself.
  std::optional<std::size_t> connectionsOfAddress, requestsOfAddress;
  // Addresses and networks of proxies, whose X-Forwarded-For is taken for the client's address.
  std::vector<std::string> trustedProxies;
  // Their connections begin with a header of the PROXY protocol, which names the client instead.
  bool proxyProtocol = false;
  // The hosts that requests may name (except requests for /healthz and /readyz). None: any host;
  // but if the server listens only at loopback without TLS, only hosts that CannotBeRebound
  // (RequestForm.h), as at `admin`.
  std::vector<std::string> allowedHosts;
  // The public address of "/" ("https://museum.example/3d/", IsPageRoot, with a slash at its end),
  // which pages of models name. Empty: that of a request whose host is one of allowedHosts, else
  // none.
  std::string publicAddress;
  std::size_t headerBytes = 8192; // most bytes of a request's header; bodies are not allowed
  ConversationLimits stream;      // what the client of each may ask for at once
  std::string allowOrigin;        // RouteOptions::allowOrigin
  std::string contact;            // RouteOptions::contact
  // Whose tokens clients need to have models; null: everybody may have all.
  std::shared_ptr<const TokenGuard> guard;
  // Quotas for the original; null: no quotas.
  std::shared_ptr<QuotaBook> quotas;
  std::optional<StaticFiles> web;
  std::string version;

  // PEM files. If both are given, the server speaks TLS and nothing else.
  std::filesystem::path tlsCertificate, tlsKey;
  // The time for which browsers are to use only HTTPS with this host, once they have used TLS
  // (HSTS); 0: the header is not sent.
  std::chrono::seconds strictTransport{ 365 * 24 * 3600 };

  // The time that a client has for the TLS handshake and for sending a request's header, from the
  // connection or the last answer on.
  std::chrono::milliseconds requestTimeout{ 30'000 };
  // The time that a client has to receive an answer, 64 KiB of it, or a message of a stream (which
  // is not larger), each plus a second for each `slowestBytes`. An answer waits for a disk at most
  // this time; then the client is asked to try again (503).
  std::chrono::milliseconds answerTimeout{ 30'000 };
  std::size_t slowestBytes = 16384; // at least 1
  // A stream is closed when its client has sent nothing for this time, pongs included.
  std::chrono::milliseconds streamTimeout{ 60'000 };
  // When connection slots are short, streams whose clients have been idle for this time lose
  // theirs; idle HTTP connections lose theirs at once.
  std::chrono::milliseconds idleTimeout{ 60'000 };
  // How long Stop waits for the answers that are in flight.
  std::chrono::milliseconds drainTimeout{ 10'000 };

  // Called from any thread, but never from two at once.
  std::function<void(const AccessRecord&)> onAccess;
  std::function<void(const PartitionRecord&)> onPartition; // a partition that a client gets
  std::function<void(const std::string&)> onError;
  // How many lines of logs have been lost so far, for the metrics. From any thread.
  std::function<std::uint64_t()> lostLines;
};

// Whether the text is valid for HttpServerOptions::trustedProxies: an address ("10.0.0.1") or a
// network ("10.0.0.0/8").
bool IsNetwork(const std::string& text);

class HttpServer
{
public:
  // Listens and serves from threads of its own. Errors: InvalidArgument for invalid addresses, also
  // of proxies; InvalidInput for the TLS files; InputOutput if a port is taken or not allowed.
  // REQUIRES: the catalog outlives the server.
  static Result<std::unique_ptr<HttpServer>> Start(
    const Catalog& catalog, HttpServerOptions options);

  // Stops at once; but a disk that hangs is waited for.
  ~HttpServer();

  std::uint16_t Port() const;
  std::string Url() const;      // "http://127.0.0.1:8700"
  std::string AdminUrl() const; // "" without one

  // Reads certificate and key again, for new connections. Without TLS it does nothing. Errors:
  // those of Start for these files; then the old ones stay.
  Status ReloadTls();

  // From now on only finishes what is in flight: new requests are refused (503). Must not be called
  // from a callback; the next two neither.
  void BeginDrain();
  // Waits until that is finished, at most this time. Whether it is.
  bool WaitUntilDrained(std::chrono::milliseconds time);
  // Graceful shutdown: drains for at most drainTimeout, then closes connections, ends the threads.
  void Stop();
  // Stops at once, and waits for disks at most this time. False if a disk still holds a thread: to
  // end without waiting for it, the process must use _exit.
  bool StopWithin(std::chrono::milliseconds patience);

private:
  struct Implementation;
  explicit HttpServer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> Server;
};

}
