// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/MpiJob.h"

#include <vtkMPIController.h>

namespace kdstream
{

MpiJob::MpiJob(int& argc, char**& argv)
  : Ranks(vtkMPIController::New())
{
  this->Ranks->Initialize(&argc, &argv);
}

MpiJob::~MpiJob()
{
  this->Ranks->Finalize();
  this->Ranks->Delete();
}

}
