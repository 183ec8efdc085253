// SPDX-License-Identifier: BSD-3-Clause
// Fingers to gestures: the first step of "navigate" in the pipeline picture.
#include "viewer/session/GestureRecognizer.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

double Distance(double ax, double ay, double bx, double by)
{
  return std::sqrt((ax - bx) * (ax - bx) + (ay - by) * (ay - by));
}

bool HasFinger(const std::vector<Touch>& touches, std::int64_t id)
{
  return std::any_of(
    touches.begin(), touches.end(), [id](const Touch& touch) { return touch.id == id; });
}

// False for coordinates beyond any screen. The limit is low enough for squares to be finite.
bool OnSomeScreen(double x)
{
  return std::isfinite(x) && std::fabs(x) < 1e9;
}

}

GestureRecognizer::GestureRecognizer(const GestureThresholds& thresholds)
  : Thresholds(thresholds)
{
}

void GestureRecognizer::SetPixelRatio(double ratio)
{
  this->PixelRatio = ratio;
}

void GestureRecognizer::Reset()
{
  this->Fingers.clear();
  this->Previous.reset();
  this->MayBeTap = this->Rotating = this->Pinching = false;
}

// The valid touches: first the fingers that were down before, in their old order.
std::vector<Touch> GestureRecognizer::Accept(const std::vector<Touch>& touches) const
{
  std::vector<Touch> valid;
  for (const Touch& touch : touches)
  {
    if (OnSomeScreen(touch.x) && OnSomeScreen(touch.y) && !HasFinger(valid, touch.id))
    {
      valid.push_back(touch);
    }
  }
  std::vector<Touch> ordered;
  for (const Touch& old : this->Fingers)
  {
    const auto found = std::find_if(
      valid.begin(), valid.end(), [&old](const Touch& touch) { return touch.id == old.id; });
    if (found != valid.end())
    {
      ordered.push_back(*found);
    }
  }
  for (const Touch& touch : valid)
  {
    if (!HasFinger(ordered, touch.id))
    {
      ordered.push_back(touch);
    }
  }
  return ordered;
}

std::vector<Gesture> GestureRecognizer::HandleTouches(const TouchFrame& frame)
{
  std::vector<Gesture> gestures;
  if (std::isfinite(frame.time))
  {
    this->Time = std::max(this->Time, frame.time);
  }
  const std::vector<Touch> fingers = this->Accept(frame.touches);
  if (fingers.empty())
  {
    if (!this->Fingers.empty())
    {
      this->EndSequence(this->Time, gestures);
    }
    return gestures;
  }
  if (this->Fingers.empty())
  {
    this->SequenceBegin = this->Time;
    this->MayBeTap = fingers.size() == 1;
    if (this->Previous &&
        (this->Time - this->Previous->time > this->Thresholds.betweenSeconds || !this->MayBeTap))
    {
      this->Previous.reset();
    }
  }
  this->Move(fingers, gestures);
  this->Fingers = fingers;
  return gestures;
}

void GestureRecognizer::EndSequence(double time, std::vector<Gesture>& gestures)
{
  if (this->Pinching)
  {
    gestures.push_back({ Gesture::Kind::PinchEnd });
  }
  if (this->Rotating)
  {
    gestures.push_back({ Gesture::Kind::RotateEnd, this->Fingers[0].x, this->Fingers[0].y });
  }
  const bool tap = this->MayBeTap && time - this->SequenceBegin <= this->Thresholds.tapSeconds;
  if (tap)
  {
    const double x = this->AnchorX, y = this->AnchorY;
    const bool second = this->Previous && Distance(x, y, this->Previous->x, this->Previous->y) <=
                                            this->Thresholds.betweenPoints * this->PixelRatio;
    gestures.push_back({ second ? Gesture::Kind::DoubleTap : Gesture::Kind::Tap, x, y });
    this->Previous = second ? std::nullopt : std::optional<LastTap>({ time, x, y });
  }
  else
  {
    this->Previous.reset();
  }
  this->Fingers.clear();
  this->MayBeTap = this->Rotating = this->Pinching = false;
}

