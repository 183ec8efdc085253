// SPDX-License-Identifier: BSD-3-Clause
// The MPI job that a program is a rank of, from its first line to its last.
#pragma once

class vtkMPIController;

namespace kdstream
{

// Starts MPI, which takes its own arguments out of the command line, and ends it.
class MpiJob
{
public:
  MpiJob(int& argc, char**& argv);
  ~MpiJob();
  MpiJob(const MpiJob&) = delete;
  MpiJob& operator=(const MpiJob&) = delete;

  vtkMPIController& Controller() { return *this->Ranks; }

private:
  vtkMPIController* Ranks;
};

}
