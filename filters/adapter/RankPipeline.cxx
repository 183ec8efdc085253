// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/RankPipeline.h"

#include "filters/adapter/RankGroup.h"

#include <vtkAlgorithm.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationRequestKey.h>
#include <vtkMultiProcessController.h>
#include <vtkObjectFactory.h>

#include <utility>

namespace kdstream
{
namespace
{

// Calls visit(above, outputPort) for each algorithm that an algorithm's input is made by.
template <class Visit>
void ForEachAbove(vtkAlgorithm& algorithm, const Visit& visit)
{
  for (int port = 0; port < algorithm.GetNumberOfInputPorts(); ++port)
  {
    for (int i = 0; i < algorithm.GetNumberOfInputConnections(port); ++i)
    {
      int outputPort = 0;
      vtkAlgorithm& above = *algorithm.GetInputAlgorithm(port, i, outputPort);
      visit(above, outputPort);
      ForEachAbove(above, visit);
    }
  }
}

// Whether all sources above do.
bool GivePieces(vtkAlgorithm& algorithm)
{
  bool give = true;
  ForEachAbove(algorithm,
    [&](vtkAlgorithm& above, int outputPort)
    {
      vtkInformation* const output = above.GetOutputInformation(outputPort);
      give = give && (above.GetNumberOfInputPorts() > 0 ||
                       output->Get(vtkAlgorithm::CAN_HANDLE_PIECE_REQUEST()) != 0);
    });
  return give;
}

void AskForPiece(
  vtkMultiProcessController& controller, vtkAlgorithm& algorithm, vtkInformation& input)
{
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  if (input.Get(Pipeline::UPDATE_NUMBER_OF_PIECES()) <= 1 && GivePieces(algorithm))
  {
    input.Set(Pipeline::UPDATE_PIECE_NUMBER(), controller.GetLocalProcessId());
    input.Set(Pipeline::UPDATE_NUMBER_OF_PIECES(), controller.GetNumberOfProcesses());
  }
}

// VTK does not ask a source again that has failed, unless it was changed; but its code stays.
bool HasFailed(vtkAlgorithm& algorithm)
{
  bool failed = false;
  ForEachAbove(algorithm, [&](vtkAlgorithm& above, int)
    { failed = failed || above.GetErrorCode() != vtkErrorCode::NoError; });
  return failed;
}

}

vtkStandardNewMacro(RankPipeline);

vtkExecutive* RankPipeline::Make(
  vtkMultiProcessController* const& controller, std::function<void()> fail)
{
  RankPipeline* const pipeline = RankPipeline::New();
  pipeline->Controller = &controller;
  pipeline->Fail = std::move(fail);
  return pipeline;
}

// Whoever asks for data gets here on all ranks, or on none; but who asks for information may be one
// whose input alone has changed. So a source that fails in that pass is left to fail again when it
// is asked for data.
int RankPipeline::ForwardUpstream(vtkInformation* request)
{
  vtkMultiProcessController* const controller = this->Controller ? *this->Controller : nullptr;
  if (!AreSeveral(controller))
  {
    return this->Superclass::ForwardUpstream(request);
  }
  vtkInformation* const input = this->GetInputInformation(0, 0);
  if (input && request->Has(REQUEST_UPDATE_EXTENT()))
  {
    AskForPiece(*controller, *this->Algorithm, *input);
  }
  const int made = this->Superclass::ForwardUpstream(request);
  if (!request->Has(REQUEST_DATA()))
  {
    return request->Has(REQUEST_INFORMATION()) ? 1 : made;
  }
  const bool isMade = made && !HasFailed(*this->Algorithm);
  const Status all =
    RankGroup(*controller)
      .Agree(isMade ? Status() : Error{ ErrorCode::InvalidInput, "its input was not made" });
  if (!all)
  {
    vtkErrorWithObjectMacro(this->Algorithm, << all.GetError().message);
    this->Fail();
  }
  return all ? 1 : 0;
}

bool AreSeveral(vtkMultiProcessController* controller)
{
  return controller && controller->GetNumberOfProcesses() > 1;
}

}
