// SPDX-License-Identifier: BSD-3-Clause
// Ambient occlusion in screen space (SSAO): what every renderer computes from the depths of a
// picture, in shading language that OpenGL 3.2 and OpenGL ES 3.0 both know. Step "render" of the
// pipeline picture.
//
// Less ambient light reaches cavities: grooves, folds and the feet of protrusions become darker,
// also on the side away from the lights. Around each pixel the horizons are searched along lines in
// the picture, always in two opposite directions together (Bavoil, Sainz, Dimitrov: Image-Space
// Horizon-Based Ambient Occlusion, SIGGRAPH 2008). On a plane of any slope one horizon rises by as
// much as the other falls, so no normals are needed. The search radius is a share of the picture's
// height, so every zoom shows relief of a matching size.
//
// Three passes in half of the picture's width and height:
// 1. the depths;
// 2. occluded light, with lines of another direction in each of 4 × 4 neighbours;
// 3. the mean of those neighbours that are about as far away.
// Then each sample of the model in the picture is multiplied by the light that this mean leaves at
// the sample's own depth (joint bilateral upsampling, Kopf, Cohen, Lischinski, Uyttendaele,
// SIGGRAPH 2007). A pixel at an edge has samples of two surfaces: a near bright one must not take
// the light of a dark one behind it, nor the other way round.
#pragma once

namespace kdstream
{

inline constexpr double occlusionReach = 0.08;   // of the picture's height
inline constexpr double occlusionStrength = 1.4; // 1: as much as is geometrically hidden

// A side of the passes' render targets, for this side of the picture.
constexpr int HalfSide(int side)
{
  return (side + 1) / 2;
}

namespace shaders
{

// Comes before the following shaders. depths: 0-1, 1 for the background. projection: the scales of
// x and y, and the two terms of the depth, as in an OpenGL matrix. grid: width and height of the
// half picture, reach in its texels, and the reach divided by the distance from the eye.
inline constexpr const char* occlusionDepths = R"(
uniform highp sampler2D depths;
uniform vec4 projection;
uniform vec4 grid;
float distanceOf(float depth)
{
  return projection.w / (2.0 * depth - 1.0 + projection.z);
}
float distanceAt(vec2 place)
{
  return distanceOf(texture(depths, place).x);
}
vec3 positionAt(vec2 place)
{
  return distanceAt(place) * vec3((2.0 * place - 1.0) / projection.xy, -1.0);
}
)";

// Writes how much is occluded, 0-1, to the red channel. All samples of a line are multiples of one
// vector of whole texels: if each were rounded by itself, a plane would seem to rise on both sides.
// A line has 6 samples, at increasing distances up to the reach.
// - `unsure` is subtracted from a rise: the length that `depthSteps` steps of a 24-bit depth have
//   there. If the eye is inside the model's box, one step is as long as a texel, and smooth
//   surfaces would get visible bands.
// - rise: the sine of the angle by which a place rises from the plane across the line of sight; -1
//   for the background, out of reach, and outside the picture. part: by which part of a step the
//   samples are shifted.
// - facet: FacetLength, in the unit of the projection. If it is longer than the reach, concave
//   edges between triangles are not relief of the model but a limit of its resolution, and shallow
//   ones are ignored.
inline constexpr const char* occlusionFragment = R"(
out vec4 fragment;
vec3 here, toEye;
float reach;
float unsure;
uniform float facet;
const float depthSteps = 1.5;
const vec2 ways[4] = vec2[4](vec2(1.0, 0.0), vec2(2.0, 1.0), vec2(1.0, 1.0), vec2(1.0, 2.0));
float rise(vec2 texel)
{
  vec2 place = texel / grid.xy;
  if (place != clamp(place, 0.0, 1.0) || texture(depths, place).x == 1.0)
  {
    return -1.0;
  }
  vec3 way = positionAt(place) - here;
  float square = max(dot(way, way), 1e-12 * reach * reach);
  float near = clamp(2.0 - 2.0 * square / (reach * reach), 0.0, 1.0);
  return mix(-1.0, (dot(way, toEye) - unsure) * inversesqrt(square), near);
}
void main()
{
  vec2 texel = gl_FragCoord.xy;
  vec2 place = texel / grid.xy;
  float closed = 0.0;
  if (texture(depths, place).x < 1.0)
  {
    here = positionAt(place);
    toEye = -normalize(here);
    reach = grid.w * -here.z;
    unsure = depthSteps * 1.2e-7 * here.z * here.z / abs(projection.w);
    vec2 cell = mod(floor(texel), 4.0);
    vec2 way = ways[int(mod(cell.x + 2.0 * cell.y, 4.0))];
    float most = max(grid.z / length(way), 1.0);
    float part = 0.25 * cell.y;
    float shallow = 0.13 * clamp(facet / reach - 0.3, 0.0, 1.0);
    for (int i = 0; i < 2; ++i)
    {
      float ahead = -1.0, behind = -1.0;
      for (int k = 0; k < 6; ++k)
      {
        float share = (float(k) + part) / 6.0;
        vec2 far = way * floor(1.5 + (most - 1.0) * share * share);
        ahead = max(ahead, rise(texel + far));
        behind = max(behind, rise(texel - far));
      }
      float risen = clamp(0.5 * (ahead + behind) - 0.02, 0.0, 1.0);
      closed += risen * clamp((risen - shallow) / max(shallow, 0.001), 0.0, 1.0);
      way = vec2(-way.y, way.x);
    }
  }
  fragment = vec4(0.5 * closed);
})";

