// SPDX-License-Identifier: BSD-3-Clause
// A view as a link for another viewer: see ViewLink.h.
//
// The camera is 35 bytes, as 47 characters of base64url (RFC 4648): the version; focal point and
// distance, each a fixed point number of 5 bytes from -16 to 16 radii; the orientation's four
// numbers, each 3 bytes from -1 to 1; the ratio of the window's sides, 2 bytes, in 1/1024. The most
// significant byte is first.
#include "viewer/session/ViewLink.h"

#include "filters/core/Texts.h"
#include "filters/model/ModelDescription.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::uint8_t placeVersion = 1;
constexpr double mostRadii = 32; // 16 to either side; distances are up to 20, focal points less
constexpr unsigned lengthBytes = 5, turnBytes = 3, aspectBytes = 2;
constexpr double aspectParts = 1024;

std::optional<std::vector<std::uint8_t>> ToBytes(std::string_view text)
{
  const bool isOfUrl = text.find_first_of("+/= \t\r\n") == text.npos;
  return isOfUrl ? Base64Decoded(text) : std::nullopt;
}

// The largest even number that fits into this number of bytes. It is even so that 0, in the middle,
// is stored exactly.
double MostOf(unsigned bytes)
{
  return std::ldexp(1.0, static_cast<int>(8 * bytes)) - 2;
}

// Appends a number from -half to half.
void Put(std::vector<std::uint8_t>& bytes, double number, double half, unsigned count)
{
  const double most = MostOf(count);
  const double part = std::clamp(number / (2 * half) + 0.5, 0.0, 1.0);
  const auto whole = static_cast<std::uint64_t>(std::floor(part * most + 0.5));
  for (unsigned i = count; i-- > 0;)
  {
    bytes.push_back(static_cast<std::uint8_t>(whole >> (8 * i)));
  }
}

double Take(const std::vector<std::uint8_t>& bytes, std::size_t& at, double half, unsigned count)
{
  std::uint64_t whole = 0;
  for (unsigned i = 0; i < count; ++i)
  {
    whole = whole << 8 | bytes[at++];
  }
  const double most = MostOf(count);
  return (static_cast<double>(whole) / most - 0.5) * 2 * half;
}

constexpr double aspectHalf = 0x1p15 / aspectParts;

std::string FormatPlace(const CameraPlace& place)
{
  std::vector<std::uint8_t> bytes{ placeVersion };
  for (const double length :
    { place.focal[0], place.focal[1], place.focal[2], place.distance - mostRadii / 2 })
  {
    Put(bytes, length, mostRadii / 2, lengthBytes);
  }
  const Quaternion& q = place.orientation;
  for (const double part : { q.w, q.x, q.y, q.z })
  {
    Put(bytes, part, 1, turnBytes);
  }
  Put(bytes, place.aspect - aspectHalf, aspectHalf, aspectBytes);
  return Base64Url(bytes);
}

std::optional<CameraPlace> ParsePlace(std::string_view text)
{
  constexpr std::size_t size = 1 + 4 * lengthBytes + 4 * turnBytes + aspectBytes;
  const auto bytes = ToBytes(text.substr(0, 2 * size));
  if (!bytes || bytes->size() != size || bytes->front() != placeVersion)
  {
    return {};
  }
  std::size_t at = 1;
  const auto length = [&] { return Take(*bytes, at, mostRadii / 2, lengthBytes); };
  const auto turn = [&] { return Take(*bytes, at, 1, turnBytes); };
  CameraPlace place;
  for (double& coordinate : place.focal)
  {
    coordinate = length();
  }
  place.distance = length() + mostRadii / 2;
  Quaternion q;
  for (double* part : { &q.w, &q.x, &q.y, &q.z })
  {
    *part = turn();
  }
  place.aspect = Take(*bytes, at, aspectHalf, aspectBytes) + aspectHalf;
  const double square = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  if (!(square > 0.9 && square < 1.1) || !(place.distance > 0) || !(place.aspect > 0))
  {
    return {};
  }
  place.orientation = Quaternion{}.After(q); // of length 1
  return place;
}

// A point has 15 bytes. Two points, 30 bytes, are 40 characters of base64 without padding, so
// distances can be joined.
std::string FormatMeasurements(const std::vector<std::array<Vec3, 2>>& measurements)
{
  std::vector<std::uint8_t> bytes;
  for (const auto& ends : measurements)
  {
    for (const Vec3& point : ends)
    {
      for (const double coordinate : point)
      {
        Put(bytes, coordinate, mostRadii / 2, lengthBytes);
      }
    }
  }
  return Base64Url(bytes);
}

