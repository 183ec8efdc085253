// SPDX-License-Identifier: BSD-3-Clause
// The pipeline of an algorithm that the processes of a controller execute together. It requests
// this process's piece of the input. If one process has no input, an input of another type, an
// input that could not be made, or an exception in its algorithm, then all processes fail, so that
// none waits forever.
#pragma once

#include "filters/core/Result.h"
#include "filters/ranks/RankGroup.h"

#include <vtkCompositeDataPipeline.h>

#include <functional>

class vtkInformation;
class vtkInformationVector;
class vtkMultiProcessController;

namespace kdstream
{

class RankPipeline : public vtkCompositeDataPipeline
{
public:
  static RankPipeline* New();
  vtkTypeMacro(RankPipeline, vtkCompositeDataPipeline);

  // For CreateDefaultExecutive of an algorithm with one input. controller: the algorithm's member;
  // if it is null or has one process, everything is as in the superclass. setErrorCode: sets the
  // error code of the algorithm.
  //
  // If the whole input was requested, and all sources upstream deliver pieces
  // (CAN_HANDLE_PIECE_REQUEST), this process's piece is requested; there are as many pieces as
  // processes. Other sources deliver what this process has, such as a file of its own. If a process
  // fails outside RequestData, all processes print its error, with the number of the process, as an
  // error of their own algorithm; outputs are empty, and the code is UnknownError.
  static vtkExecutive* Make(
    vtkMultiProcessController* const& controller, std::function<void(unsigned long)> setErrorCode);

  vtkTypeBool ProcessRequest(
    vtkInformation* request, vtkInformationVector** input, vtkInformationVector* output) override;

protected:
  RankPipeline() = default;
  ~RankPipeline() override = default;

  int ForwardUpstream(vtkInformation* request) override;
  using vtkCompositeDataPipeline::ForwardUpstream;

private:
  RankPipeline(const RankPipeline&) = delete;
  void operator=(const RankPipeline&) = delete;

  Status CheckInput();
  vtkTypeBool AgreeOn(const Status& own);

  vtkMultiProcessController* const* Controller = nullptr;
  std::function<void(unsigned long)> SetErrorCode;
  bool IsAgreed = false; // during the data pass: whether all ranks have their input
};

// Whether there is more than one process.
bool AreSeveral(vtkMultiProcessController* controller);

// Ends this process, and so the whole job: for errors after which the other processes cannot be
// informed any more and would wait forever.
[[noreturn]] void EndProcess(const RankGroup& group, const Error& error);

// RankGroup::Run for RequestData; throws nothing.
template <class Work>
auto RunCollectively(RankGroup& group, const Work& work) -> decltype(work())
{
  try
  {
    return group.Run(work);
  }
  catch (const BrokenGroup& broken)
  {
    EndProcess(group, broken.error);
  }
}

}
