// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with VRML: the effect of transforms, which children of a scene are shown, and
// which colours belong to which shape. The expected numbers come from the specification, not from a
// reader. Also: files that a hostile file must not reach.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"

#include <sys/stat.h>

#include <cmath>
#include <map>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

const std::string header = "#VRML V2.0 utf8\n";
const std::string cubePoints = "coord Coordinate { point [ -1 -1 -1, 1 -1 -1, 1 1 -1, -1 1 -1, "
                               "-1 -1 1, 1 -1 1, 1 1 1, -1 1 1 ] }";
const std::string cubeFaces = "coordIndex [ 0 3 2 1 -1 4 5 6 7 -1 0 1 5 4 -1 1 2 6 5 -1 2 3 7 6 -1 "
                              "3 0 4 7 -1 ]";
// A cube from -1 to 1, whose volume is 8.
const std::string cube =
  "Shape { geometry IndexedFaceSet { " + cubePoints + " " + cubeFaces + " } }\n";

std::string Transformed(const std::string& by, const std::string& children)
{
  return "Transform { " + by + " children [ " + children + " ] }\n";
}

void ExpectBox(const Mesh& mesh, const Vec3& lo, const Vec3& hi, double tolerance = 1e-5)
{
  const Box box = BoxOf(mesh);
  for (std::size_t k = 0; k < 3; ++k)
  {
    EXPECT_NEAR(box.lo[k], lo[k], tolerance) << "axis " << k;
    EXPECT_NEAR(box.hi[k], hi[k], tolerance) << "axis " << k;
  }
}

std::string Warning(const std::string& what)
{
  return "kdstream-convert: warning: in.wrl: " + what + "\n";
}

// The warning that one node was left out.
std::string LeftOut(const std::string& which)
{
  return Warning("1 node cannot be read and is left out: " + which);
}

class TestConvertVrml : public ConvertTest
{
protected:
  Mesh Scene(const std::string& body, const std::string& warnings = "")
  {
    this->WriteText("in.wrl", header + body);
    return this->Converted("in.wrl", warnings);
  }
  void Refused(const std::string& body, const std::string& what)
  {
    SCOPED_TRACE(body.substr(0, 200));
    this->WriteText("in.wrl", header + body);
    this->ExpectError("in.wrl", what);
  }
};

}

TEST_F(TestConvertVrml, OwnFilesComeBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh mesh = AsFloats(named.mesh);
    ASSERT_TRUE(WriteMesh(this->Folder / "in.wrl", mesh));
    const std::string said = this->Convert("in.wrl").err;
    EXPECT_TRUE(said.empty() ||
                said.starts_with(Warning("coordinates are read as floats: at ").substr(0, 70)))
      << said;
    const Mesh read = this->Read("out.ply");
    EXPECT_EQ(read.points, mesh.points);
    EXPECT_EQ(PointMultiset(read), PointMultiset(mesh)); // checks the signs of zeros, too
    EXPECT_EQ(read.triangles, mesh.triangles);
    EXPECT_EQ(read.scalarType, ScalarType::Float32);
  }
}

TEST_F(TestConvertVrml, RotationsTurn)
{
  const Mesh turned = this->Scene(Transformed("rotation 0 0 1 0.7853982", cube));
  EXPECT_EQ(turned.points.size(), 8U);
  EXPECT_EQ(turned.triangles.size(), 12U);
  ExpectBox(
    turned, { -std::sqrt(2.0), -std::sqrt(2.0), -1 }, { std::sqrt(2.0), std::sqrt(2.0), 1 });
  EXPECT_NEAR(VolumeOf(turned), 8, 1e-5);
}

// Two rotations by 45 degrees, one inside the other, rotate by 90 degrees.
TEST_F(TestConvertVrml, NestedRotationsAddUp)
{
  const Mesh nested = this->Scene(Transformed("rotation 0 0 1 0.7853982",
    Transformed("translation 10 0 0",
      Transformed("rotation 0 0 1 0.7853982", Transformed("translation 2 0 0", cube)))));
  const double s = std::sqrt(0.5);
  ExpectBox(nested, { 10 * s - 1, 10 * s + 2 - 1, -1 }, { 10 * s + 1, 10 * s + 2 + 1, 1 });
  const Mesh aside = this->Scene(Transformed("translation 10 0 0",
    Transformed("rotation 0 1 0 1.5707963", Transformed("translation 0 0 3", cube))));
  ExpectBox(aside, { 12, -1, -1 }, { 14, 1, 1 });
}

// The numbers were computed by hand from VRML97, 6.52: T C R SR S -SR -C.
TEST_F(TestConvertVrml, CentersAndScaleOrientations)
{
  // A quarter turn around (1, 0, 0): the cube around the origin moves to (1, -1, 0).
  ExpectBox(this->Scene(Transformed("center 1 0 0 rotation 0 0 1 1.5707963", cube)), { 0, -2, -1 },
    { 2, 0, 1 });
  // Twice as long along the diagonal: the corner (1, 1) moves to (2, 2), and the corner (1, -1)
  // stays.
  const Mesh along = this->Scene(Transformed("scale 2 1 1 scaleOrientation 0 0 1 0.7853982", cube));
  ExpectBox(along, { -2, -2, -1 }, { 2, 2, 1 });
  EXPECT_NEAR(VolumeOf(along), 16, 1e-4);
  EXPECT_NEAR(AreaOf(along), 2 * 8 + 4 * 2 * std::sqrt(10.0), 1e-4);
  // Scaled relative to its corner (1, 1, 1).
  ExpectBox(
    this->Scene(Transformed("center 1 1 1 scale 3 3 3", cube)), { -5, -5, -5 }, { 1, 1, 1 });
}

TEST_F(TestConvertVrml, WhatIsMirroredKeepsItsOutside)
{
  EXPECT_NEAR(VolumeOf(this->Scene(Transformed("scale -1 1 1", cube))), 8, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene(Transformed("scale -2 -1 -3", cube))), 48, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene(Transformed("scale -1 -1 1", cube))), 8, 1e-9);
  const Mesh inwards = this->Scene(
    "Shape { geometry IndexedFaceSet { ccw FALSE " + cubePoints + " " + cubeFaces + " } }");
  EXPECT_NEAR(VolumeOf(inwards), -8, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->Scene(Transformed("scale 1 1 -1", "Shape { geometry Box { size 2 2 2 } }"))), 8,
    1e-9);
}

TEST_F(TestConvertVrml, NormalsTurnWithTheirFaces)
{
  const std::string leaning =
    "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 0 1 0, 1 0 1 ] } "
    "coordIndex [ 0 1 2 -1 ] normal Normal { vector [ 1 0 -1, 1 0 -1, 1 0 -1 ] } } }";
  for (const std::string by : { "scale 3 1 1", "scale -3 1 2", "rotation 1 2 3 0.7 scale 1 2 5" })
  {
    SCOPED_TRACE(by);
    const Mesh read = this->Scene(Transformed(by, leaning));
    const std::vector<double> n = ValuesOf(read, "Normals");
    ASSERT_EQ(n.size(), 9U);
    const Triangle t = read.triangles[0];
    const Vec3 face = Cross(
      Minus(read.points[t[1]], read.points[t[0]]), Minus(read.points[t[2]], read.points[t[0]]));
    EXPECT_NEAR(Dot({ n[0], n[1], n[2] }, face), std::sqrt(2.0) * Length(face), 1e-4);
  }
}

