// SPDX-License-Identifier: BSD-3-Clause
// TLS of a connection, without a server: which thread does which computation.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "server/http/ClientSocket.h"
#include "server/http/Testing/SelfSigned.h"
#include "server/http/Testing/TlsTestClient.h"
#include "server/http/TlsCertificate.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>

#include <gtest/gtest.h>

#include <optional>
#include <thread>
#include <vector>

using namespace kdstream;
using asio::ip::tcp;

// The socket's thread only moves bytes. Until another thread does the work that it has passed on,
// it is free for other sockets.
TEST(ClientSocket, LeavesTheHandshakeToOthers)
{
  const fixtures::TemporaryFolder folder;
  WriteSelfSigned(folder / "cert.pem", folder / "key.pem");
  TlsCertificate certificate;
  ASSERT_TRUE(certificate.Load(folder / "cert.pem", folder / "key.pem"));

  asio::io_context context;
  tcp::acceptor acceptor(context, { asio::ip::address_v4::loopback(), 0 });
  const auto port = acceptor.local_endpoint().port();
  std::string answer;
  std::thread client(
    [port, &answer]
    {
      TlsTestClient peer(port);
      answer = peer.Receive("hello");
    });
  std::vector<std::function<void()>> given;
  ClientSocket socket(acceptor.accept(context.get_executor()), *certificate.Current(),
    [&given](std::function<void()> work) { given.push_back(std::move(work)); });
  std::optional<beast::error_code> shaken;
  socket.Handshake([&shaken](beast::error_code error) { shaken = error; });

  int rounds = 0;
  for (; !shaken; ++rounds)
  {
    while (given.empty() && !shaken)
    {
      context.run_one();
    }
    if (shaken)
    {
      break;
    }
    ASSERT_EQ(given.size(), 1u);
    context.restart();
    EXPECT_EQ(context.poll(), 0u) << "it waits for the work";
    bool free = false;
    asio::post(context, [&free] { free = true; });
    context.restart();
    context.poll();
    EXPECT_TRUE(free);
    std::thread elsewhere(given.front());
    elsewhere.join();
    given.clear();
    context.restart();
  }
  EXPECT_GE(rounds, 2) << "the client's greeting, and its last word";
  EXPECT_FALSE(*shaken) << shaken->message();

  bool written = false;
  socket.async_write_some(asio::buffer("hello", 5),
    [&written](beast::error_code error, std::size_t bytes) { written = !error && bytes == 5; });
  EXPECT_FALSE(written) << "never at once";
  context.restart();
  while (!written)
  {
    context.run_one();
  }
  client.join();
  EXPECT_EQ(answer, "hello");
  EXPECT_TRUE(given.empty()) << "what follows is quick";
}