// The mean of 4 × 4 neighbours, times strength.
inline constexpr const char* occlusionMeanFragment = R"(
uniform sampler2D occluded;
uniform float strength;
out vec4 fragment;
void main()
{
  float here = distanceAt(gl_FragCoord.xy / grid.xy);
  float sum = 0.0, all = 1e-6;
  for (int i = 0; i < 16; ++i)
  {
    vec2 texel = gl_FragCoord.xy + vec2(i % 4 - 2, i / 4 - 2);
    vec2 place = clamp(texel, vec2(0.5), grid.xy - 0.5) / grid.xy;
    float like = clamp(2.0 - 4.0 * abs(distanceAt(place) - here) / (grid.w * here), 0.0, 1.0);
    sum += like * texture(occluded, place).x;
    all += like;
  }
  fragment = vec4(min(strength * sum / all, 1.0));
})";

// The light that is left of a sample, 0-1. texel: its place in the half picture; away: its distance
// from the eye. The texels around it count by how near they are in the picture and in depth, where
// the unit is a texel's width there. If none of the nearest four texels has this depth, as at the
// tip of a thin part, the nearest 16 are used.
inline constexpr const char* occlusionLeft = R"(
uniform sampler2D occluded;
vec2 takenAround(vec2 texel, float away, float wide)
{
  vec2 first = floor(texel + 0.5) - wide;
  float unit = away * grid.w / grid.z;
  vec2 sum = vec2(0.0);
  for (float y = 0.5; y < 2.0 * wide; y += 1.0)
  {
    for (float x = 0.5; x < 2.0 * wide; x += 1.0)
    {
      vec2 at = first + vec2(x, y);
      vec2 share = max(1.0 - abs(at - texel) / wide, 0.0);
      vec2 place = clamp(at, vec2(0.5), grid.xy - 0.5) / grid.xy;
      float apart = min(abs(distanceAt(place) - away) / unit, 1e4);
      float like = share.x * share.y / (1.0 + apart * apart * apart * apart);
      sum += like * vec2(texture(occluded, place).x, 1.0);
    }
  }
  return sum;
}
float lightLeft(vec2 texel, float away)
{
  vec2 taken = takenAround(texel, away, 1.0);
  if (taken.y < 0.01)
  {
    taken = takenAround(texel, away, 2.0);
  }
  return 1.0 - taken.x / taken.y;
}
)";

}

}
