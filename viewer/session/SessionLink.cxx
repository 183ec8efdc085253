// SPDX-License-Identifier: BSD-3-Clause
// Views that have a name, and those that somebody else tells: step "look" of the pipeline picture.
#include "viewer/session/ViewerSession.h"

#include <cmath>

namespace kdstream
{
namespace
{

// From the model towards the eye. Nothing for a side that there is not.
std::optional<Vec3> DirectionOfSide(std::string_view side, const Vec3& up, const Vec3& front)
{
  const Vec3 right = Cross(up, front);
  return side == "front"    ? std::optional(front)
         : side == "back"   ? std::optional(front * -1)
         : side == "right"  ? std::optional(right)
         : side == "left"   ? std::optional(right * -1)
         : side == "top"    ? std::optional(up)
         : side == "bottom" ? std::optional(up * -1)
                            : std::nullopt;
}

// Level, towards where the model is looked at from first.
Vec3 LevelFront(const ModelPose& pose)
{
  constexpr double least = 0.1; // a first view from nearly above tells nothing about the front
  const auto level = [&pose](const Vec3& v) { return v - pose.up * Dot(v, pose.up); };
  const Vec3 front = level(pose.view);
  return Normalized(Length(front) > least ? front : level(FrontOf(pose.up)));
}

}

void ViewerSession::NoteJump(const EarlierView& before)
{
  constexpr std::size_t mostEarlierViews = 32;
  if (before.eye != this->Eye)
  {
    this->EarlierViews.push_back(before);
  }
  if (this->EarlierViews.size() > mostEarlierViews)
  {
    this->EarlierViews.pop_front();
  }
}

bool ViewerSession::LookFromSide(std::string_view side)
{
  const ModelPose pose =
    this->Current ? this->Current->description.pose.value_or(ModelPose{}) : ModelPose{};
  const Vec3 front = LevelFront(pose);
  const auto direction = DirectionOfSide(side, pose.up, front);
  if (this->Current && direction)
  {
    const EarlierView before{ this->Eye, this->EyeMoved };
    this->FitModel();
    // From above and below the front is at the lower, or upper, edge of the screen.
    const bool isLevel = std::abs(Dot(*direction, pose.up)) < 0.5;
    const Vec3 right = Cross(pose.up, front);
    this->Eye.FitTo(this->Current->box,
      isLevel ? LookingFrom(*direction, pose.up)
              : Quaternion::OfAxes(right, Cross(*direction, right), *direction));
    this->NoteJump(before);
    this->FollowZoom();
  }
  this->Update();
  this->Trace("side", side);
  return direction.has_value();
}

ViewLink ViewerSession::Link() const
{
  ViewLink link;
  link.model = this->ModelId;
  link.turning = this->Eye.GetTurning();
  link.detail = this->Options.detail;
  if (this->Current)
  {
    link.digest = this->Current->description.digest.substr(0, ViewLink::digestDigits);
    link.place = this->Eye.GetPlace();
    for (const Measurement& each : this->Measured)
    {
      if (each.to && link.measurements.size() < ViewLink::mostMeasurements)
      {
        link.measurements.push_back(
          { this->Eye.PlaceOf(each.from.point), this->Eye.PlaceOf(each.to->point) });
      }
    }
  }
  link.lamps = this->Lamps;
  if (const std::optional<SectionPlane>& section = this->Section.Plane())
  {
    const Vec3 place = this->Eye.PlaceOf(section->NearestTo(this->Eye.PointAt({})));
    link.section = SectionPlane{ section->normal, Dot(place, section->normal) };
  }
  if (this->Region)
  {
    link.region = ViewLink::Region{ this->Region->cell, this->Region->rings };
  }
  return link;
}

Status ViewerSession::Follow(const ViewLink& link)
{
  if (this->ModelId != link.model || this->Mode == ViewerMode::NoModel)
  {
    KDSTREAM_TRY(this->SelectModel(link.model));
  }
  this->EnterFullScreen();
  this->SetTurning(link.turning);
  this->SetDetail(link.detail);
  this->Followed = link;
  if (this->Current)
  {
    const EarlierView before{ this->Eye, this->EyeMoved };
    this->TakeLink();
    this->NoteJump(before);
  }
  this->FollowZoom();
  this->Update();
  this->Trace("link");
  return {};
}

void ViewerSession::LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent)
{
  if (this->Current)
  {
    Camera there = this->Eye;
    there.LookFrom(eye, focal, up, tangent);
    this->IsLed = true;
    if (this->Mode == ViewerMode::FullScreen && there == this->Eye)
    {
      return;
    }
    this->Eye = there;
    this->EyeMoved = true;
    this->Mode = ViewerMode::FullScreen;
    this->FollowZoom();
  }
  this->Update();
  this->Trace("camera");
}

// Of a link, in the window as it is now.
void ViewerSession::TakePlace(const CameraPlace& place)
{
  Camera there = this->Eye;
  there.SetPlace(place);
  there.SetTurning(this->Options.turning);
  this->TakeView(there, there.GetViewport());
  this->EyeMoved = this->IsArriving = true;
  this->Told = ToldView{ place, this->Eye };
}

// A window may still change its shape while it opens. So as long as nobody has touched what a link
// has told, it is told anew; else false.
bool ViewerSession::TakeToldPlace(const Viewport& viewport)
{
  if (!(this->Told->eye == this->Eye))
  {
    return false;
  }
  this->Eye.SetViewport(viewport);
  this->TakePlace(CameraPlace(this->Told->place));
  return true;
}

// What a link says of the model that is open.
void ViewerSession::TakeLink()
{
  const ViewLink link = *std::exchange(this->Followed, std::nullopt);
  const ModelDescription& model = this->Current->description;
  this->Turned.Stop();
  if (link.place)
  {
    this->TakePlace(*link.place);
  }
  this->Lamps = link.lamps;
  this->Section.Set({});
  if (link.section)
  {
    const Vec3& normal = link.section->normal;
    this->Section.Set(
      SectionPlane{ normal, Dot(this->Eye.PointAt(normal * link.section->offset), normal) });
  }
  this->Measured.clear();
  this->Ends.clear();
  for (const std::array<Vec3, 2>& points : link.measurements)
  {
    this->AddTold({ this->Eye.PointAt(points[0]), this->Eye.PointAt(points[1]) });
  }
  const NodeId firstCell = NodeId{ 1 } << model.depths.partition;
  if (link.region && link.region->cell >= firstCell &&
      link.region->cell - firstCell < model.partitions && model.HasLevels())
  {
    this->Options.rings = link.region->rings;
    this->DropPick();
    this->WaitingCell = link.region->cell;
  }
  if (model.digest.compare(0, link.digest.size(), link.digest) != 0)
  {
    this->LastError = "This link was made of another version of " + this->ModelId +
                      ": what it shows may have moved.";
  }
}

}
