// SPDX-License-Identifier: BSD-3-Clause
// Makes a recording: drives a session against a server's Conversation in the same process, and
// writes down all inputs. Time is simulated and nothing is random, so a recording is the same
// whenever it is made.
#pragma once

#include "server/session/Catalog.h"
#include "server/session/Conversation.h"
#include "viewer/client/Testing/Replay/TracedSession.h"

#include <cstddef>
#include <deque>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace kdstream::testing
{

// The models of another catalog, some blobs of which cannot be read.
class TroubledCatalog : public Catalog
{
public:
  explicit TroubledCatalog(const Catalog& models)
    : Whole(models)
  {
  }
  std::vector<std::shared_ptr<const ServedModel>> Models() const override;
  std::shared_ptr<const ServedModel> Find(std::string_view id) const override;

  std::set<protocol::BlobId> unreadable;

private:
  class TroubledModel;
  const Catalog& Whole;
};

class Recorder
{
public:
  using Kind = RecordedInput::Kind;

  // Writes FILE.recording, and the trace of what happens to FILE.trace. hasStream: false:
  // everything goes by GET.
  Recorder(const Catalog& models, bool hasStream, const std::string& file);

  // ---- what the person does
  void Do(Kind kind, std::vector<double> numbers = {}, std::string payload = {});
  void Tap(double x, double y);
  void DoubleTap(double x, double y);
  // One finger, in steps.
  void Drag(double x, double y, double dx, double dy);
  // Two fingers about (x, y) whose gap goes from one to the other, moving by (dx, dy) meanwhile.
  void Pinch(double x, double y, double fromGap, double toGap, double dx = 0, double dy = 0);

  // ---- the server. Answers one thing; false if there is nothing.
  bool Answer();
  // Answers everything, with frames in between.
  void Settle();
  // At most this number of answers; returns how many there were.
  std::size_t Settle(std::size_t answers);
  // The connection breaks, or what is fetched does not come.
  void Break();
  // Flips one bit of the next frame or fetched blob.
  void DamageNext() { this->Damage = true; }
  bool serverIsUp = true;
  double bytesPerSecond = 0; // that the line carries; 0: any number
  // Each answer is drawn, instead of several together.
  bool drawsEach = false;
  // Blobs of which all has been sent, in order.
  std::vector<protocol::BlobId> sent;
  // Edges with only one triangle, of all surfaces that were drawn.
  std::size_t Holes() const { return this->BoundaryEdges; }
  std::size_t Surfaces() const { return this->SurfacesDrawn; }
  TroubledCatalog catalog;

  void Wait(double seconds) { this->Now += seconds; }
  // The statistics. False where something could not be written.
  bool Finish();

  const TracedSession& Traced() const { return this->Session; }
  ViewerStatus Status() const { return this->Session.Session().GetStatus(); }

private:
  void Input(RecordedInput input);
  void Carry(std::size_t bytes);
  void CountHoles();
  void AnswerFetch();
  HttpReply Fetch(const std::string& target);

  bool HasStream;
  std::ofstream Recording, Trace;
  double Now = 0;
  bool Connecting = false;
  bool Damage = false;
  std::unique_ptr<Conversation> Stream;
  std::deque<HttpFetch> Fetches;
  TracedSession Session;
  std::uint64_t DrawnVersion = 0;
  std::size_t BoundaryEdges = 0, SurfacesDrawn = 0;
};

}