TEST_F(TestConvertVrml, SwitchesShowWhatTheyChoose)
{
  const std::string box = Transformed("translation 5 0 0", "Shape { geometry Box { } }");
  const Mesh none = this->Scene("Switch { whichChoice -1 choice [ " + cube + " ] }\n" + box);
  ExpectBox(none, { 4, -1, -1 }, { 6, 1, 1 });
  EXPECT_EQ(none.points.size(), 8U);
  ExpectBox(this->Scene("Switch { whichChoice 1 choice [ " + cube + box + " ] }"), { 4, -1, -1 },
    { 6, 1, 1 });
  ExpectBox(this->Scene("Switch { choice [ " + cube + " ] }\n" + box), { 4, -1, -1 }, { 6, 1, 1 });
  this->Refused("Switch { whichChoice 7 choice [ " + cube + " ] }", "holds no points");
}

TEST_F(TestConvertVrml, TheFinestLevelOfDetailIsTaken)
{
  const std::string coarse = "Shape { geometry Box { size 20 20 20 } }";
  for (const std::string range : { "", "range [ 0.001 0.002 ]", "range [ 100 ] center 5000 0 0" })
  {
    SCOPED_TRACE(range);
    const Mesh fine = this->Scene(Transformed(
      "translation 1000 0 0", "LOD { " + range + " level [ " + cube + " , " + coarse + " ] }"));
    ExpectBox(fine, { 999, -1, -1 }, { 1001, 1, 1 });
  }
}

TEST_F(TestConvertVrml, PrimitivesHaveTheirVolumes)
{
  const double pi = std::acos(-1.0);
  const auto shape = [](const std::string& geometry)
  { return "Shape { geometry " + geometry + " }"; };
  const Mesh box = this->Scene(shape("Box { size 2 4 6 }"));
  EXPECT_EQ(box.points.size(), 8U);
  EXPECT_EQ(box.triangles.size(), 12U);
  EXPECT_NEAR(VolumeOf(box), 48, 1e-9);
  const Mesh sphere = this->Scene(shape("Sphere { radius 3 }"));
  ExpectBox(sphere, { -3, -3, -3 }, { 3, 3, 3 }, 0.1);
  EXPECT_NEAR(VolumeOf(sphere), 36 * pi, 36 * pi * 0.1);
  const Mesh cone = this->Scene(shape("Cone { bottomRadius 2 height 3 }"));
  ExpectBox(cone, { -2, -1.5, -2 }, { 2, 1.5, 2 }, 0.1);
  EXPECT_NEAR(VolumeOf(cone), 4 * pi, 4 * pi * 0.1);
  const Mesh cylinder = this->Scene(shape("Cylinder { radius 2 height 3 }"));
  EXPECT_NEAR(VolumeOf(cylinder), 12 * pi, 12 * pi * 0.1);
  const Mesh open = this->Scene(shape("Cylinder { radius 2 height 3 top FALSE bottom FALSE }"));
  EXPECT_NEAR(AreaOf(open), 12 * pi, 12 * pi * 0.1);
  const Mesh extrusion = this->Scene(shape(
    "Extrusion { crossSection [ 1 1, 1 -1, -1 -1, -1 1, 1 1 ] spine [ 0 0 0, 0 2 0, 0 5 0 ] }"));
  ExpectBox(extrusion, { -1, 0, -1 }, { 1, 5, 1 });
  EXPECT_NEAR(VolumeOf(extrusion), 20, 1e-4);
  EXPECT_EQ(extrusion.points.size(), 12U);
}

TEST_F(TestConvertVrml, GridsAreRowsOfHeights)
{
  const Mesh grid =
    this->Scene("Shape { geometry ElevationGrid { xDimension 3 zDimension 2 "
                "xSpacing 2 zSpacing 5 height [ 0 0 0, 0 0 4 ] colorPerVertex FALSE "
                "color Color { color [ 1 0 0, 0 0 1 ] } } }");
  ExpectBox(grid, { 0, 0, 0 }, { 4, 4, 5 });
  EXPECT_EQ(grid.triangles.size(), 4U);
  for (const Triangle& t : grid.triangles)
  {
    EXPECT_GT(Cross(Minus(grid.points[t[1]], grid.points[t[0]]),
                Minus(grid.points[t[2]], grid.points[t[0]]))[1],
      0);
  }
  const std::vector<double> rgb = ValuesOf(grid, "RGB");
  for (const Triangle& t : grid.triangles)
  {
    const bool left = grid.points[t[0]][0] + grid.points[t[1]][0] + grid.points[t[2]][0] < 6.5;
    for (const VertexId v : t)
    {
      EXPECT_EQ(rgb[3 * v], left ? 255 : 0);
    }
  }
}

TEST_F(TestConvertVrml, ProtosAreWhatTheyStandFor)
{
  const Mesh read = this->Scene(
    "PROTO Post [ field SFVec3f at 0 0 0 field SFVec3f size 1 1 1 ] { Transform { translation IS "
    "at children [ Shape { geometry Box { size IS size } } ] } }\n"
    "Post { at 5 0 0 }\nTransform { rotation 0 0 1 1.5707963 children [ Post { at 3 0 0 size 2 2 2 "
    "} ] }\n");
  ExpectBox(read, { -1, -0.5, -1 }, { 5.5, 4, 1 });
  EXPECT_NEAR(VolumeOf(read), 1 + 8, 1e-5);
}

// After a second PROTO with the same name, nodes use the second one. In the body of a PROTO, a
// PROTO that is defined there counts only there.
TEST_F(TestConvertVrml, TheLaterOfTwoProtosCounts)
{
  const auto box = [](const std::string& size)
  { return "Shape { geometry Box { size " + size + " } }"; };
  const auto proto = [&](const std::string& size) { return "PROTO A [ ] { " + box(size) + " }\n"; };
  const std::string reported = "): nodes after it take that one";
  EXPECT_NEAR(VolumeOf(this->Scene(proto("1 1 1") + "A { }\n" + proto("2 2 2") +
                                     Transformed("translation 5 0 0", "DEF X A { }") +
                                     Transformed("translation 9 0 0", "USE X"),
                Warning("a second PROTO 'A' (line 4" + reported))),
    1 + 8 + 8, 1e-9);
  // The second PROTO has other fields.
  EXPECT_NEAR(VolumeOf(this->Scene(proto("1 1 1") + "PROTO A [ field SFVec3f t 1 1 1 ] { " +
                                     box("IS t") + " }\nA { t 2 3 4 }",
                Warning("a second PROTO 'A' (line 3" + reported))),
    24, 1e-9);
  // The second PROTO uses the first one.
  EXPECT_NEAR(VolumeOf(this->Scene(proto("1 1 1") + "PROTO A [ ] { Group { children [ A { } " +
                                     Transformed("translation 5 0 0", "A { }") + " ] } }\nA { }",
                Warning("a second PROTO 'A' (line 3" + reported))),
    2, 1e-9);
  // A PROTO that is defined in a body is unknown after the body.
  const std::string outer = "PROTO B [ ] { " + proto("2 2 2") + " A { } }\n";
  EXPECT_NEAR(VolumeOf(this->Scene(proto("1 1 1") + outer + "A { }\n" +
                                   Transformed("translation 5 0 0", "B { }") +
                                   Transformed("translation 9 0 0", "A { }"))),
    1 + 8 + 1, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene(
                outer + proto("1 1 1") + "A { }\n" + Transformed("translation 5 0 0", "B { }"))),
    1 + 8, 1e-9);
  // Outside of that PROTO the name is unknown, unless another PROTO has it.
  EXPECT_NEAR(VolumeOf(this->Scene(outer + "B { }\n" + Transformed("translation 9 0 0", "A { }"),
                LeftOut("'A', which is a PROTO only within the body of another (line 5)"))),
    8, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->Scene(proto("1 1 1") + "EXTERNPROTO A [ ] \"a.wrl\"\nA { }\n" + box("2 2 2"),
      LeftOut("'A', which EXTERNPROTO takes from another file (line 4)"))),
    8, 1e-9);
}

