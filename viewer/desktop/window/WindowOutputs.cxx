// SPDX-License-Identifier: BSD-3-Clause
// The outputs of a window: pictures, texts to paste, and what the command line asks for. See
// WindowController.h.
#include "viewer/desktop/OpenSource.h"
#include "viewer/desktop/window/ToolsPanel.h"
#include "viewer/desktop/window/WindowController.h"

#include <vtkRenderWindow.h>

#include <filesystem>

namespace kdstream
{
namespace
{

// Returns "dragon.png", or "dragon-2.png" if that file exists.
std::string NewName(const std::string& model, const std::string& extension)
{
  std::error_code failure;
  std::string name = model + extension;
  for (int i = 2; std::filesystem::exists(name, failure); ++i)
  {
    name = model + "-" + std::to_string(i) + extension;
  }
  return name;
}

}

void WindowController::Copy(const std::string& text, const std::string& what)
{
  this->Tell(this->Clipboard.Put(text) ? what + " copied." : "No clipboard is available.");
}

// Copies a link for a browser, or for kdstream-view.
void WindowController::CopyLink()
{
  if (this->Session.Model())
  {
    const std::string& source = this->Options.source;
    const bool isServer = NamesServer(source);
    this->Copy(source + (isServer && source.back() != '/' ? "/#" : "#") + this->Link(),
      "The link to this view is");
  }
}

void WindowController::CopyMeasurements()
{
  std::string text;
  const PanelFacts facts = this->Facts();
  for (const SeenMeasurement& each : facts.measurements)
  {
    text += each.measurement.name + ": " +
            DescribeMeasurement(each.measurement, facts.up, facts.model ? facts.model->unit : "") +
            "\n";
  }
  this->Copy(text, "The distances are");
}

void WindowController::SaveOutline()
{
  const std::string outline = this->Session.Viewer().SectionOutline();
  if (!outline.empty())
  {
    const std::string file = NewName(this->Session.Viewer().GetStatus().model + "-section", ".svg");
    const Status written = WriteOutput(file, outline);
    this->Tell(written ? "Wrote " + file : written.GetError().message);
  }
}

// The picture is taken when all earlier actions show on the screen. In a recording it is taken when
// everything has arrived, because a replay does the same.
void WindowController::AskForPicture()
{
  this->PicturePending = true;
  this->FramesLeft = 2;
  if (this->Session.IsRecording() && !this->Session.Viewer().IsIdle())
  {
    this->Tell("The picture will be saved when everything is loaded.");
  }
}

void WindowController::TakePicture()
{
  this->PicturePending = false;
  const std::string model = this->Session.Viewer().GetStatus().model;
  if (model.empty() || this->Session.Viewer().GetStatus().vertices == 0)
  {
    this->Tell("There is nothing to save a picture of yet.");
    return;
  }
  const std::string file = NewName(model, ".png");
  const Status written =
    this->Session.IsRecording() ? this->WriteModelPicture(file) : this->WriteSpecifiedPicture(file);
  this->Session.Do({ SessionStep::Kind::Screenshot, {}, file });
  this->Tell(written ? "Wrote " + file : written.GetError().message);
}

// Draws the window with this part of the interface, without showing it on the screen.
Result<WindowPicture> WindowController::PictureWith(InterfaceLayer::Part part)
{
  vtkRenderWindow& window = this->Display->Window();
  this->Interface.Draw(part);
  this->Scene.SetAppearance(this->Settings.scene.colors, this->Settings.scene.occlusion);
  window.SwapBuffersOff();
  auto picture = Pixels(window);
  window.SwapBuffersOn();
  this->Interface.Draw(InterfaceLayer::Part::Shown);
  return picture;
}

// Writes only the model, because the pictures of a replay show nothing else.
Status WindowController::WriteModelPicture(const std::string& file)
{
  const auto picture = this->PictureWith(InterfaceLayer::Part::None);
  KDSTREAM_TRY(picture);
  return WritePng(PartOf(*picture, 0, 0, this->View.width, this->View.height), file);
}

// Writes the model with its distances and, below it, title, credit and licence.
Status WindowController::WriteSpecifiedPicture(const std::string& file)
{
  const auto picture = this->PictureWith(InterfaceLayer::Part::Background);
  KDSTREAM_TRY(picture);
  const auto caption = this->PictureWith(InterfaceLayer::Part::Foreground);
  KDSTREAM_TRY(caption);
  const int height = std::min(this->CaptionHeight, this->Display->Height());
  return WritePng(Stacked(PartOf(*picture, 0, 0, this->View.width, this->View.height),
                    PartOf(*caption, 0, 0, this->View.width, height)),
    file);
}

Status WindowController::Finish()
{
  if (!this->Options.screenshot.empty() && this->Session.Viewer().GetStatus().vertices > 0)
  {
    KDSTREAM_TRY(At(this->Options.screenshot, this->WriteModelPicture(this->Options.screenshot)));
  }
  KDSTREAM_TRY(At(this->Options.record, this->Session.Recorder().Finish()));
  KDSTREAM_TRY(At(this->Options.statistics,
    WriteOutput(this->Options.statistics, StatisticsJson(this->Session.Viewer().Statistics()))));
  return At(
    this->Options.report, WriteOutput(this->Options.report,
                            this->Report.Json(this->Session.Viewer().GetTraffic(), this->Link())));
}

}