// The fingers move from this->Fingers to `fingers`. REQUIRES: at least one finger.
void GestureRecognizer::Move(const std::vector<Touch>& fingers, std::vector<Gesture>& gestures)
{
  if (fingers.size() > 1)
  {
    this->MayBeTap = this->Rotating = false;
    this->MoveTwo(fingers[0], fingers[1], gestures);
    return;
  }
  if (this->Pinching)
  {
    gestures.push_back({ Gesture::Kind::PinchEnd });
    this->Pinching = false;
  }
  this->MoveOne(fingers[0], gestures);
}

void GestureRecognizer::MoveOne(const Touch& finger, std::vector<Gesture>& gestures)
{
  const bool same = this->Fingers.size() == 1 && this->Fingers[0].id == finger.id;
  if (!same)
  {
    this->MayBeTap = this->MayBeTap && this->Fingers.empty();
    this->Rotating = false;
    this->AnchorX = finger.x;
    this->AnchorY = finger.y;
    return;
  }
  if (!this->Rotating && Distance(finger.x, finger.y, this->AnchorX, this->AnchorY) >
                           this->Thresholds.slop * this->PixelRatio)
  {
    this->Rotating = true;
    this->MayBeTap = false;
  }
  const double dx = finger.x - this->Fingers[0].x, dy = finger.y - this->Fingers[0].y;
  if (this->Rotating && (dx != 0 || dy != 0))
  {
    gestures.push_back({ Gesture::Kind::Rotate, finger.x, finger.y, dx, dy });
  }
}

void GestureRecognizer::MoveTwo(
  const Touch& first, const Touch& second, std::vector<Gesture>& gestures)
{
  const double x = (first.x + second.x) / 2, y = (first.y + second.y) / 2;
  const bool same = this->Pinching && this->Fingers.size() > 1 && this->Fingers[0].id == first.id &&
                    this->Fingers[1].id == second.id;
  if (!same)
  {
    if (this->Pinching)
    {
      gestures.push_back({ Gesture::Kind::PinchEnd });
    }
    this->Pinching = true;
    this->Twisting = false;
    this->PairX = second.x - first.x;
    this->PairY = second.y - first.y;
    gestures.push_back({ Gesture::Kind::PinchBegin, x, y });
    return;
  }
  const Touch &a = this->Fingers[0], &b = this->Fingers[1];
  const double smallest = this->Thresholds.smallestGap * this->PixelRatio;
  const double before = std::max(smallest, Distance(a.x, a.y, b.x, b.y));
  const double after = std::max(smallest, Distance(first.x, first.y, second.x, second.y));
  const double dx = x - (a.x + b.x) / 2, dy = y - (a.y + b.y) / 2;
  Gesture pinch{ Gesture::Kind::Pinch, x, y, dx, dy, after / before };
  this->Twist(b.x - a.x, b.y - a.y, second.x - first.x, second.y - first.y, pinch);
  if (dx != 0 || dy != 0 || after != before || pinch.twistSine != 0)
  {
    gestures.push_back(pinch);
  }
}

// Sets the angle by which two fingers have turned, from their earlier to their current offset. If
// the fingers are close, no angle is set.
void GestureRecognizer::Twist(double fromX, double fromY, double toX, double toY, Gesture& pinch)
{
  struct Angle
  {
    double cosine = 1, sine = 0;
  };
  const double smallest = this->Thresholds.smallestGap * this->PixelRatio;
  const auto between = [&](double ax, double ay, double bx, double by)
  {
    const double a = std::sqrt(ax * ax + ay * ay), b = std::sqrt(bx * bx + by * by);
    return a > smallest && b > smallest
             ? Angle{ (ax * bx + ay * by) / (a * b), (ax * by - ay * bx) / (a * b) }
             : Angle{};
  };
  if (this->Twisting)
  {
    const Angle turned = between(fromX, fromY, toX, toY);
    pinch.twistCosine = turned.cosine;
    pinch.twistSine = turned.sine;
    return;
  }
  const Angle sinceBegin = between(this->PairX, this->PairY, toX, toY);
  this->Twisting = sinceBegin.cosine < 0 || std::abs(sinceBegin.sine) > this->Thresholds.twistSlop;
}

}