// A field that IS a name which its PROTO does not have keeps its own value, with a warning.
TEST_F(TestConvertVrml, FieldsAreThoseOfTheirProtos)
{
  const std::string own = "Shape { geometry Box { size IS ";
  const std::string proto = "PROTO A [ field SFVec3f s 4 4 4 ] { ";
  const auto reported = [](const std::string& what)
  { return Warning("1 field is unknown in the format and is left out: " + what); };
  EXPECT_NEAR(
    VolumeOf(this->Scene(proto + own + "t } } }\nA { }",
      reported("'size' of 'Box' (line 2), which IS 't', but its PROTO 'A' has no such field"))),
    8, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->Scene(proto + "PROTO B [ ] { " + own + "s } } } B { } }\nA { }",
      reported("'size' of 'Box' (line 2), which IS 's', but its PROTO 'B' has no such field"))),
    8, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene("\n" + own + "s } }",
                reported("'size' of 'Box' (line 3), which IS 's' outside of a PROTO"))),
    8, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene(proto + "Shape { geometry Box { sizes IS s } } }\nA { }",
                reported("'sizes' of 'Box' (line 2)"))),
    8, 1e-9);
  // Fields of a node that is an instance of a PROTO.
  EXPECT_NEAR(VolumeOf(this->Scene(
                proto + own + "s } } }\nA { t 1 1 1 s 2 3 4 }", reported("'t' of 'A' (line 3)"))),
    24, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->Scene(
      proto + own + "s } } }\nPROTO B [ field SFVec3f u 1 2 3 ] { A { s IS u } }\nB { }")),
    6, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene("PROTO A [ field SFFloat s 4 ] { " + own + "s } } }\nA { }",
                reported("'size' of 'Box' (line 2), which IS 's', a field of another type"))),
    8, 1e-9);
  // There are no events: fields that events would change keep their values.
  ExpectBox(this->Scene("PROTO A [ eventIn SFVec3f set_at exposedField SFVec3f at 1 0 0 eventOut "
                        "SFVec3f at_changed eventIn MFNode add ] { Transform { set_translation IS "
                        "set_at translation IS at translation_changed IS at_changed addChildren "
                        "IS add children [ " +
                        cube + " ] } }\nA { at 5 0 0 }"),
    { 4, -1, -1 }, { 6, 1, 1 });
}

// A PROTO's other nodes may be used by scripts, but are not shown.
TEST_F(TestConvertVrml, TheFirstNodeOfAProtoIsShown)
{
  const std::string more = Transformed("translation 9 0 0", "Shape { geometry Box { } }");
  ExpectBox(this->Scene(
              "PROTO A [ ] { PROTO B [ ] { " + cube + more + " } B { } " + more + "B { } }\nA { }"),
    { -1, -1, -1 }, { 1, 1, 1 });
  this->Refused("PROTO A [ ] { " + cube + more + " }\nA { }\nShape { geometry Box { size x } }",
    "line 6: a value that this field does not allow ('size')");
}

TEST_F(TestConvertVrml, NodesThatAreUsedAgainAreThereAgain)
{
  const Mesh read = this->Scene(
    Transformed("translation 5 0 0", "DEF C " + cube) + Transformed("translation -5 0 0", "USE C"));
  ExpectBox(read, { -6, -1, -1 }, { 6, 1, 1 });
  EXPECT_NEAR(VolumeOf(read), 16, 1e-9);
}

// Each vertex of a face has the face's colour, in any order of the points' numbers.
TEST_F(TestConvertVrml, ColoursOfFacesAreThoseOfTheirVertices)
{
  const std::string points = "coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0, 0 0 1 ] } "
                             "coordIndex [ 0 2 1 -1 0 1 3 -1 1 2 3 -1 0 3 2 -1 ] ";
  const std::string colors = "color Color { color [ 1 0 0, 0 1 0, 0 0 1, 1 1 0 ] } ";
  const std::vector<Vec3> inOrder{ { 255, 0, 0 }, { 0, 255, 0 }, { 0, 0, 255 }, { 255, 255, 0 } };
  const struct
  {
    std::string fields;
    std::vector<std::size_t> colorOf; // for each corner
  } cases[] = {
    { "colorPerVertex FALSE", { 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3 } },
    { "colorPerVertex FALSE colorIndex [ 3 3 0 1 ]", { 3, 3, 3, 3, 3, 3, 0, 0, 0, 1, 1, 1 } },
    { "colorPerVertex TRUE", { 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2 } },
    { "colorIndex [ 3 2 1 -1 0 0 0 -1 1 2 3 -1 2 2 2 -1 ]",
      { 3, 2, 1, 0, 0, 0, 1, 2, 3, 2, 2, 2 } },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.fields);
    const Mesh read =
      this->Scene("Shape { geometry IndexedFaceSet { " + points + colors + c.fields + " } }");
    const std::vector<double> rgb = ValuesOf(read, "RGB");
    ASSERT_EQ(read.triangles.size(), 4U);
    ASSERT_EQ(rgb.size(), 3 * read.points.size());
    EXPECT_NEAR(VolumeOf(read), 1.0 / 6, 1e-9);
    for (std::size_t i = 0; i < 12; ++i)
    {
      const VertexId v = read.triangles[i / 3][i % 3];
      EXPECT_EQ((Vec3{ rgb[3 * v], rgb[3 * v + 1], rgb[3 * v + 2] }), inOrder[c.colorOf[i]]) << i;
    }
  }
  // Colours of vertices split no point. Colours of faces split a point only if they differ.
  EXPECT_EQ(
    this->Scene("Shape { geometry IndexedFaceSet { " + points + colors + " } }").points.size(), 4U);
  EXPECT_EQ(this
              ->Scene("Shape { geometry IndexedFaceSet { " + points + colors +
                      " colorPerVertex FALSE colorIndex [ 1 1 1 1 ] } }")
              .points.size(),
    4U);
}

TEST_F(TestConvertVrml, ConcaveFacesAreCut)
{
  const Mesh read = this->Scene(
    "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 4 0 0, 4 4 0, 2 1 0, 0 4 "
    "0 ] } coordIndex [ 0 1 2 3 4 ] } }");
  EXPECT_EQ(read.triangles.size(), 3U);
  EXPECT_NEAR(AreaOf(read), 10, 1e-9);
}

