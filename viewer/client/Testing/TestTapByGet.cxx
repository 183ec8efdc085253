// SPDX-License-Identifier: BSD-3-Clause
// A tap on a slow connection without a stream: a session, a ServerLine, and GETs, one after the
// other. Earlier requests do not delay the tap, even if the connection was fast until then, so that
// much is in flight.
#include "viewer/client/ServerLine.h"

#include "filters/model/ModelJson.h"
#include "filters/protocol/ResourcePath.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

constexpr double roundTrip = 0.03; // s

// A static host and the browser's fetch, in simulated time.
class SlowHost
{
public:
  SlowHost(ViewerSession& session, MemoryServer& server)
    : Session(session)
    , Server(server)
    , Line(
        []
        {
          ServerLineOptions options;
          options.authority = "host:1";
          return options;
        }())
  {
    this->Line.SocketEnded(true, "the server says 426", this->Now);
    this->Pump();
  }

  // Answers one GET. False if nothing was requested.
  bool Answer()
  {
    this->Session.BeginFrame();
    this->Pump();
    if (this->Asked.empty())
    {
      return false;
    }
    const std::string target = this->Asked.front();
    this->Asked.pop_front();
    const auto path = protocol::ParseResourcePath(target);
    EXPECT_TRUE(path) << target;
    std::string body = WriteModel(this->Server.Description());
    if (path->kind == protocol::ResourcePath::Kind::Blob)
    {
      const std::vector<std::uint8_t>& bytes = this->Server.Blob(path->blob);
      body.assign(bytes.begin(), bytes.end());
      this->Got.push_back(path->blob);
    }
    this->Now += roundTrip + static_cast<double>(body.size()) / this->BytesPerSecond;
    this->Line.Fetched(HttpReply{ 200, std::move(body) }, this->Now);
    this->Pump();
    this->Session.BeginFrame();
    this->Pump();
    return true;
  }
  void AnswerAll()
  {
    while (this->Answer())
    {
    }
  }
  // Passes on requests and events, as far as one GET at a time allows.
  void Pump()
  {
    for (bool busy = true; busy;)
    {
      busy = false;
      for (const ClientEvent& event : this->Line.TakeEvents())
      {
        Deliver(event, this->Session);
        busy = true;
      }
      for (const SessionRequest& request : this->Session.TakeRequests())
      {
        this->Line.Send(request, this->Now);
        busy = true;
      }
    }
    for (const ServerLine::Action& action : this->Line.TakeActions())
    {
      if (action.kind == ServerLine::Action::Kind::Fetch)
      {
        this->Asked.push_back(action.fetch.target);
      }
    }
    EXPECT_LE(this->Asked.size(), 1u);
  }

  std::vector<BlobId> Got; // the fetched blobs, in order
  double Now = 1;          // s
  double BytesPerSecond = 4e6;

private:
  ViewerSession& Session;
  MemoryServer& Server;
  ServerLine Line;
  std::deque<std::string> Asked;
};

TEST(TestTapByGet, ATapComesBeforeWhatWasAskedForEarlier)
{
  MemoryServer server = Torus();
  ViewerSession session;
  SlowHost host(session, server);
  session.Resize({ width, height, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  host.AnswerAll();
  ASSERT_GT(session.GetStatus().triangles, 0u) << session.GetStatus().error;
  session.EnterFullScreen();
  for (int answers = 0; answers < 6; ++answers)
  {
    ASSERT_TRUE(host.Answer());
  }
  ASSERT_FALSE(session.IsIdle()) << "much is owed still";
  host.Got.clear();
  const double tapped = host.Now;
  host.BytesPerSecond = 50e3;
  double clock = 100;
  DoubleTap(session, onRingX, onRingY, clock);
  host.Pump();
  double firstShown = 0;
  std::size_t before = 0; // blobs until the first partition
  while (firstShown == 0 && host.Answer())
  {
    const auto region = session.GetStatus().region;
    if (region && region->shown > 0)
    {
      firstShown = host.Now;
      before = host.Got.size() - 1;
    }
  }
  ASSERT_GT(firstShown, 0) << "it is shown before all else has come";
  const auto region = session.GetStatus().region;
  ASSERT_FALSE(session.IsIdle());

  // Of the earlier requests, only those in flight were answered; then came the tree, and the pieces
  // on the way down.
  const NodeId cell = region->cell;
  const TreeDepths& depths = server.Codec().depths;
  std::size_t others = 0;
  for (const BlobId& blob : host.Got)
  {
    const bool isIntermediate =
      IsOfPiece(blob) && PieceOfBlob(blob, depths).node ==
                           cell >> (depths.partition - DepthOfNode(PieceOfBlob(blob, depths).node));
    others += IsOfTree(blob) || isIntermediate ? 0 : 1;
  }
  EXPECT_LE(others, 3u);
  EXPECT_LE(before, 10u);
  EXPECT_LT(firstShown - tapped, 1.5) << "seconds";

  // All of the region arrives before other visible pieces.
  while (session.GetStatus().region->shown < session.GetStatus().region->partitions)
  {
    ASSERT_TRUE(host.Answer());
  }
  EXPECT_FALSE(session.IsIdle());
  ExpectClosed(session);
  host.AnswerAll();
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().error, "");
}

}
