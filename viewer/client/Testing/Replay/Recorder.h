// SPDX-License-Identifier: BSD-3-Clause
// Makes a recording: drives a session against a server's Conversation in the same process, and
// writes down all inputs. Time is simulated, and nothing is random, so a recording is always the
// same.
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

// The models of another catalog, but some blobs cannot be read.
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

  // Writes FILE.recording, and the trace to FILE.trace. If hasStream is false, everything is
  // fetched by GET.
  Recorder(const Catalog& models, bool hasStream, const std::string& file);

  // ---- what the user does
  void Do(Kind kind, std::vector<double> numbers = {}, std::string payload = {});
  void Tap(double x, double y);
  void DoubleTap(double x, double y);
  // Drags with one finger, in steps.
  void Drag(double x, double y, double dx, double dy);
  // Two fingers around (x, y), whose gap changes from `fromGap` to `toGap` while they move by (dx,
  // dy).
  void Pinch(double x, double y, double fromGap, double toGap, double dx = 0, double dy = 0);

  // ---- the server. Sends one answer; false if nothing is outstanding.
  bool Answer();
  // Sends all answers, with frames in between.
  void Settle();
  // Sends at most this number of answers; returns how many it sent.
  std::size_t Settle(std::size_t answers);
  // The connection breaks, or the current GET fails.
  void Break();
  // Flips one bit of the next frame or fetched blob.
  void DamageNext() { this->Damage = true; }
  bool serverIsUp = true;
  double bytesPerSecond = 0; // speed of the connection; 0: unlimited
  // Whether a frame is drawn after each answer, instead of after several.
  bool drawsEach = false;
  // Blobs that have been sent completely, in order.
  std::vector<protocol::BlobId> sent;
  // The edges with only one triangle, in all drawn surfaces together.
  std::size_t Holes() const { return this->BoundaryEdges; }
  std::size_t Surfaces() const { return this->SurfacesDrawn; }
  TroubledCatalog catalog;

  void Wait(double seconds) { this->Now += seconds; }
  // Writes the statistics. False if anything could not be written.
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