// A transform to a distant place must not cost the shape its precision. Coordinates themselves are
// floats.
TEST_F(TestConvertVrml, FarAwayIsDoubles)
{
  const Mesh far = this->Scene(
    Transformed("translation 5000000 0 4000000", Transformed("scale 0.01 0.01 0.01", cube)));
  EXPECT_EQ(far.scalarType, ScalarType::Float64);
  ExpectBox(far, { 5e6 - 0.01, -0.01, 4e6 - 0.01 }, { 5e6 + 0.01, 0.01, 4e6 + 0.01 }, 1e-8);
  EXPECT_EQ(this->Scene(Transformed("translation 5 0 4", cube)).scalarType, ScalarType::Float32);
}

TEST_F(TestConvertVrml, InlinesAreReadBesideTheFile)
{
  std::filesystem::create_directories(this->Folder / "parts");
  this->WriteText("parts/cube.wrl", header + "Inline { url \"more.wrl\" }" + cube);
  this->WriteText("parts/more.wrl", header + Transformed("translation 0 9 0", cube));
  const Mesh read = this->Scene(
    Transformed("translation 5 0 0", "Inline { url [ \"nothing.wrl\" \"parts/cube.wrl\" ] }") +
    Transformed("translation -5 0 0", "Inline { url \"parts\\\\cube.wrl\" }"));
  ExpectBox(read, { -6, -1, -1 }, { 6, 10, 1 });
  EXPECT_NEAR(VolumeOf(read), 32, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene(cube + "Inline { url \"nothing.wrl\" }",
                LeftOut("the Inline 'nothing.wrl', which is not there (line 3)"))),
    8, 1e-9);
  this->WriteText("parts/bad.wrl", header + "\nShape { geometry Nonsense }");
  this->Refused("Inline { url \"parts/bad.wrl\" }", "line 2: the Inline 'bad.wrl': line 3: ");
  this->WriteText("again.wrl", header + "Inline { url \"again.wrl\" }");
  this->Refused("Inline { url \"again.wrl\" }", "the Inline 'again.wrl' contains itself");
  // Nothing is read outside of the folder.
  this->WriteText("cube.wrl", header + cube);
  std::filesystem::create_directories(this->Folder / "inner");
  this->WriteText("inner/in.wrl", header + cube + "Inline { url \"../cube.wrl\" }");
  this->Converted("inner/in.wrl",
    "kdstream-convert: warning: inner/in.wrl: 1 node cannot be read and is left out: the Inline "
    "'../cube.wrl', which lies outside the mesh's folder, and nothing is read there (line 3)\n");
  this->WriteText("inner/in.wrl", header + cube + "Inline { url \"http://a.example/b.wrl\" }");
  this->Converted("inner/in.wrl",
    "kdstream-convert: warning: inner/in.wrl: 1 node cannot be read and is left out: the Inline "
    "'http://a.example/b.wrl', which lies on the web, and nothing is downloaded (line 3)\n");
}

TEST_F(TestConvertVrml, WhatIsNotASurfaceIsNamed)
{
  EXPECT_EQ(this
              ->Scene(cube + "Shape { geometry IndexedLineSet { coord Coordinate { point [ 0 0 "
                             "0, 1 1 1 ] } coordIndex [ 0 1 -1 1 0 ] } }\n"
                             "Shape { geometry Text { string \"hello\" } }",
                Warning("left out: 2 lines (IndexedLineSet)") + Warning("left out: 1 texts (Text)"))
              .points.size(),
    8U);
  const Mesh cloud =
    this->Scene("Shape { geometry PointSet { coord Coordinate { point [ 1 2 3, 4 5 "
                "6 ] } color Color { color [ 1 0 0, 0 1 0 ] } } }");
  EXPECT_EQ(cloud.points, (std::vector<Vec3>{ { 1, 2, 3 }, { 4, 5, 6 } }));
  EXPECT_EQ(ValuesOf(cloud, "RGB"), (std::vector<double>{ 255, 0, 0, 0, 255, 0 }));
  this->Scene("Shape { appearance Appearance { texture ImageTexture { url \"a.png\" } } geometry "
              "Box { } }",
    Warning("its pictures are not read"));
}

TEST_F(TestConvertVrml, TextIsText)
{
  for (const std::string end : { "\r\n", "\r" })
  {
    std::string text = header + "# a comment { \" [\n" + cube;
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += end.size())
    {
      text.replace(at, 1, end);
    }
    this->WriteText("in.wrl", "\xEF\xBB\xBF" + text);
    EXPECT_NEAR(VolumeOf(this->Converted("in.wrl")), 8, 1e-9);
  }
  EXPECT_NEAR(
    VolumeOf(this->Scene("WorldInfo { info [ \"a { \\\" # b\" \"two\nlines\" ] }\n" + cube)), 8,
    1e-9);
}

TEST_F(TestConvertVrml, VrmlOneIsReadToo)
{
  this->WriteText("in.wrl",
    "#VRML V1.0 ascii\nSeparator { Transform { translation 10 0 0 rotation 0 0 1 0.7853982 } "
    "Material { diffuseColor 1 0 0 } Cube { width 2 height 2 depth 2 } }\n");
  const Mesh read = this->Converted("in.wrl");
  ExpectBox(
    read, { 10 - std::sqrt(2.0), -std::sqrt(2.0), -1 }, { 10 + std::sqrt(2.0), std::sqrt(2.0), 1 });
  ASSERT_EQ(read.points.size(), 8U);
  ASSERT_FALSE(ValuesOf(read, "RGB").empty());
  EXPECT_EQ(ValuesOf(read, "RGB")[0], 255);
}

TEST_F(TestConvertVrml, MistakesAreNamedWithTheirLine)
{
  this->Refused("\nShape { geometry Nonsense }", "line 3: ");
  this->Refused(cube + "Shape { geometry Box { size 1 a 1 } }", "line 3: ");
  this->Refused("Shape {\n geometry IndexedFaceSet {\n", "ends inside what a '{' in line 3 begins");
  this->Refused("Shape { geometry ]", "line 2: a ']' closes nothing");
  this->Refused("WorldInfo { title \"a", "line 2: a string has no closing quote");
  this->Refused(cube + std::string(1, '\0') + cube, "line 3: a control character (byte 0)");
  this->Refused("Shape { geometry IndexedFaceSet { " + cubePoints + " coordIndex [ 0 1 9 -1 ] } }",
    "shape 0, face 0 names point 9, but there are 8, counted from 0");
  this->Refused("EXTERNPROTO A [ ] \"a.wrl\"\nA { }",
    "holds no points; 1 node cannot be read and is left out: 'A', which EXTERNPROTO takes from "
    "another file (line 3)");
  this->Refused("", "holds no points; it shows no shape");
  this->WriteText("in.wrl", "#VRML V3.0 utf8\n");
  this->ExpectError("in.wrl", "has another version than VRML 1 and 2");
  this->WriteText("in.wrl", "Shape { }\n");
  this->ExpectError("in.wrl", "is not a VRML file: its first line does not begin with '#VRML'");
  this->WriteText("in.wrl", std::string("\x1f\x8b\x08\0aaaa", 8));
  this->ExpectError("in.wrl", "truncated: its compressed text (gzip) ends at byte 8");
}