std::optional<std::vector<std::array<Vec3, 2>>> ParseMeasurements(std::string_view text)
{
  constexpr std::size_t size = 2 * 3 * lengthBytes;
  const auto bytes = ToBytes(text);
  if (!bytes || bytes->empty() || text.size() % (size / 3 * 4) != 0 ||
      bytes->size() > size * ViewLink::mostMeasurements)
  {
    return {};
  }
  std::vector<std::array<Vec3, 2>> measurements(bytes->size() / size);
  std::size_t at = 0;
  for (auto& ends : measurements)
  {
    for (Vec3& point : ends)
    {
      for (double& coordinate : point)
      {
        coordinate = Take(*bytes, at, mostRadii / 2, lengthBytes);
      }
    }
  }
  return measurements;
}

// 14 bytes: the normal's three numbers, each 3 bytes from -1 to 1, and the offset.
std::string FormatSection(const SectionPlane& section)
{
  std::vector<std::uint8_t> bytes;
  for (const double part : section.normal)
  {
    Put(bytes, part, 1, turnBytes);
  }
  Put(bytes, section.offset, mostRadii / 2, lengthBytes);
  return Base64Url(bytes);
}

std::optional<SectionPlane> ParseSection(std::string_view text)
{
  constexpr std::size_t size = 3 * turnBytes + lengthBytes;
  const auto bytes = ToBytes(text.substr(0, 2 * size));
  if (!bytes || bytes->size() != size)
  {
    return {};
  }
  std::size_t at = 0;
  SectionPlane section;
  for (double& part : section.normal)
  {
    part = Take(*bytes, at, 1, turnBytes);
  }
  section.offset = Take(*bytes, at, mostRadii / 2, lengthBytes);
  const double square = Dot(section.normal, section.normal);
  if (!(square > 0.9 && square < 1.1))
  {
    return {};
  }
  section.normal = Normalized(section.normal);
  return section;
}

// Each light has 5 bytes: x and y on the disc (2 bytes each, from -1 to 1), and the intensity. The
// relief follows.
constexpr unsigned discBytes = 2, shareBytes = 1;

void PutLightSource(std::vector<std::uint8_t>& bytes, const LightSource& lightSource)
{
  Put(bytes, lightSource.x, 1, discBytes);
  Put(bytes, lightSource.y, 1, discBytes);
  Put(bytes, lightSource.intensity - RakingLight::mostIntensity / 2, RakingLight::mostIntensity / 2,
    shareBytes);
}

LightSource TakeLightSource(const std::vector<std::uint8_t>& bytes, std::size_t& at)
{
  LightSource lightSource;
  lightSource.x = Take(bytes, at, 1, discBytes);
  lightSource.y = Take(bytes, at, 1, discBytes);
  lightSource.intensity =
    Take(bytes, at, RakingLight::mostIntensity / 2, shareBytes) + RakingLight::mostIntensity / 2;
  return lightSource;
}

constexpr std::string_view standardLight = "standard";

constexpr std::array<std::string_view, 3> details{ "view", "level", "full" };

std::optional<ViewLink::Region> ParseRegion(std::string_view text)
{
  ViewLink::Region region;
  const char* end = text.data() + text.size();
  const auto cell = std::from_chars(text.data(), end, region.cell);
  if (cell.ec != std::errc{} || cell.ptr == end || *cell.ptr != '.')
  {
    return {};
  }
  const auto rings = std::from_chars(cell.ptr + 1, end, region.rings);
  const bool isWhole = rings.ec == std::errc{} && rings.ptr == end;
  return isWhole && region.cell > 0 && region.rings >= 1 && region.rings <= 3
           ? std::optional(region)
           : std::nullopt;
}

