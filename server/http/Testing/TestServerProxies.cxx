// SPDX-License-Identifier: BSD-3-Clause
// Behind a trusted proxy the client is the one that the proxy names; otherwise it is the peer.
#include "filters/protocol/Testing/RandomMessages.h"
#include "server/http/Testing/ServerTest.h"

#include <algorithm>

using namespace kdstream;
using namespace kdstream::protocol;
using namespace std::string_literals;

namespace
{

using Proxies = ServerTest;

const std::string askHealth = "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n";
const std::string textHeader = "PROXY TCP4 1.2.3.4 5.6.7.8 50000 443\r\n";
const std::string binaryHeader =
  "\r\n\r\n\0\r\nQUIT\n\x21\x11\0\x0c\1\2\3\4\5\6\7\x08\xc3\x50\1\xbb"s;
const std::string localHeader = "\r\n\r\n\0\r\nQUIT\n\x20\0\0\0"s;

// The status of the answer to these bytes; 0 if the connection ends without an answer.
unsigned StatusOf(std::uint16_t port, const std::string& bytes)
{
  HttpTestClient client(port);
  client.Send(bytes);
  const auto response = client.Receive();
  return response ? response->status : 0;
}

}

TEST_F(Proxies, AProxysClientsAreCountedByTheirOwnAddress)
{
  this->options.connectionsOfAddress = 1;
  this->options.requestsOfAddress = 3;
  this->options.trustedProxies = { "127.0.0.1" };
  const auto port = this->Start();
  const std::string upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                              "Sec-WebSocket-Version: 13\r\n"
                              "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                              "Sec-WebSocket-Protocol: kdstream.v2\r\nX-Forwarded-For: ";
  HttpTestClient first(port);
  HttpTestClient second(port);
  HttpTestClient third(port);
  EXPECT_EQ(first.Get("/api/stream", upgrade + "1.2.3.4\r\n")->status, 101u);
  EXPECT_EQ(second.Get("/api/stream", upgrade + "6.6.6.6, 1.2.3.4\r\n")->status, 429u);
  EXPECT_EQ(third.Get("/api/stream", upgrade + "1.2.3.5\r\n")->status, 101u);
  HttpTestClient pooled(port); // one connection of the proxy, used for many clients
  for (int i = 0; i < 3; ++i)
  {
    EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.9\r\n")->status, 200u);
  }
  EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.9\r\n")->status, 429u);
  EXPECT_EQ(pooled.Get("/healthz", "X-Forwarded-For: 1.2.3.10\r\n")->status, 200u);
  this->server->Stop();
  // Streams are logged when they end, so the last request is not the last record.
  EXPECT_NE(std::find_if(this->records.begin(), this->records.end(),
              [](const AccessRecord& record)
              { return record.client == "1.2.3.10" && record.target == "/healthz"; }),
    this->records.end());
}

TEST_F(Proxies, AHeaderNamesTheClient)
{
  this->options.trustedProxies = { "127.0.0.1" };
  this->options.proxyProtocol = true;
  this->options.requestsOfAddress = 2;
  const auto port = this->Start();
  EXPECT_EQ(StatusOf(port, textHeader + askHealth), 200u);
  EXPECT_EQ(StatusOf(port, binaryHeader + askHealth), 200u);
  EXPECT_EQ(StatusOf(port, textHeader + askHealth), 429u) << "the third of 1.2.3.4";
  const std::string forwarded =
    "GET /healthz HTTP/1.1\r\nHost: x\r\nX-Forwarded-For: 9.9.9.9\r\n\r\n";
  EXPECT_EQ(StatusOf(port, localHeader + forwarded), 200u) << "of the proxy itself";
  EXPECT_EQ(StatusOf(port, "PROXY UNKNOWN\r\n" + forwarded), 200u);
  EXPECT_EQ(StatusOf(port, "PROXY TCP6 ::ffff:1.2.3.6 ::1 1 443\r\n" + askHealth), 200u);
  HttpTestClient pieces(port); // byte by byte
  for (const char byte : "PROXY TCP4 1.2.3.5 5.6.7.8 50000 443\r\n" + askHealth)
  {
    pieces.Send(std::string(1, byte));
  }
  EXPECT_EQ(pieces.Receive()->status, 200u);
  this->server->Stop();
  std::vector<std::string> clients;
  for (const auto& record : this->records)
  {
    clients.push_back(record.client);
  }
  std::sort(clients.begin(), clients.end());
  EXPECT_EQ(clients, (std::vector<std::string>{ "1.2.3.4", "1.2.3.4", "1.2.3.4", "1.2.3.5",
                       "1.2.3.6", "127.0.0.1", "127.0.0.1" }));
}

TEST_F(Proxies, ANamedClientHasItsOwnSlots)
{
  this->options.trustedProxies = { "127.0.0.1", "10.0.0.0/8" };
  this->options.proxyProtocol = true;
  this->options.connectionsOfAddress = 1;
  const auto port = this->Start();
  HttpTestClient first(port);
  first.Send(textHeader + askHealth);
  EXPECT_EQ(first.Receive()->status, 200u);
  EXPECT_EQ(StatusOf(port, textHeader + askHealth), 429u);
  EXPECT_EQ(StatusOf(port, "PROXY TCP4 1.2.3.5 5.6.7.8 1 443\r\n" + askHealth), 200u);
  // There is a second proxy in front of the first; the client that it names is logged as usual.
  const std::string forwarded =
    "PROXY TCP4 10.1.1.1 5.6.7.8 1 443\r\n"
    "GET /healthz HTTP/1.1\r\nHost: x\r\nX-Forwarded-For: 9.9.9.9\r\n\r\n";
  EXPECT_EQ(StatusOf(port, forwarded), 200u);
  this->server->Stop();
  EXPECT_NE(std::find_if(this->records.begin(), this->records.end(),
              [](const AccessRecord& record) { return record.client == "9.9.9.9"; }),
    this->records.end());
}

TEST_F(Proxies, NobodyElseIntroducesAClient)
{
  this->options.trustedProxies = { "10.0.0.0/8" };
  this->options.proxyProtocol = true;
  const auto port = this->Start();
  EXPECT_EQ(StatusOf(port, textHeader + askHealth), 400u) << "no HTTP";
  EXPECT_EQ(StatusOf(port, binaryHeader + askHealth), 400u);
  EXPECT_EQ(StatusOf(port, askHealth), 200u);
}

TEST_F(Proxies, AProxyThatIntroducesNobodyIsNotServed)
{
  this->options.trustedProxies = { "127.0.0.1" };
  this->options.proxyProtocol = true;
  this->options.admin = ListenAddress{};
  const auto port = this->Start();
  EXPECT_EQ(StatusOf(port, askHealth), 0u);
  RandomMessages random(17);
  for (int i = 0; i < 200; ++i)
  {
    HttpTestClient client(port);
    client.Send(random.Mutated(i % 2 == 0 ? textHeader : binaryHeader) + askHealth);
  }
  EXPECT_EQ(StatusOf(port, textHeader + askHealth), 200u);
  HttpTestClient admin(this->AdminPort());
  EXPECT_FALSE(this->MetricsHave("kdstream_refusals_total{reason=\"proxy\"} 0\n", admin));
}
