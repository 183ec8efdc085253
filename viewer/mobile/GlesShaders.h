// SPDX-License-Identifier: BSD-3-Clause
// The shaders of GlesRenderer, in OpenGL ES Shading Language 3.00. Internal to viewer/mobile.
//
// Everything is highp: on phones mediump has 16 bits, too few for positions and for the power of a
// highlight. The shaders compute the same as VTK does for the same scene.
#pragma once

namespace kdstream::shaders
{

inline constexpr const char* header = "#version 300 es\n"
                                      "precision highp float;\n";

// One triangle that covers the whole picture, as far away as possible. It is made only from vertex
// numbers.
inline constexpr const char* backgroundVertex = R"(
out float height;
void main()
{
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  height = 0.5 + 0.5 * corner.y;
  gl_Position = vec4(corner, 1.0, 1.0);
})";

inline constexpr const char* backgroundFragment = R"(
in float height;
uniform vec3 bottom, top;
out vec4 fragment;
void main()
{
  fragment = vec4(mix(bottom, top, height), 1.0);
})";

// Subtracts the eye from positions first, so that precision is not lost near the eye. Then
// transforms into the camera's coordinates, and to the window: `projection` has the two scales and
// the two terms of the depth. CUT: a plane cuts away what is above it. TEXTURED: a texture gives
// the colour; until it is loaded, and where it is transparent, the vertices' colours are used.
// - radius: of a cloud's splat.
// - away: from the vertex's place to where it morphs from. parentNormal: the normal that it had
// there; its last component is 0 if it does not morph. toGo: the remaining share of the way, from 1
// to 0.
// - place: in the texture.
// - splatPixels: pixels per unit of length at distance 1; smallest and largest diameter in pixels.
// - splat: diameter in pixels, radius.
// - section: the plane's normal, and how far the origin is above the plane.
// - fromEye, above: centroid, so that they are those of a place in the triangle even at its edge.
inline constexpr const char* surfaceVertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 normal;
layout(location = 2) in vec4 color;
layout(location = 3) in float radius;
layout(location = 4) in vec3 away;
layout(location = 5) in vec4 parentNormal;
#ifdef TEXTURED
layout(location = 6) in vec2 place;
out vec2 texturePlace;
#endif
uniform float toGo;
uniform vec3 eye;
uniform mat3 turn;
uniform vec4 projection;
uniform vec3 splatPixels;
out vec3 viewPosition;
out vec3 viewNormal;
out vec3 smoothColor;
flat out vec3 flatColor;
flat out vec2 splat;
centroid out float fromEye;
#ifdef CUT
uniform vec4 section;
centroid out float above;
#endif
void main()
{
  vec3 here = position + toGo * away;
#ifdef CUT
  above = dot(here, section.xyz) + section.w;
#endif
  viewPosition = turn * (here - eye);
  viewNormal = turn * mix(normal.xyz, parentNormal.xyz, toGo * parentNormal.w);
  smoothColor = flatColor = color.rgb;
#ifdef TEXTURED
  texturePlace = place;
#endif
  gl_Position = vec4(projection.xy * viewPosition.xy,
    projection.z * viewPosition.z + projection.w, -viewPosition.z);
  fromEye = -viewPosition.z;
  splat.x = clamp(2.0 * radius * splatPixels.x / gl_Position.w, splatPixels.y, splatPixels.z);
  splat.y = 0.5 * splat.x * gl_Position.w / splatPixels.x;
  gl_PointSize = splat.x;
})";

// Multiplies a fragment's colour by the light that ambient occlusion leaves. Must follow
// occlusionDepths and occlusionLeft (viewer/session/appearance/OcclusionShaders.h). If there is no
// occlusion, the grid has no texels. texels: the size of a pixel, in texels of the half-size
// picture.
inline constexpr const char* darkened = R"(
uniform vec2 texels;
out vec4 fragment;
vec4 darkened(vec3 color, float away)
{
  float left = grid.x > 0.0 ? lightLeft(gl_FragCoord.xy * texels, away) : 1.0;
  return vec4(left * min(color, 1.0), 1.0);
})";

