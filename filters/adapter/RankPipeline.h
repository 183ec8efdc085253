// SPDX-License-Identifier: BSD-3-Clause
// The pipeline of an algorithm that the processes of a controller execute together: where the input
// of one could not be made, none executes, so that none waits for those that never come.
#pragma once

#include <vtkCompositeDataPipeline.h>

#include <functional>

class vtkAlgorithm;
class vtkInformation;
class vtkMultiProcessController;

namespace kdstream
{

class RankPipeline : public vtkCompositeDataPipeline
{
public:
  static RankPipeline* New();
  vtkTypeMacro(RankPipeline, vtkCompositeDataPipeline);

  // For CreateDefaultExecutive. controller: the processes; null or one: nothing is agreed on. fail:
  // is called where the input of any process could not be made, after all have printed that as an
  // error of their algorithm, which names the process.
  static vtkExecutive* Make(
    std::function<vtkMultiProcessController*()> controller, std::function<void()> fail);

protected:
  RankPipeline() = default;
  ~RankPipeline() override = default;

  int ForwardUpstream(vtkInformation* request) override;
  using vtkCompositeDataPipeline::ForwardUpstream;

private:
  RankPipeline(const RankPipeline&) = delete;
  void operator=(const RankPipeline&) = delete;

  std::function<vtkMultiProcessController*()> Controller;
  std::function<void()> Fail;
};

// In REQUEST_UPDATE_EXTENT of an algorithm with one input: asks that for this process's piece, of
// as many as there are processes, where all of it was asked for and all sources above give pieces
// (CAN_HANDLE_PIECE_REQUEST). What others have is what this process has: of a file of its own.
void AskForPieceOfRank(
  vtkMultiProcessController& controller, vtkAlgorithm& algorithm, vtkInformation& input);

}
