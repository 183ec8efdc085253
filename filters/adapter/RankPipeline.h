// SPDX-License-Identifier: BSD-3-Clause
// The pipeline of an algorithm that the processes of a controller execute together. It asks that
// for this process's piece of the input; where the input of one could not be made, none executes,
// so that none waits for those that never come.
#pragma once

#include <vtkCompositeDataPipeline.h>

#include <functional>

class vtkInformation;
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
  // are processes; else what others have is what this process has: of a file of its own. fail: is
  // called where the input of any process could not be made, after all have printed that as an
  // error of their algorithm, which names the process.
  static vtkExecutive* Make(
    vtkMultiProcessController* const& controller, std::function<void()> fail);

protected:
  RankPipeline() = default;
  ~RankPipeline() override = default;

  int ForwardUpstream(vtkInformation* request) override;
  using vtkCompositeDataPipeline::ForwardUpstream;

private:
  RankPipeline(const RankPipeline&) = delete;
  void operator=(const RankPipeline&) = delete;

  vtkMultiProcessController* const* Controller = nullptr;
  std::function<void()> Fail;
};

// Whether there are several processes.
bool AreSeveral(vtkMultiProcessController* controller);

}
