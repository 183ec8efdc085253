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
  std::string method; // "GET"; "STREAM" at the end of a stream
  std::string target; // as the client sent it: any bytes
  unsigned status = 0;
  std::uint64_t bytes = 0; // bytes of the body, or of the stream's messages
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
  // The address for metrics. It is served in plain HTTP, without connection slots or limits. With
  // it, metrics are not served at `address`.
  std::optional<ListenAddress> admin;
  unsigned threads = 2; // of the event loop, at least 1
  unsigned readers = 8; // threads that read from disks, at least 1
  // Threads that make tiles and pictures, and may wait for disks, too.
  unsigned Makers() const { return std::max(2u, this->readers / 2); }
  std::size_t maximumConnections = 1000;
  // Connections beyond maximumConnections: they are answered that no slot is free. The same number
  // applies to the admin address. Connections beyond these are closed without an answer.
  std::size_t extraConnections = 64;
  // Limits of one address: connections at a time, and requests a minute, which include the messages
  // of streams. 0: no limit. Without a number, the defaults of ClientLimits are used; they do not
  // apply to this machine itself.
  std::optional<std::size_t> connectionsOfAddress, requestsOfAddress;
  // Addresses and networks of proxies: the X-Forwarded-For field that they send gives the client's
  // address.
  std::vector<std::string> trustedProxies;
  // The proxies' connections begin with a header of the PROXY protocol, which names the client
  // instead.
  bool proxyProtocol = false;
  // The hosts that requests may name (except requests for /healthz and /readyz). If the list is
  // empty, any host is allowed; but if the server listens only at loopback without TLS, only hosts
  // that CannotBeRebound accepts (RequestForm.h). Those hosts are always allowed at `admin`.
  std::vector<std::string> allowedHosts;
  // The public address of "/" ("https://museum.example/3d/", IsPageRoot, with a slash at its end),
  // which pages of models name. If it is empty, the address of the request is used if its host is
  // one of allowedHosts; otherwise pages name no address.
  std::string publicAddress;
  std::size_t headerBytes = 8192; // the most bytes of a request's header; bodies are not allowed
  ConversationLimits stream;      // what the client of each stream may ask for at once
  std::string allowOrigin;        // RouteOptions::allowOrigin
  std::string contact;            // RouteOptions::contact
  // Checks the tokens that clients need to get models; null: everybody may get all models.
  std::shared_ptr<const TokenGuard> guard;
  // Quotas for the original; null: there are none.
  std::shared_ptr<QuotaBook> quotas;
  std::optional<StaticFiles> web;
  std::string version;

  // PEM files. If both are given, the server speaks only TLS.
  std::filesystem::path tlsCertificate, tlsKey;
  // The time for which browsers are to use only HTTPS with this host, once they have used TLS
  // (HSTS); 0: the header is not sent.
  std::chrono::seconds strictTransport{ 365 * 24 * 3600 };

  // The time that a client has for the TLS handshake and for sending a request's header. It begins
  // with the connection, or with the last answer.
  std::chrono::milliseconds requestTimeout{ 30'000 };
  // The time that a client has to receive an answer, or 64 KiB of a larger one, or a message of a
  // stream (which is no larger). One second for each `slowestBytes` bytes is added. An answer waits
  // for a disk at most for answerTimeout; then the client is asked to try again (503).
  std::chrono::milliseconds answerTimeout{ 30'000 };
  std::size_t slowestBytes = 16384; // at least 1
  // A stream is closed when its client has sent nothing for this time, not even a pong.
  std::chrono::milliseconds streamTimeout{ 60'000 };
  // When connection slots are short, a stream whose client has been idle for this time loses its
  // slot; an idle HTTP connection loses its slot at once.
  std::chrono::milliseconds idleTimeout{ 60'000 };
  // How long Stop waits for the answers that are in flight.
  std::chrono::milliseconds drainTimeout{ 10'000 };

  // Called from any thread, but never from two at the same time.
  std::function<void(const AccessRecord&)> onAccess;
  std::function<void(const PartitionRecord&)> onPartition; // for each partition that a client gets
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
  // Listens, and serves from threads of its own. Errors: InvalidArgument for invalid addresses,
  // including those of proxies; InvalidInput for the TLS files; InputOutput if a port is taken or
  // not allowed. REQUIRES: the catalog outlives the server.
  static Result<std::unique_ptr<HttpServer>> Start(
    const Catalog& catalog, HttpServerOptions options);

  // Stops at once; but waits for a disk that hangs.
  ~HttpServer();

  std::uint16_t Port() const;
  std::string Url() const;      // "http://127.0.0.1:8700"
  std::string AdminUrl() const; // "" without an admin address

  // Reads the certificate and the key again, for new connections. Does nothing without TLS. Errors:
  // those of Start for these files; then the old certificate and key stay in use.
  Status ReloadTls();

  // From now on only answers that are in flight are finished; new requests are refused (503).
  // BeginDrain, WaitUntilDrained and Stop must not be called from a callback.
  void BeginDrain();
  // Waits until the answers in flight are finished, at most for this time. Returns whether they
  // are.
  bool WaitUntilDrained(std::chrono::milliseconds time);
  // Graceful shutdown: drains for at most drainTimeout, then closes the connections and ends the
  // threads.
  void Stop();
  // Stops at once, and waits for disks at most for this time. False if a disk still holds a thread;
  // then the process must use _exit to end without waiting for that disk.
  bool StopWithin(std::chrono::milliseconds patience);

private:
  struct Implementation;
  explicit HttpServer(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> Server;
};

}