// Scenes that would need unlimited memory, time or stack.
TEST_F(TestConvertVrml, WhatContainsItselfIsRefused)
{
  std::string deep, end;
  for (int i = 0; i < 100000; ++i)
  {
    deep += "Group { children [ ";
    end += "] } ";
  }
  this->Refused(deep + cube + end, "line 2: nodes are nested deeper than 400");
  this->Refused("DEF A Group { children [ " + cube + " USE A ] }",
    "line 3: the node 'A' contains itself (USE)");
  this->Refused(
    "PROTO A [ ] { Group { children [ A { } ] } }\nA { }", "line 2: the PROTO 'A' contains itself");
  std::string laughs = "PROTO A0 [ ] { " + cube + " }\n", uses = "DEF B0 Group { children [ ] }\n";
  for (int i = 1; i < 40; ++i)
  {
    const std::string before = std::to_string(i - 1), now = std::to_string(i);
    laughs +=
      "PROTO A" + now + " [ ] { Group { children [ A" + before + " { } A" + before + " { } ] } }\n";
    uses += "DEF B" + now + " Group { children [ USE B" + before + " USE B" + before + " ] }\n";
  }
  this->Refused(laughs + "A39 { }", "PROTOs make more than 1000000 nodes of it");
  this->Refused(uses, "its nodes, each time they are used, are more than ");
}

// No string in a file makes the reader open a file, except the name in an Inline, beside the file.
TEST_F(TestConvertVrml, NothingElseIsOpened)
{
  ASSERT_EQ(::mkfifo((this->Folder / "pipe").c_str(), 0600), 0); // opening it would wait forever
  const std::string pipe = "\"" + (this->Folder / "pipe").string() + "\"";
  for (const std::string node :
    { "Shape { appearance Appearance { texture ImageTexture { url NAME } } geometry Box { } }",
      "Shape { appearance Appearance { texture MovieTexture { url NAME } } geometry Box { } }",
      "Sound { source AudioClip { url NAME } }", "Script { url NAME }",
      "Background { frontUrl NAME }", "Anchor { url NAME children [ ] }", "File { name NAME }",
      "Texture2 { filename NAME }" })
  {
    SCOPED_TRACE(node);
    std::string named = node;
    named.replace(named.find("NAME"), 4, pipe);
    this->WriteText("in.wrl", header + cube + named);
    const Outcome outcome = this->Convert("in.wrl");
    EXPECT_LE(outcome.exitCode, 1) << outcome.err;
  }
  this->WriteText("in.wrl", header + cube + "Inline { url " + pipe + " }");
  EXPECT_EQ(this->Convert("in.wrl").exitCode, 0);
  this->Refused(cube +
                  "Shape { geometry ElevationGrid { xDimension 100000 zDimension 100000 } }"
                  "Shape { geometry IndexedFaceSet { " +
                  cubePoints + " coordIndex [ 0 1 2147483647 -1 ] } }",
    "names point 2147483647");
  EXPECT_NEAR(VolumeOf(this->Scene(cube + "Shape { geometry ElevationGrid { xDimension 100000 "
                                          "zDimension 100000 height [ 1 2 3 ] } }",
                LeftOut("'ElevationGrid', whose sizes or numbers make no shape"))),
    8, 1e-9);
}

// VRML 1: a shape uses the points, materials and hints that earlier nodes have set.
class TestConvertVrmlOne : public TestConvertVrml
{
protected:
  Mesh First(const std::string& body, const std::string& warnings = "")
  {
    this->WriteText("in.wrl", "#VRML V1.0 ascii\nSeparator { " + body + " }\n");
    return this->Converted("in.wrl", warnings);
  }
  void FirstRefused(const std::string& body, const std::string& what)
  {
    this->WriteText("in.wrl", "#VRML V1.0 ascii\nSeparator { " + body + " }\n");
    this->ExpectError("in.wrl", what);
  }
  static std::vector<Vec3> ColorsOfFaces(const Mesh& mesh)
  {
    const std::vector<double> rgb = ValuesOf(mesh, "RGB");
    std::vector<Vec3> colors;
    for (const Triangle& t : mesh.triangles)
    {
      colors.push_back({ rgb[3 * t[0]], rgb[3 * t[0] + 1], rgb[3 * t[0] + 2] });
    }
    return colors;
  }

  const std::string Points =
    "Coordinate3 { point [ -1 -1 -1, 1 -1 -1, 1 1 -1, -1 1 -1, -1 -1 1, 1 -1 1, 1 1 1, -1 1 1 ] } ";
  const std::string Cube = this->Points + "IndexedFaceSet { " + cubeFaces + " } ";
  const std::string TwoFaces = "IndexedFaceSet { coordIndex [ 0 3 2 -1 4 5 6 -1 ] ";
};

TEST_F(TestConvertVrmlOne, FacesLookTheWayThatTheirHintsSay)
{
  EXPECT_NEAR(VolumeOf(this->First(this->Cube)), 8, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->First("ShapeHints { vertexOrdering COUNTERCLOCKWISE } " + this->Cube)), 8, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->First("ShapeHints { vertexOrdering CLOCKWISE } " + this->Cube)), -8, 1e-9);
  EXPECT_NEAR(VolumeOf(this->First(
                "ShapeHints { vertexOrdering CLOCKWISE } Cube { width 2 height 2 depth 2 }")),
    8, 1e-9);
}

TEST_F(TestConvertVrmlOne, ConcaveFacesAreCut)
{
  for (const std::string hint :
    { "", "ShapeHints { faceType CONVEX } ", "ShapeHints { faceType UNKNOWN_FACE_TYPE } " })
  {
    EXPECT_NEAR(AreaOf(this->First(
                  hint + "Coordinate3 { point [ 0 0 0, 3 0 0, 3 3 0, 2 3 0, 2 1 0, 1 1 0, 1 3 0, 0 "
                         "3 0 ] } IndexedFaceSet { coordIndex [ 0,1,2,3,4,5,6,7,-1 ] }")),
      7, 1e-9);
  }
}

TEST_F(TestConvertVrmlOne, WhatIndicesNameMustBeThere)
{
  for (const std::string index : { "9", "100000", "2147483647" })
  {
    this->FirstRefused(
      this->Points + "IndexedFaceSet { coordIndex [ 0 1 2 -1 0 1 " + index + " -1 ] }",
      "shape 0, face 1 names point " + index + ", but there are 8, counted from 0");
  }
  this->FirstRefused("IndexedFaceSet { coordIndex [ 0 1 2 -1 ] }", "shape 0, face 0 names point");
}

