// SPDX-License-Identifier: BSD-3-Clause
// The MPI job that a program is a rank of, from its start to its end.
#pragma once

#include "filters/ranks/RankMessages.h"

#include <memory>

class vtkMPIController;

namespace kdstream
{

// The constructor starts MPI, which removes its own arguments from the command line; the destructor
// ends it.
class MpiJob
{
public:
  MpiJob(int& argc, char**& argv);
  ~MpiJob();
  MpiJob(const MpiJob&) = delete;
  MpiJob& operator=(const MpiJob&) = delete;

  // All messages of one call of Move are in flight at the same time. A rank that waits for long
  // sleeps, so that others can use the processor.
  RankMessages& Messages() { return *this->OfRanks; }

private:
  vtkMPIController* Ranks;
  std::unique_ptr<RankMessages> OfRanks;
};

}
