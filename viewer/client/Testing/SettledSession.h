// SPDX-License-Identifier: BSD-3-Clause
// Lets a session get everything that it requests from a source.
#pragma once

#include "viewer/client/ModelSource.h"
#include "viewer/session/ViewerSession.h"

#include <chrono>

namespace kdstream::testing
{

// Runs until nothing is outstanding; false if the source stops answering.
inline bool Settle(ViewerSession& session, ModelSource& source)
{
  for (;;)
  {
    for (const SessionRequest& request : session.TakeRequests())
    {
      source.Send(request);
    }
    session.BeginFrame();
    for (const SessionRequest& request : session.TakeRequests())
    {
      source.Send(request);
    }
    if (session.IsIdle())
    {
      return true;
    }
    if (!source.Wait(std::chrono::seconds(20)))
    {
      return false;
    }
    for (const ClientEvent& event : source.Take())
    {
      Deliver(event, session);
    }
  }
}

}