TEST_F(TestConvertVrmlOne, MaterialsAreBoundToFacesAndVertices)
{
  const Vec3 red{ 255, 0, 0 }, green{ 0, 255, 0 };
  const std::string two = "Material { diffuseColor [ 1 0 0, 0 1 0 ] } " + this->Points;
  const auto bound = [&](const std::string& binding)
  { return two + "MaterialBinding { value " + binding + " } " + this->TwoFaces; };
  EXPECT_EQ(ColorsOfFaces(this->First(bound("OVERALL") + "}")), (std::vector<Vec3>{ red, red }));
  EXPECT_EQ(ColorsOfFaces(this->First(bound("PER_FACE") + "}")), (std::vector<Vec3>{ red, green }));
  EXPECT_EQ(ColorsOfFaces(this->First(bound("PER_FACE_INDEXED") + "materialIndex [ 1 0 ] }")),
    (std::vector<Vec3>{ green, red }));
  EXPECT_EQ(ColorsOfFaces(
              this->First(bound("PER_VERTEX_INDEXED") + "materialIndex [ 1 1 1 -1 0 0 0 -1 ] }")),
    (std::vector<Vec3>{ green, red }));
  // If an index does not exist, the first material is used.
  const std::string lacks =
    Warning("1 face names a texture coordinate, normal or colour that does not exist: it is read "
            "without it: shape 0, face 0");
  EXPECT_EQ(ColorsOfFaces(
              this->First(bound("PER_FACE_INDEXED") + "materialIndex [ 100000000 1 ] }", lacks)),
    (std::vector<Vec3>{ red, green }));
  EXPECT_EQ(
    ValuesOf(this->First(two + "MaterialBinding { value PER_PART } Cylinder { }"), "RGB")[0], 255);
}

TEST_F(TestConvertVrmlOne, PointsAreRead)
{
  const Mesh all = this->First("Material { emissiveColor 0 0 1 } " + this->Points + "PointSet { }");
  EXPECT_EQ(all.points.size(), 8U);
  ASSERT_EQ(ValuesOf(all, "RGB").size(), 24U);
  EXPECT_EQ(ValuesOf(all, "RGB")[2], 255);
  EXPECT_EQ(this->First(this->Points + "PointSet { startIndex 5 numPoints 99 }").points,
    (std::vector<Vec3>{ { 1, -1, 1 }, { 1, 1, 1 }, { -1, 1, 1 } }));
}

// The reader does not check the indices in these shapes.
TEST_F(TestConvertVrmlOne, ShapesOfOtherFormatsAreLeftOut)
{
  EXPECT_EQ(this
              ->First(this->Cube + "IndexedTriangleStripSet { coordIndex [ 0 1 100000000 ] } "
                                   "FaceSet { startIndex 100000000 numVertices [ 3 ] }",
                Warning("2 nodes cannot be read and are left out; the first: 'FaceSet', which VRML "
                        "does not have; 'IndexedTriangleStripSet', which VRML does not have"))
              .points.size(),
    8U);
}

TEST_F(TestConvertVrml, ExtrusionsLookTheWayThatTheySay)
{
  const std::string extrusion = "Shape { geometry Extrusion { ";
  EXPECT_NEAR(
    VolumeOf(this->Scene(extrusion + "crossSection [ 1 1, 1 -1, -1 -1, -1 1, 1 1 ] } }")), 4, 1e-5);
  EXPECT_NEAR(
    VolumeOf(this->Scene(extrusion + "ccw FALSE crossSection [ 1 1, -1 1, -1 -1, 1 -1, 1 1 ] } }")),
    4, 1e-5);
}

TEST_F(TestConvertVrml, WhatEmitsLightHasItsColour)
{
  const auto shape = [](const std::string& material, const std::string& geometry)
  {
    return "Shape { appearance Appearance { material Material { " + material + " } } geometry " +
           geometry + " }\n";
  };
  const auto first = [](const Mesh& mesh)
  {
    const std::vector<double> rgb = ValuesOf(mesh, "RGB");
    return rgb.empty() ? Vec3{} : Vec3{ rgb[0], rgb[1], rgb[2] };
  };
  const std::string points = "PointSet { coord Coordinate { point [ 0 0 0, 1 2 3 ] } }";
  for (const std::string geometry :
    { "Box { }", "PointSet { coord Coordinate { point [ 0 0 0 ] } }" })
  {
    SCOPED_TRACE(geometry);
    EXPECT_EQ(first(this->Scene(shape("diffuseColor 0 0 0 emissiveColor 1 0 0", geometry))),
      (Vec3{ 255, 0, 0 }));
  }
  EXPECT_EQ(first(this->Scene(shape("emissiveColor 0 0 1", points))), (Vec3{ 0, 0, 255 }));
  EXPECT_EQ(first(this->Scene(shape("diffuseColor 0 1 0", points))), (Vec3{ 0, 255, 0 }));
  const std::string glass = "diffuseColor 0 1 0 emissiveColor 0.1 0 0 transparency 0.5";
  EXPECT_EQ(
    first(this->Scene("DEF G " + shape(glass, "Box { }") + shape(glass, "Sphere { }") + "USE G",
      Warning("the emission of the material 0 and of 1 other is left out") +
        Warning("the transparency of the material 0 and of 1 other is left out"))),
    (Vec3{ 0, 255, 0 }));
}

TEST_F(TestConvertVrml, NumbersThatAreNotFiniteAreDropped)
{
  for (const std::string number :
    { "nan", "-NaN", "inf", "-infinity", "nan(ind)", "-1.#IND", "1.#QNAN", "1.#INF000e+000" })
  {
    SCOPED_TRACE(number);
    const Mesh read = this->Scene("Shape { geometry PointSet { coord Coordinate { point [ 0 0 0, " +
                                    number + " 1 2, 1 1 1, 3 4 " + number + "\n5 5 5 ] } } }",
      Warning("2 points are not finite and are dropped; the first: vertex 1, whose x is nan"));
    EXPECT_EQ(read.points, (std::vector<Vec3>{ { 0, 0, 0 }, { 1, 1, 1 }, { 5, 5, 5 } }));
  }
  EXPECT_EQ(this->Scene("PROTO nan [ ] { " + cube + " }\nnan { }\nDEF inf Group { }\nUSE inf")
              .points.size(),
    8U);
  EXPECT_EQ(
    this->Scene("Shape { geometry Box { size 1 1 1.#INDEED, not a number\n} }").points.size(), 8U);
}

TEST_F(TestConvertVrml, NamesOfAllKindsAreRead)
{
  for (const std::string name : { "1box", "box.1-a:b+c/d", "Box(2)", "it's", "-FACES", "+a" })
  {
    SCOPED_TRACE(name);
    EXPECT_NEAR(VolumeOf(this->Scene(
                  "DEF " + name + " " + cube + Transformed("translation 5 0 0", "USE " + name))),
      16, 1e-9);
  }
  this->Refused("DEF 1 Group { children USE 1 }", "the node '1' contains itself (USE)");
  // A name means the last node that was given the name.
  EXPECT_NEAR(VolumeOf(this->Scene("DEF A Transform { children [ DEF A " + cube +
                                   Transformed("translation 5 0 0", "USE A") + " ] }")),
    16, 1e-9);
  this->Refused("DEF A Group { children [ PROTO P [ ] { DEF A " + cube + " } USE A ] }",
    "the node 'A' contains itself (USE)");
}

