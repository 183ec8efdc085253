// SPDX-License-Identifier: BSD-3-Clause
// The pipeline of an algorithm that the processes of a controller execute together. It asks for
// this process's piece of the input. Where one process has no input, or one of another type, or
// where its input could not be made, or an exception leaves an algorithm, all fail, so that none
// waits for those that never come.
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
  // null or one process: as its superclass. Where all of the input was asked for and all sources
  // above give pieces (CAN_HANDLE_PIECE_REQUEST), this process's is asked for, of as many as there
  // are processes; else what others have is what this process has: of a file of its own.
  // setErrorCode: the algorithm's. Where any process has failed outside RequestData, all print that
  // as an error of their algorithm, which names the process; outputs are empty, and the code is
  // UnknownError.
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
  bool IsAgreed = false; // of the pass for data: that all have their input
};

// Whether there are several processes.
bool AreSeveral(vtkMultiProcessController* controller);

// Where the others cannot be told any more and would wait for ever: the end of this process is that
// of the job.
[[noreturn]] void EndProcess(const RankGroup& group, const Error& error);

// RankGroup::Run, for RequestData: nothing is thrown.
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