// Phong's model with the two directional lights of SceneAppearance.h. One of the main functions
// below must follow. RELIEF: ridges (where normals diverge) are lighter; `relief` says by how much,
// and the number of pixels in which a bend of a radian has the full effect. smoothness: whether
// colours are interpolated, 1 or 0. depthRange: nearest, farthest, 1 / their difference.
inline constexpr const char* light = R"(
in vec3 viewPosition;
in vec3 viewNormal;
in vec3 smoothColor;
flat in vec3 flatColor;
flat in vec2 splat;
uniform float smoothness;
uniform vec3 lightDirection[2];
uniform vec3 lightColor[2];
uniform vec4 material;
uniform vec3 highlightColor;
uniform vec3 depthRange;
#ifdef CUT
centroid in float above;
#endif
#ifdef TEXTURED
in vec2 texturePlace;
uniform sampler2D picture;
#endif
#ifdef RELIEF
uniform vec2 relief;
#endif
vec3 lit(vec3 normal)
{
  vec3 baseColor = mix(flatColor, smoothColor, smoothness);
#ifdef TEXTURED
  vec4 texel = texture(picture, texturePlace);
  baseColor = mix(baseColor, texel.rgb, texel.a);
#endif
  vec3 toEye = normalize(-viewPosition);
  vec3 diffuse = vec3(0.0);
  vec3 specular = vec3(0.0);
  for (int i = 0; i < 2; ++i)
  {
    float facing = dot(normal, lightDirection[i]);
    if (facing > 0.0)
    {
      diffuse += facing * lightColor[i];
      float mirrored = max(0.0, dot(reflect(-lightDirection[i], normal), toEye));
      specular += pow(mirrored, material.w) * lightColor[i];
    }
  }
  return baseColor * (material.x + material.y * diffuse) + highlightColor * material.z * specular;
})";

// The visible side is lit, whichever way a triangle faces. Near an outline, an interpolated normal
// may face away a little; then it is clamped (as in viewer/rendering/ScenePart.cxx). If no triangle
// at a point has an area, the normal faces the eye.
// With SwiftShader, but not with Mesa's software driver, a few pixels at outlines are dark or
// bright: samples there count as back faces and are lit as the other side. Probably it rounds the
// corners of thin triangles, which turns them over. Clamping for back faces, too, would light
// insides of bowls wrongly near their outlines.
inline constexpr const char* surfaceFragment = R"(
centroid in float fromEye;
void main()
{
  vec3 normal = dot(viewNormal, viewNormal) > 0.0 ? normalize(viewNormal) : vec3(0.0, 0.0, 1.0);
  if (normal.z < 0.0)
  {
    normal = gl_FrontFacing && normal.z > -0.8 ? normalize(vec3(normal.xy, 0.0)) : -normal;
  }
  vec3 color = lit(normal);
#ifdef RELIEF
  float bend = relief.y * normal.z * (dFdx(normal.x) + dFdy(normal.y));
  color *= 1.0 + relief.x * clamp(bend, -1.0, 1.0);
#endif
  fragment = darkened(color, fromEye);
#ifdef CUT
  if (above > 0.0)
  {
    discard;
  }
#endif
})";

inline constexpr const char* capFragment = R"(
flat in vec3 flatColor;
centroid in float fromEye;
void main()
{
  fragment = darkened(flatColor, fromEye);
})";

// Points are round splats. Their rims are bent away from the eye, so that neighbours meet halfway.
// Points with normals are lit on the visible side. Points without normals are drawn as shallow
// domes, darker with the distance (as in viewer/rendering/CloudSplats.cxx). far: 0 at the nearest
// depth, 1 at the farthest.
inline constexpr const char* cloudFragment = R"(
void main()
{
#ifdef CUT
  if (above > 0.0)
  {
    discard;
  }
#endif
  vec2 place = 2.0 * gl_PointCoord - 1.0;
  float square = dot(place, place);
  if (square > 1.0)
  {
    discard;
  }
  float z = viewPosition.z - splat.y * square;
  float far = clamp((-z - depthRange.x) * depthRange.z, 0.0, 1.0);
  gl_FragDepth = min(far * depthRange.y / -z, 1.0);
  vec3 normal = normalize(vec3(0.35 * place.x, -0.35 * place.y, 1.0));
  float shade = 1.0 - 0.4 * far;
  if (dot(viewNormal, viewNormal) > 0.5)
  {
    normal = normalize(viewNormal.z < 0.0 ? -viewNormal : viewNormal);
    shade = 1.0;
  }
  fragment = darkened(shade * lit(normal), -z);
})";

}