TEST_F(TestConvertVrml, WhatIsNotKnownIsLeftOut)
{
  EXPECT_NEAR(
    VolumeOf(this->Scene(
      "EXTERNPROTO KeySensor [ eventOut SFInt32 keyPress ]\n[ \"urn:a\" "
      "\"http://x/y.wrl#KeySensor\" ]\nEXTERNPROTO Odd [ field SFNode a ] "
      "\"a.wrl\" KeySensor { }\n" +
        Transformed("", "LoadSensor { enabled TRUE } Odd { a Box { } }\n" + cube) +
        "Shape { geometry NurbsSurface { uDimension 2 } }",
      Warning("4 nodes cannot be read and are left out; the first: 'KeySensor', which EXTERNPROTO "
              "takes from another file (line 4); 'LoadSensor', which VRML does not have (line 5); "
              "'Odd', which EXTERNPROTO takes from another file (line 5); 'NurbsSurface', which "
              "VRML does not have (line 8)"))),
    8, 1e-9);
  this->Refused(
    "EXTERNPROTO A [ ]\n[ \"a\"\n]\nA { }\nShape { geometry Box { size 1 a 1 } }", "line 6: ");
}

// Fields are missing or misplaced, as other programs write them.
TEST_F(TestConvertVrml, NodesWithoutAFieldAreChildrenOrLeftOut)
{
  const auto reported = [](const std::string& place)
  {
    return Warning(
      place + " is where a field's name is expected: it is read as a child of the node");
  };
  ExpectBox(this->Scene("Transform { translation 5 0 0 " + cube + " DEF A " + cube +
                          "\nscale 2 2 2 }\n" + Transformed("", "USE A"),
              reported("'Shape' of 'Transform' (line 2)")),
    { -1, -2, -2 }, { 7, 2, 2 });
  EXPECT_NEAR(VolumeOf(this->Scene(
                "Group { " + Transformed("translation 9 0 0", cube) + "Group { " + cube + " } }",
                reported("'Transform' of 'Group' (line 2)"))),
    16, 1e-9);
  EXPECT_NEAR(
    VolumeOf(this->Scene("Shape { appearance Appearance { material Material { } ImageTexture { url "
                         "\"a.png\" } } geometry Box { } }",
      Warning("its pictures are not read") +
        Warning("1 field is unknown in the format and is left out: 'ImageTexture' of 'Appearance' "
                "(line 2), a node without a field"))),
    8, 1e-9);
  EXPECT_NEAR(VolumeOf(this->Scene("Group { children [ " + cube + " ] " +
                                     Transformed("translation 9 0 0", cube) + " }",
                Warning("1 field is unknown in the format and is left out: 'Transform' of 'Group' "
                        "(line 3), a node without a field"))),
    8, 1e-9);
}

TEST_F(TestConvertVrml, ScriptsMayKnowWhatIsAroundThem)
{
  EXPECT_NEAR(
    VolumeOf(this->Scene("DEF A Transform { children [ " + cube +
                         "DEF S Script { field SFNode self USE S field MFNode all [ USE A USE S ] "
                         "url \"javascript: a = '{';\" } ] }")),
    8, 1e-9);
}

TEST_F(TestConvertVrml, NodesOfTheOtherVersionAreNamed)
{
  this->WriteText("in.wrl", "#VRML V1.0 ascii\n" + cube);
  this->ExpectError("in.wrl",
    "holds no points; 1 node cannot be read and is left out: 'Shape', which VRML does not have "
    "(line 2)");
  this->WriteText("in.wrl", "#VRML v2.0 UTF8\n" + cube);
  EXPECT_NEAR(VolumeOf(this->Converted("in.wrl")), 8, 1e-9);
}

// Transforms as in Inventor, in a file of VRML 2.
TEST_F(TestConvertVrml, TransformsOfInventorCountToo)
{
  ExpectBox(this->Scene("Separator { Translation { translation 5 0 0 } " + cube + " }"),
    { 4, -1, -1 }, { 6, 1, 1 });
  ExpectBox(
    this->Scene(Transformed("translation 0 7 0",
      "Separator { Scale { scaleFactor -2 1 1 } Translation { translation 5 0 0 } " + cube + " }")),
    { -12, 6, -1 }, { -8, 8, 1 });
}

TEST_F(TestConvertVrml, InlinesAreFoundHoweverTheyAreNamed)
{
  std::filesystem::create_directories(this->Folder / "parts");
  this->WriteText("parts/a cube.wrl", header + cube);
  for (const std::string url : { "parts/A Cube.WRL", "parts/a%20cube.wrl",
         "parts/a%20cube.wrl#View1", "file:parts/a cube.wrl", "PARTS\\\\a cube.wrl" })
  {
    SCOPED_TRACE(url);
    EXPECT_NEAR(VolumeOf(this->Scene("Inline { url \"" + url + "\" }")), 8, 1e-9);
  }
}

TEST_F(TestConvertVrml, InlinesOfProtosAreRead)
{
  this->WriteText("cube.wrl", header + cube);
  const std::string proto =
    "PROTO P [ field MFString u [ \"cube.wrl\" ] field SFString n \"nothing\" ] "
    "{ Inline { url IS u } }\n";
  EXPECT_NEAR(VolumeOf(this->Scene(
                proto + "P { }\n" + Transformed("translation 5 0 0", "P { u \"cube.wrl\" }") +
                Transformed("translation 9 0 0", "P { u [ \"none.wrl\", \"cube.wrl\" ] }"))),
    24, 1e-9);
}

TEST_F(TestConvertVrml, FlatBoxesAreFaces)
{
  EXPECT_NEAR(AreaOf(this->Scene("Shape { geometry Box { size 2 0 3 } }")), 12, 1e-6);
  this->Refused("Shape { geometry Box { size 2 0 0 } }",
    "1 node cannot be read and is left out: 'Box', whose sizes or numbers make no shape");
}

// A few bytes must not keep the reader busy for long.
TEST_F(TestConvertVrml, ExtrusionsAreBound)
{
  std::string section, spine;
  for (int i = 0; i < 700; ++i)
  {
    section += std::to_string(i) + " 0 ";
    spine += "0 " + std::to_string(i) + " 0 ";
  }
  this->Refused(
    "Shape { geometry Extrusion { crossSection [ " + section + " ] spine [ " + spine + " ] } }",
    "its extrusions, each time they are used, have more than ");
}

// Parts that share one Coordinate node keep only the points that they use.
TEST_F(TestConvertVrml, SharedPointsAreNotMultiplied)
{
  std::string shapes = "Shape { geometry IndexedFaceSet { coord DEF P Coordinate { point [ ";
  for (int i = 0; i < 300; ++i)
  {
    shapes += std::to_string(i) + " 0 0, ";
  }
  shapes += "0 1 0 ] } coordIndex [ 0 1 300 ] } }\n";
  for (int i = 1; i + 1 < 300; ++i)
  {
    shapes += "Shape { geometry IndexedFaceSet { coord USE P coordIndex [ " + std::to_string(i) +
              " " + std::to_string(i + 1) + " 300 ] } }\n";
  }
  const Mesh read = this->Scene(shapes);
  EXPECT_EQ(read.triangles.size(), 299U);
  EXPECT_EQ(read.points.size(), 3 * 299U);
  EXPECT_NEAR(AreaOf(read), 299.0 / 2, 1e-6);
}

