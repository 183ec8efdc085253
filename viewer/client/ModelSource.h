// SPDX-License-Identifier: BSD-3-Clause
// Where a session's models come from: a server, or files on this machine. Step "receive" of the
// pipeline picture.
#pragma once

#include "filters/model/ModelDescription.h"
#include "viewer/client/ClientEvent.h"

#include <chrono>
#include <vector>

namespace kdstream
{

// Every request is answered: for each blob, by the blob or by a failure. Threads: Send, Take and
// Wait may be called from any thread.
class ModelSource
{
public:
  virtual ~ModelSource() = default;

  virtual const std::vector<ModelSummary>& Models() const = 0;

  virtual void Send(const SessionRequest& request) = 0;
  // Requests the notes on a model that has some (ModelSummary::notes); they arrive as an event. No
  // event if they cannot be fetched.
  virtual void AskForNotes(const std::string& model) = 0;
  // The events since the last call, in order.
  virtual std::vector<ClientEvent> Take() = 0;
  // Waits until there is something to take; false if nothing has come in that time.
  virtual bool Wait(std::chrono::milliseconds atMost) = 0;
};

}
