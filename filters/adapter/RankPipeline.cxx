// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/RankPipeline.h"

#include "filters/core/CaughtError.h"

#include <vtkAlgorithm.h>
#include <vtkDataObject.h>
#include <vtkErrorCode.h>
#include <vtkInformation.h>
#include <vtkInformationIntegerKey.h>
#include <vtkInformationRequestKey.h>
#include <vtkInformationStringVectorKey.h>
#include <vtkInformationVector.h>
#include <vtkMultiProcessController.h>
#include <vtkObjectFactory.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// Calls visit(above, outputPort) for all algorithms upstream of an algorithm.
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

// Whether all sources upstream can deliver pieces.
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

// VTK does not execute a source again that has failed, unless the source was changed. But its error
// code remains.
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
  vtkMultiProcessController* const& controller, std::function<void(unsigned long)> setErrorCode)
{
  RankPipeline* const pipeline = RankPipeline::New();
  pipeline->Controller = &controller;
  pipeline->SetErrorCode = std::move(setErrorCode);
  return pipeline;
}

// A request for data comes on all ranks or on none. But a request for information may come only on
// a rank whose input has changed. So an error in that pass, or in any other pass before data are
// requested, is not reported: it will occur again when data are requested.
vtkTypeBool RankPipeline::ProcessRequest(
  vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output)
{
  if (!AreSeveral(this->Controller ? *this->Controller : nullptr))
  {
    return this->Superclass::ProcessRequest(request, input, output);
  }
  vtkTypeBool done = 0;
  Status own;
  try
  {
    done = this->Superclass::ProcessRequest(request, input, output);
    own = done ? Status() : Error{ ErrorCode::InvalidInput, "it was not executed" };
  }
  catch (...)
  {
    own = CaughtError();
    this->InAlgorithm = 0; // VTK could not reset its mark, because of the exception
  }
  if (!request->Has(REQUEST_DATA()))
  {
    if (!done && request->Has(REQUEST_UPDATE_EXTENT()))
    {
      this->LastPropogateUpdateExtentShortCircuited = 0; // so that data are requested nevertheless
    }
    return 1;
  }
  return std::exchange(this->IsAgreed, false) ? this->AgreeOn(own) : done;
}

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
  if (!request->Has(REQUEST_DATA()))
  {
    return this->Superclass::ForwardUpstream(request);
  }
  Status own = Error{ ErrorCode::InvalidInput, "its input could not be made" };
  try
  {
    if (this->Superclass::ForwardUpstream(request) && !HasFailed(*this->Algorithm))
    {
      own = this->CheckInput();
    }
  }
  catch (...)
  {
    own = CaughtError();
  }
  this->SetErrorCode(vtkErrorCode::NoError);
  this->IsAgreed = this->AgreeOn(own) != 0;
  return this->IsAgreed ? 1 : 0;
}

// VTK checks this too, but later. And if the algorithm does not accept this type of composite data
// set, VTK would run it for each block.
Status RankPipeline::CheckInput()
{
  vtkDataObject* const data = this->GetInputData(0, 0);
  if (!data)
  {
    return Error{ ErrorCode::InvalidInput, "it has no input" };
  }
  vtkInformation* const port = this->Algorithm->GetInputPortInformation(0);
  const int count = port->Length(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  for (int i = 0; i < count; ++i)
  {
    if (data->IsA(port->Get(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), i)))
    {
      return {};
    }
  }
  return Error{ ErrorCode::InvalidInput,
    std::string("its input is a ") + data->GetClassName() + ", which it does not accept" };
}

// Agrees on the result of all ranks. If one has failed, reports an error of the algorithm, unless
// the algorithm has reported one already.
vtkTypeBool RankPipeline::AgreeOn(const Status& own)
{
  RankGroup group(**this->Controller);
  const Status all = RunCollectively(group, [&] { return own; });
  if (all)
  {
    return 1;
  }
  for (int port = 0; port < this->Algorithm->GetNumberOfOutputPorts(); ++port)
  {
    if (vtkDataObject* const data = vtkDataObject::GetData(this->GetOutputInformation(port)))
    {
      data->Initialize();
    }
  }
  if (this->Algorithm->GetErrorCode() == vtkErrorCode::NoError)
  {
    vtkErrorWithObjectMacro(this->Algorithm, << all.GetError().message);
    this->SetErrorCode(vtkErrorCode::UnknownError);
  }
  return 0;
}

bool AreSeveral(vtkMultiProcessController* controller)
{
  return controller && controller->GetNumberOfProcesses() > 1;
}

void EndProcess(const RankGroup& group, const Error& error)
{
  std::cerr << "kdstream: error: " << group.NameRank(error).message
            << ": the other ranks cannot be notified, so this process ends" << std::endl;
  std::abort();
}

}
