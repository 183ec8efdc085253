// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/MpiJob.h"

#include <vtkMPICommunicator.h>
#include <vtkMPIController.h>

#include <chrono>
#include <thread>

namespace kdstream
{
namespace
{

// Messages in flight.
using Requests = std::vector<vtkMPICommunicator::Request>;

// MPI itself would wait by polling all the time.
void WaitFor(Requests& requests)
{
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::microseconds atOnce(30), mostAsleep(200);
  const Clock::time_point begin = Clock::now();
  std::chrono::microseconds asleep(10);
  for (vtkMPICommunicator::Request& request : requests)
  {
    while (!request.Test())
    {
      if (Clock::now() - begin > atOnce)
      {
        std::this_thread::sleep_for(asleep);
        asleep = std::min(2 * asleep, mostAsleep);
      }
    }
  }
}

class MpiMessages : public RankMessages
{
public:
  explicit MpiMessages(vtkMPIController& controller)
    : RankMessages(controller)
    , Controller(controller)
  {
  }

  void Move(std::span<const Outgoing> out, std::span<const Incoming> in) override
  {
    Requests requests;
    for (const Incoming& each : in)
    {
      ForEachMessage(each.bytes,
        [&](std::span<std::byte> part)
        {
          this->Controller.NoBlockReceive(reinterpret_cast<unsigned char*>(part.data()),
            static_cast<int>(part.size()), static_cast<int>(each.from), messageTagOfGroup,
            requests.emplace_back());
        });
    }
    for (const Outgoing& each : out)
    {
      ForEachMessage(each.bytes,
        [&](std::span<const std::byte> part)
        {
          this->Controller.NoBlockSend(reinterpret_cast<const unsigned char*>(part.data()),
            static_cast<int>(part.size()), static_cast<int>(each.to), messageTagOfGroup,
            requests.emplace_back());
        });
    }
    WaitFor(requests);
  }

private:
  vtkMPIController& Controller;
};

}

MpiJob::MpiJob(int& argc, char**& argv)
  : Ranks(vtkMPIController::New())
{
  this->Ranks->Initialize(&argc, &argv);
  this->OfRanks = std::make_unique<MpiMessages>(*this->Ranks);
}

MpiJob::~MpiJob()
{
  this->Ranks->Finalize();
  this->Ranks->Delete();
}

}
