// SPDX-License-Identifier: BSD-3-Clause
// A line to a server in virtual time, with a given speed and delay. The blobs that a session
// requests arrive in order, as over a stream. They arrive in the same way in every run, however
// slow the machine is.
#pragma once

#include "server/session/Catalog.h"
#include "viewer/session/ViewerSession.h"

#include <cstdint>
#include <deque>

namespace kdstream::bench
{

class SimulatedLine
{
public:
  // roundTrip: in s. The model is kept.
  SimulatedLine(const ServedModel& model, double bytesPerSecond, double roundTrip)
    : Model(model)
    , Rate(bytesPerSecond)
    , RoundTrip(roundTrip)
  {
  }

  // Takes the requests that the session has to send, and delivers the next answer. False if there
  // is none.
  bool Next(ViewerSession& session);

  double Now() const { return this->Time; }              // s
  std::uint64_t Bytes() const { return this->Received; } // of blobs and descriptions

private:
  struct Answer
  {
    std::uint32_t request = 0;
    bool open = false;
    protocol::BlobId blob;
    double sent = 0; // when the request was sent
  };
  void Take(ViewerSession& session);
  void Cancel(std::uint32_t request);
  double Pass(double sent, std::size_t bytes);

  const ServedModel& Model;
  double Rate, RoundTrip;
  double Time = 0;
  double LastArrival = 0;
  std::uint64_t Received = 0;
  std::deque<Answer> Answers;
};

}