// Groups that are not shown are checked like others.
TEST_F(TestConvertVrml, DeepUsesAreRefusedWhereverTheyAre)
{
  std::string chain = "Switch { whichChoice -1 choice [ DEF N0 " + cube;
  for (int i = 1; i < 20000; ++i)
  {
    chain +=
      "DEF N" + std::to_string(i) + " Group { children USE N" + std::to_string(i - 1) + " }\n";
  }
  this->Refused(
    chain + "] }" + cube, "nodes that are used again (USE) are nested deeper than 1000");
}

// A file is cut off anywhere, or words and bytes are changed. The result is an error in one line,
// or a mesh; never a crash.
TEST_F(TestConvertVrml, DamagedFilesAreErrors)
{
  const std::string whole =
    header +
    "PROTO P [ field SFVec3f size 1 1 1 exposedField MFNode kids [ ] ] { Transform { children IS "
    "kids } }\n" +
    Transformed("translation 1 2 3 rotation 0 0 1 1 center 1 1 1", "DEF C " + cube) +
    "P { kids [ USE C ] }\nSwitch { whichChoice 0 choice [ Shape { geometry Sphere { } } ] }\n"
    "LOD { range [ 5 ] level [ Shape { geometry Cone { } } , USE C ] }\n"
    "Shape { appearance Appearance { material Material { diffuseColor 1 0 0 } texture PixelTexture "
    "{ image 1 2 3 0xFF0000 0x00FF00 } } geometry Extrusion { spine [ 0 0 0, 0 1 0, 1 2 0 ] "
    "orientation [ 0 0 1 0 ] scale [ 1 1, 2 2, 1 1 ] } }\n"
    "Shape { geometry ElevationGrid { xDimension 2 zDimension 2 height [ 0 1 2 3 ] } }\n"
    "DEF T TimeSensor { } DEF I PositionInterpolator { key [ 0 1 ] keyValue [ 0 0 0, 1 1 1 ] }\n"
    "ROUTE T.fraction_changed TO I.set_fraction\n"
    "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0 1 0 0 0 1 0 ] } coordIndex "
    "[ 0 1 2 ] color Color { color [ 1 0 0 0 1 0 0 0 1 ] } normal Normal { vector [ 0 0 1 0 0 1 0 "
    "0 "
    "1 ] } texCoord TextureCoordinate { point [ 0 0 1 0 0 1 ] } } }\n";
  this->WriteText("in.wrl", whole);
  ASSERT_EQ(this->Convert("in.wrl").exitCode, 0) << this->Convert("in.wrl").err;
  const std::vector<std::string> words{ "{", "}", "[", "]", "-1", "1e39", "nan", "2147483647",
    "-2147483648", "USE C", "DEF C", "IS size", "NULL", "Group { }", "\"", "TRUE", "0x7fffffff",
    "children", "PROTO Q [ ] { }", "field SFNode a NULL", "32767 32767 4", "0" };
  std::mt19937 random(12);
  for (unsigned draw = 0; draw < 150; ++draw)
  {
    std::string bad = whole;
    if (draw < 30)
    {
      bad.resize(whole.size() * (draw + 1) / 32);
    }
    for (unsigned change = 0; draw >= 30 && change <= draw % 3; ++change)
    {
      const std::size_t at = header.size() + random() % (bad.size() - header.size());
      if (draw % 2 == 0)
      {
        bad[at] = static_cast<char>(random() % 256);
      }
      else
      {
        // Replaces a word by another one.
        const std::size_t begin = bad.rfind(' ', at);
        const std::size_t end = bad.find_first_of(" \n", at);
        if (begin != std::string::npos && end != std::string::npos && begin + 1 < end)
        {
          bad.replace(begin + 1, end - begin - 1, words[random() % words.size()]);
        }
      }
    }
    SCOPED_TRACE(draw);
    this->WriteText("in.wrl", bad);
    std::filesystem::remove(this->Folder / "out.ply");
    const Outcome outcome = this->Convert("in.wrl");
    EXPECT_LE(outcome.exitCode, 1);
    EXPECT_EQ(outcome.err.find("crashed"), std::string::npos) << outcome.err << bad;
    EXPECT_LE(outcome.peakBytes, std::uint64_t{ 1200 } << 20);
    if (outcome.exitCode == 1)
    {
      EXPECT_EQ(outcome.err.rfind("kdstream-convert: error: in.wrl: ", 0), 0U) << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    }
  }
}

TEST_F(TestConvertVrml, ScenesOfVrmlAreJoined)
{
  this->WriteText("in.wrl",
    "#VRML V2.0 utf8\nTransform { translation 10 0 0 children [ Shape { appearance Appearance { "
    "material Material { diffuseColor 1 0 0 } } geometry IndexedFaceSet { coord Coordinate { point "
    "[0 0 0, 1 0 0, 0 1 0] } coordIndex [0 1 2 -1] } } ] }\n"
    "Shape { appearance Appearance { material Material { } } geometry IndexedFaceSet { coord "
    "Coordinate { point [0 0 0, 1 0 0, 0 1 0, 1 1 0] } coordIndex [0 1 3 2 -1] color Color { color "
    "[ 0 1 0, 0 0 1, 1 1 1, 0 0 0 ] } } }\n");
  const Mesh read = this->Converted("in.wrl");
  ASSERT_EQ(read.points.size(), 7U);
  EXPECT_EQ(read.points[0], (Vec3{ 10, 0, 0 }));
  EXPECT_EQ(read.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 3, 4, 6 }, { 3, 6, 5 } }));
  EXPECT_EQ(ValuesOf(read, "RGB"), (std::vector<double>{ 255, 0, 0, 255, 0, 0, 255, 0, 0, 0, 255, 0,
                                     0, 0, 255, 255, 255, 255, 0, 0, 0 }));
}

TEST_F(TestConvertVrml, CoarseFloatsAreSaid)
{
  const std::string text = "at 4000010 they are 0.25 apart";
  const auto scene = [](const std::string& points)
  {
    return "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { coord Coordinate { point [" +
           points + "] } coordIndex [0 1 2 -1] } }\n";
  };
  this->WriteText("far.wrl", scene("0 4000000.4565 0, 10 4000000 0, 0 4000010 0"));
  this->Converted("far.wrl", "kdstream-convert: warning: far.wrl: " +
                               std::string("coordinates are read as floats: ") + text + "\n");
  // A millionth of the longest side. Floats are 0.25 apart here, too; otherwise the test would show
  // nothing.
  this->WriteText("wide.wrl", scene("0 -4000000 0, 10 0 0, 0 4000010 0"));
  this->Converted("wide.wrl");
  this->WriteText("near.wrl", scene("0 0 0, 1 0 0, 0 1 0"));
  this->Converted("near.wrl");
}

TEST_F(TestConvertVrml, ColorsOfVrmlAreNotInvented)
{
  Mesh cloud = AsFloats(DisplacedSphere(2));
  cloud.triangles.clear();
  ASSERT_TRUE(WriteMesh(this->Folder / "cloud.wrl", cloud));
  const Mesh read = this->Converted("cloud.wrl");
  EXPECT_EQ(read.points.size(), cloud.points.size());
  EXPECT_TRUE(read.attributes.empty());
  this->WriteText("bare.wrl", "#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { coord Coordinate "
                              "{ point [0 0 0, 1 0 0, 0 1 0] } coordIndex [0 1 2 -1] } }\n");
  EXPECT_TRUE(this->Converted("bare.wrl").attributes.empty());
}
