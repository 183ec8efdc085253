// SPDX-License-Identifier: BSD-3-Clause
// A line to a server in virtual time: see SimulatedLine.h.
#include "Testing/Benchmarks/SimulatedLine.h"

#include <algorithm>
#include <utility>

namespace kdstream::bench
{

void SimulatedLine::Take(ViewerSession& session)
{
  for (const SessionRequest& request : session.TakeRequests())
  {
    if (request.kind == SessionRequest::Kind::Cancel)
    {
      this->Cancel(request.id);
    }
    if (request.kind == SessionRequest::Kind::Open)
    {
      this->Answers.push_back({ request.id, true, {}, this->Time });
    }
    for (const protocol::BlobId& blob : request.blobs)
    {
      this->Answers.push_back({ request.id, false, blob, this->Time });
    }
  }
}

// Cancels answers that wait. The answer that is in flight arrives nevertheless.
void SimulatedLine::Cancel(std::uint32_t request)
{
  const auto first = this->Answers.begin() + (this->Answers.empty() ? 0 : 1);
  this->Answers.erase(std::remove_if(first, this->Answers.end(),
                        [request](const Answer& answer) { return answer.request == request; }),
    this->Answers.end());
}

// An answer arrives. Returns how long it took since it was requested, or since the previous answer.
double SimulatedLine::Pass(double sent, std::size_t bytes)
{
  const double begin = std::max(this->LastArrival, sent + this->RoundTrip);
  this->Time = begin + static_cast<double>(bytes) / this->Rate;
  this->Received += bytes;
  return this->Time - std::max(sent, std::exchange(this->LastArrival, this->Time));
}

bool SimulatedLine::Next(ViewerSession& session)
{
  this->Take(session);
  if (this->Answers.empty())
  {
    return false;
  }
  const Answer answer = this->Answers.front();
  this->Answers.pop_front();
  if (answer.open)
  {
    this->Pass(answer.sent, this->Model.Json()->size());
    session.Opened(answer.request, this->Model.Description());
    return true;
  }
  const auto bytes = this->Model.ReadBlob(answer.blob);
  if (!bytes)
  {
    session.BlobFailed(answer.request, answer.blob, bytes.GetError().message);
    return true;
  }
  const double seconds = this->Pass(answer.sent, (*bytes)->size());
  session.BlobArrived(answer.request, answer.blob, **bytes, seconds, false);
  return true;
}

}