bool IsHexadecimal(std::string_view text)
{
  return !text.empty() && text.size() <= ViewLink::digestDigits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

bool IsOneOf(std::string_view text, std::initializer_list<std::string_view> words)
{
  return std::find(words.begin(), words.end(), text) != words.end();
}

// False if the key cannot have the value.
bool TakeEntry(ViewLink& link, std::string_view key, std::string_view value)
{
  if (key == "model")
  {
    link.model = value;
    return IsModelId(value);
  }
  if (key == "digest")
  {
    link.digest = value;
    return IsHexadecimal(value);
  }
  if (key == "view")
  {
    link.place = ParsePlace(value);
    return link.place.has_value();
  }
  if (key == "turning")
  {
    link.turning = value == "free" ? Turning::Free : Turning::Upright;
    return IsOneOf(value, { "free", "upright" });
  }
  if (key == "detail")
  {
    const auto found = std::find(details.begin(), details.end(), value);
    link.detail = static_cast<DetailMode>(found - details.begin());
    return found != details.end();
  }
  if (key == "region")
  {
    link.region = ParseRegion(value);
    return link.region.has_value();
  }
  if (key == "distances")
  {
    auto measurements = ParseMeasurements(value);
    link.measurements = measurements ? std::move(*measurements) : link.measurements;
    return measurements.has_value();
  }
  if (key == "section")
  {
    link.section = ParseSection(value);
    return link.section.has_value();
  }
  if (key == "lamps")
  {
    auto lights = ParseLights(value);
    link.lights = lights ? *lights : link.lights;
    return lights.HasValue();
  }
  if (key == "colours")
  {
    link.colors = value;
    return value.substr(0, 3) == "by:" || // the scene checks the rest: appearance/Coloring.h
           IsOneOf(value, { "own", "none", "partition", "resolution" });
  }
  if (key == "light")
  {
    link.light = value;
    return IsOneOf(value, { "relief", "plain" });
  }
  return true;
}

}

std::string FormatLights(const std::optional<RakingLight>& lights)
{
  if (!lights)
  {
    return std::string(standardLight);
  }
  std::vector<std::uint8_t> bytes;
  PutLightSource(bytes, lights->lightSource);
  Put(bytes, lights->relief - 0.5, 0.5, shareBytes);
  if (lights->second)
  {
    PutLightSource(bytes, *lights->second);
  }
  return Base64Url(bytes);
}

Result<std::optional<RakingLight>> ParseLights(std::string_view text)
{
  if (text == standardLight)
  {
    return std::optional<RakingLight>();
  }
  constexpr std::size_t one = 2 * discBytes + 2 * shareBytes,
                        two = one + 2 * discBytes + shareBytes;
  const auto bytes = ToBytes(text.substr(0, 2 * two));
  if (!bytes || (bytes->size() != one && bytes->size() != two))
  {
    return Error{ ErrorCode::InvalidInput, "this does not describe a light" };
  }
  std::size_t at = 0;
  RakingLight light;
  light.lightSource = TakeLightSource(*bytes, at);
  light.relief = Take(*bytes, at, 0.5, shareBytes) + 0.5;
  if (bytes->size() == two)
  {
    light.second = TakeLightSource(*bytes, at);
  }
  return std::optional(Confined(light));
}

std::string FormatViewLink(const ViewLink& link)
{
  std::string text = "model=" + link.model;
  const auto add = [&text](std::string_view key, std::string_view value)
  { text += value.empty() ? "" : "&" + std::string(key) + "=" + std::string(value); };
  add("digest", link.digest.substr(0, ViewLink::digestDigits));
  add("view", link.place ? FormatPlace(*link.place) : "");
  add("turning", link.turning == Turning::Free ? "free" : "");
  add("detail",
    link.detail == DetailMode::View ? "" : details[static_cast<std::size_t>(link.detail)]);
  add("region", link.region
                  ? std::to_string(link.region->cell) + "." + std::to_string(link.region->rings)
                  : "");
  add("distances", FormatMeasurements(link.measurements));
  add("section", link.section ? FormatSection(*link.section) : "");
  add("lamps", link.lights ? FormatLights(link.lights) : "");
  add("colours", link.colors);
  add("light", link.light);
  return text;
}

Result<ViewLink> ParseViewLink(std::string_view text)
{
  if (text.size() > ViewLink::longest)
  {
    return Error{ ErrorCode::InvalidInput, "this link to a view is too long" };
  }
  ViewLink link;
  while (!text.empty())
  {
    const std::string_view entry = text.substr(0, text.find('&'));
    text.remove_prefix(std::min(entry.size() + 1, text.size()));
    const std::size_t equals = std::min(entry.find('='), entry.size());
    const std::string_view key = entry.substr(0, equals);
    const std::string_view value = entry.substr(std::min(equals + 1, entry.size()));
    if (!TakeEntry(link, key, value))
    {
      return Error{ ErrorCode::InvalidInput,
        "this link to a view has an invalid value for " + std::string(key) };
    }
  }
  if (link.model.empty())
  {
    return Error{ ErrorCode::InvalidInput, "this link does not name a model" };
  }
  return link;
}

}
