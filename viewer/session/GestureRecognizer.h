// SPDX-License-Identifier: BSD-3-Clause
// Recognizes gestures of fingers: the first step of "navigate" in the pipeline picture.
//
// One finger rotates, two pan and pinch, a double tap picks (paper sections 5.2 and 5.3). Nothing
// here knows of cameras or meshes; ViewerSession decides what a gesture does.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace kdstream
{

struct Touch
{
  std::int64_t id = 0; // the same as long as the finger is down
  double x = 0;        // window pixels from the left
  double y = 0;        // window pixels from the top
  bool operator==(const Touch&) const = default;
};

// All fingers that touch the screen at one time; empty: all are lifted.
struct TouchFrame
{
  double time = 0; // seconds, from any origin
  std::vector<Touch> touches;
  bool operator==(const TouchFrame&) const = default;
};

struct Gesture
{
  enum class Kind
  {
    Rotate,     // one finger moved from (x, y) - (dx, dy) to (x, y)
    RotateEnd,  // that finger was lifted at (x, y)
    PinchBegin, // two fingers are down, their middle at (x, y)
    Pinch,      // the middle of two fingers moved by (dx, dy) to (x, y), their gap grew by `scale`,
                // and they turned clockwise by the angle of (twistCosine, twistSine)
    PinchEnd,   // fewer than two fingers are left
    Tap, // a finger was put down and lifted at (x, y); also sent before a DoubleTap's second tap
    DoubleTap // the second of two taps, at (x, y)
  };
  Kind kind = Kind::Tap;
  double x = 0, y = 0;
  double dx = 0, dy = 0;
  double scale = 1;
  double twistCosine = 1, twistSine = 0;
  bool operator==(const Gesture&) const = default;
};

// Lengths are in points: pixels of the window divided by its pixel ratio, so that a finger is
// equally wide on all screens.
struct GestureThresholds
{
  double slop = 8; // a finger that has moved no further may still be a tap, and does not rotate
  double tapSeconds = 0.3; // longest time that a finger is down for a tap
  double betweenSeconds =
    0.35; // longest time from the end of a tap to the beginning of the next, for a double tap
  double betweenPoints = 40; // longest distance between these two taps
  double smallestGap = 16;   // a smaller gap of two fingers counts as this: scales stay bounded
  double twistSlop = 0.17;   // sine of the angle that two fingers must turn by to begin a twist
};

// Turns the touches of one frame into gestures. Rules:
// - A *sequence* lasts from the moment the first finger is put down until the last one is lifted.
//   It is a tap only if a single finger made it, stayed within the slop, and was down for at most
//   tapSeconds. Two taps close in time and place are a double tap; a third one counts as a first
//   one again.
// - If there are more than two fingers, the first two count; the others are ignored until one of
//   the two is lifted. When the two change, measuring starts again, so that nothing jumps.
// - Two fingers are never lifted at the same moment. So the finger that remains must move by the
//   slop before it rotates.
// - The product of a pinch's scales is the ratio of its last gap to its first (gaps below
//   smallestGap count as smallestGap). Touches with coordinates that are not finite are ignored; of
//   touches with the same id the first counts; a time that goes backwards or is not finite counts
//   as the last one. O(touches²) a frame.
class GestureRecognizer
{
public:
  explicit GestureRecognizer(const GestureThresholds& thresholds = {});

  // Pixels of the window for one point of the screen, above 0 (1 until it is set).
  void SetPixelRatio(double ratio);

  std::vector<Gesture> HandleTouches(const TouchFrame& frame);

  // Whether any finger is down.
  bool Touching() const { return !this->Fingers.empty(); }

  // Forgets fingers and taps.
  void Reset();

private:
  struct LastTap
  {
    double time = 0, x = 0, y = 0;
  };

  std::vector<Touch> Accept(const std::vector<Touch>& touches) const;
  void EndSequence(double time, std::vector<Gesture>& gestures);
  void Move(const std::vector<Touch>& fingers, std::vector<Gesture>& gestures);
  void MoveOne(const Touch& finger, std::vector<Gesture>& gestures);
  void MoveTwo(const Touch& first, const Touch& second, std::vector<Gesture>& gestures);
  void Twist(double fromX, double fromY, double toX, double toY, Gesture& pinch);

  GestureThresholds Thresholds;
  double PixelRatio = 1;
  double Time = 0;
  std::vector<Touch> Fingers; // in the order in which they came, with their latest positions
  double SequenceBegin = 0;
  bool MayBeTap = false;           // so far there was one finger, within the slop
  bool Rotating = false;           // the finger has left the slop
  bool Pinching = false;           // PinchBegin was sent, PinchEnd was not
  bool Twisting = false;           // two fingers have turned by more than twistSlop
  double PairX = 0, PairY = 0;     // the pair's direction at PinchBegin
  double AnchorX = 0, AnchorY = 0; // where the single finger was when it became the only one
  std::optional<LastTap> Previous;
};

}
