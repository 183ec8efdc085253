// SPDX-License-Identifier: BSD-3-Clause
#include "filters/meshio/ContentFormat.h"

#include "filters/meshio/FileEnding.h"
#include "filters/meshio/PlainText.h"
#include "filters/meshio/QuotedText.h"
#include "filters/meshio/TextWords.h"

#include <algorithm>
#include <array>
#include <vector>

namespace kdstream
{
namespace
{

using namespace std::string_view_literals;

struct Mark
{
  std::string_view begin, ending;
};

// Marks from the formats' specifications.
constexpr Mark marks[] = { { "ply\n", ".ply" }, { "ply\r", ".ply" }, { "glTF", ".glb" },
  { "LASF", ".las" }, { "# vtk DataFile", ".vtk" }, { "#VRML", ".wrl" }, { "# .PCD", ".pcd" },
  { "VERSION .7", ".pcd" }, { "solid ", ".stl" }, { "solid\n", ".stl" }, { "solid\r", ".stl" },
  // Archives: people forget to unpack them.
  { "PK\x03\x04", ".zip" }, { "PK\x05\x06", ".zip" }, { "\x1f\x8b", ".gz" }, { "BZh", ".bz2" },
  { "\xFD"
    "7zXZ",
    ".xz" },
  { "\x28\xB5\x2F\xFD", ".zst" }, { "7z\xBC\xAF", ".7z" }, { "Rar!\x1A", ".rar" },
  { "\x1f\x9d", ".z" },
  // Images and documents.
  { "\x89PNG", ".png" }, { "\xFF\xD8\xFF", ".jpg" }, { "II*\0"sv, ".tif" }, { "MM\0*"sv, ".tif" },
  { "%PDF", ".pdf" }, { "<!DOCTYPE", ".html" }, { "<!doctype", ".html" }, { "<html", ".html" },
  // Meshes, scenes and scans that are not read.
  { "Kaydara FBX Binary", ".fbx" }, { "; FBX ", ".fbx" }, { "BLENDER", ".blend" },
  { "\xFF\xFE\xFF\x0ES\0k\0e\0t\0c\0h\0U\0p\0"sv, ".skp" }, { "#usda ", ".usd" },
  { "PXR-USDC", ".usd" }, { "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1", ".max" }, { "ASTM-E57", ".e57" },
  { "ISO-10303-21", ".step" }, { "3D Geometry File Format", ".3dm" }, { "AC10", ".dwg" },
  { "AutoCAD Binary DXF", ".dxf" }, { "DRACO", ".drc" }, { "OCTM", ".ctm" }, { " sxN", ".nxs" },
  { "#Inventor", ".iv" }, { "#X3D ", ".x3d" }, { "xof 0", ".x" }, { "//Maya ASCII", ".ma" },
  { "Ogawa", ".abc" }, { "$MeshFormat", ".msh" }, { "MeshVersionFormatted", ".mesh" },
  { "\x89HDF", ".h5" }, { "CDF\x01", ".nc" }, { "CDF\x02", ".nc" }, { "\x93NUMPY", ".npy" },
  { "CCB2", ".cloudcompare" }, { "\0\0\x27\x0A"sv, ".shp" }, { "U3D\0"sv, ".u3d" },
  { "b3dm", ".b3dm" }, { "i3dm", ".b3dm" }, { "pnts", ".b3dm" }, { "cmpt", ".b3dm" } };

// XML formats, each found by a word near its beginning.
constexpr Mark elements[] = { { "\"PPolyData\"", ".pvtp" }, { "'PPolyData'", ".pvtp" },
  { "PolyData", ".vtp" }, { "<VTKFile", ".vtu" }, { "<COLLADA", ".dae" }, { "<X3D", ".x3d" },
  { "<amf", ".amf" }, { "<kml", ".kml" }, { "CityModel", ".gml" }, { "<LandXML", ".landxml" } };

struct Unread
{
  std::string_view ending, what, remedy;
};

constexpr std::string_view blender = "open it in Blender and export it as .ply, .glb or .obj",
                           meshlab = "open it in MeshLab and export it as .ply",
                           freecad = "open it in FreeCAD and export its mesh as .ply, .stl or .obj",
                           cloudCompare =
                             "open it in CloudCompare and save it as .ply, or as .las for a scan",
                           ownProgram = "export it as .ply, .obj, .stl or .glb with the program "
                                        "that made it",
                           notMesh = "",
                           vtkSurface = "save its surface as .vtp (in ParaView: "
                                        "Extract Surface)";

// Formats that cannot be read, and how to convert them.
constexpr Unread unread[] = { { ".3mf", "a 3MF file",
                                "export it as .stl or .obj with the slicer "
                                "that made it, or open it in MeshLab and "
                                "export it as .ply" },
  { ".amf", "an AMF file", "export it as .stl with the slicer that made it" },
  { ".fbx", "an FBX file", blender }, { ".blend", "a Blender file", blender },
  { ".dae", "a COLLADA file", meshlab }, { ".3ds", "a 3DS file", meshlab },
  { ".lwo", "a LightWave file", blender }, { ".x", "a DirectX file", ownProgram },
  { ".max", "a compound file, as 3ds Max, SolidWorks and Inventor write them", ownProgram },
  { ".skp", "a SketchUp file", ownProgram }, { ".3dm", "a Rhino file", ownProgram },
  { ".c4d", "a Cinema 4D file", ownProgram }, { ".ma", "a Maya file", ownProgram },
  { ".mb", "a Maya file", ownProgram }, { ".usd", "a USD file", blender },
  { ".usdz", "a USD file", blender }, { ".usda", "a USD file", blender },
  { ".usdc", "a USD file", blender }, { ".abc", "an Alembic file", blender },
  { ".x3d", "an X3D file", meshlab }, { ".x3dv", "an X3D file", meshlab },
  { ".iv", "an Open Inventor file", freecad }, { ".ctm", "an OpenCTM file", meshlab },
  { ".drc", "a Draco file", "decode it to .ply with draco_decoder" },
  { ".nxs", "a Nexus file", "take the mesh that it was built from" },
  { ".nxz", "a Nexus file", "take the mesh that it was built from" },
  { ".step", "a STEP file", freecad }, { ".stp", "a STEP file", freecad },
  { ".iges", "an IGES file", freecad }, { ".igs", "an IGES file", freecad },
  { ".ifc", "an IFC file (a building)", freecad }, { ".fcstd", "a FreeCAD file", freecad },
  { ".brep", "a BREP file", freecad }, { ".dxf", "a DXF drawing", freecad },
  { ".dwg", "a DWG drawing", ownProgram }, { ".e57", "an E57 file (a scan)", cloudCompare },
  { ".ptx", "a PTX file (a scan)", cloudCompare }, { ".rcp", "a ReCap file", ownProgram },
  { ".rcs", "a ReCap file", ownProgram }, { ".fls", "a FARO scan", ownProgram },
  { ".b3dm", "a tile of 3D Tiles", "take the tileset.json that names it" },
  { ".cityjson", "a JSON file that is neither glTF nor a tileset",
    "export what it describes as .glb or .ply" },
  { ".vtu", "a VTK file without PolyData", vtkSurface },
  { ".pvtp", "a list of VTK files with the parts of a mesh",
    "open it in ParaView and save it as .vtp" },
  { ".msh", "a Gmsh file", "export it as .stl or .vtk with Gmsh" },
  { ".mesh", "a Medit file", "export it as .stl or .vtk with Gmsh" },
  { ".gml", "a CityGML file", ownProgram }, { ".landxml", "a LandXML file", ownProgram },
  { ".3dxml", "a 3DXML file", ownProgram }, { ".kml", "a KML file", ownProgram },
  { ".kmz", "a KMZ file", ownProgram }, { ".npz", "a NumPy archive", "write its arrays as .ply" },
  { ".npy", "a NumPy array", "write it as .ply" }, { ".h5", "an HDF5 file", ownProgram },
  { ".hdf5", "an HDF5 file", ownProgram }, { ".vtkhdf", "a VTKHDF file", vtkSurface },
  { ".nc", "a NetCDF file", ownProgram }, { ".cloudcompare", "a CloudCompare file", cloudCompare },
  { ".shp", "a shapefile", ownProgram }, { ".geojson", "a GeoJSON file", ownProgram },
  { ".u3d", "a U3D file", ownProgram }, { ".prc", "a PRC file", ownProgram },
  { ".jt", "a JT file", ownProgram }, { ".sldprt", "a SolidWorks file", ownProgram },
  { ".sldasm", "a SolidWorks file", ownProgram }, { ".ipt", "an Inventor file", ownProgram },
  { ".iam", "an Inventor file", ownProgram },
  { ".mtl", "a material library", "give the .obj that names it" },
  { ".spz", "a file of Gaussian splats", "take the .ply that it was made of" },
  { ".splat", "a file of Gaussian splats", "take the .ply that it was made of" },
  { ".ksplat", "a file of Gaussian splats", "take the .ply that it was made of" },
  { ".png", "a PNG picture", notMesh }, { ".jpg", "a JPEG picture", notMesh },
  { ".tif", "a TIFF picture or grid", notMesh }, { ".pdf", "a PDF document", notMesh },
  { ".html", "a web page (HTML), as servers send instead of a missing file",
    "download the file itself" } };

// Whether the file has exactly the size for the triangles that it counts after the header: this
// does not happen by chance.
bool IsBinaryStl(std::string_view begin, std::uint64_t size)
{
  constexpr std::size_t header = 84;
  if (size <= header || begin.size() < header)
  {
    return false;
  }
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < 4; ++i)
  {
    count |= std::uint64_t{ static_cast<unsigned char>(begin[header - 4 + i]) } << (8 * i);
  }
  return size == header + 50 * count;
}

std::uint64_t LittleEndian(std::string_view bytes, std::size_t at, std::size_t count)
{
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i)
  {
    value |= std::uint64_t{ static_cast<unsigned char>(bytes[at + i]) } << (8 * i);
  }
  return value;
}

// The format of a text without a mark, from the first word of its first line that is not a comment.
// This sign is too weak for files that may be binary.
std::string_view FormatOfText(std::string_view begin)
{
  begin.remove_prefix(begin.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  TakeBlanks(begin);
  while (begin.starts_with('#'))
  {
    begin.remove_prefix(std::min(begin.find_first_of("\r\n"), begin.size()));
    TakeBlanks(begin);
  }
  const std::string_view word = TakeWord(begin);
  constexpr std::string_view ofObj[] = { "v", "vn", "vt", "f", "g", "o", "mtllib", "usemtl" };
  constexpr std::string_view ofOff[] = { "OFF", "COFF", "NOFF", "STOFF", "CNOFF", "NCOFF" };
  return std::find(std::begin(ofObj), std::end(ofObj), word) != std::end(ofObj)   ? ".obj"
         : std::find(std::begin(ofOff), std::end(ofOff), word) != std::end(ofOff) ? ".off"
                                                                                  : "";
}

std::string_view FormatOfJson(std::string_view begin)
{
  const auto has = [begin](std::string_view word)
  { return begin.find(word) != std::string_view::npos; };
  // A tileset has "asset", too, and if its metadata is long, "geometricError" comes after the first
  // bytes. So glTF needs one more word.
  constexpr std::string_view ofGltf[] = { "\"accessors\"", "\"buffers\"", "\"bufferViews\"",
    "\"extensionsUsed\"", "\"images\"", "\"materials\"", "\"meshes\"", "\"nodes\"", "\"scene\"",
    "\"scenes\"" };
  const bool isGltf = has("\"asset\"") && std::any_of(std::begin(ofGltf), std::end(ofGltf), has);
  const bool isOther =
    has("\"CityJSON\"") || (has("\"metadata\"") && (has("Geometry") || has("\"Object\"")));
  return isOther ? ".cityjson" : has("\"geometricError\"") ? ".json" : isGltf ? ".gltf" : "";
}

bool IsRead(std::string_view ending)
{
  return ending == ".ply" || ending == ".stl" || ending == ".obj" || ending == ".off" ||
         IsConvertedFormat(std::string(ending));
}

const Unread* FindUnread(std::string_view ending)
{
  const auto* const found = std::find_if(std::begin(unread), std::end(unread),
    [ending](const Unread& each) { return each.ending == ending; });
  return found == std::end(unread) ? nullptr : found;
}

std::string TellUnread(const Unread& format)
{
  return std::string(format.what) + (format.remedy == notMesh
                                        ? ", and no mesh"
                                        : ", which is not read: " + std::string(format.remedy));
}

// --- ZIP archives --------------------------------------------------------------------------------

// The file names in the first MiB of a ZIP archive's directory, which is at the archive's end
// (APPNOTE.TXT, 4.3.12 and 4.3.16). Empty if the archive is damaged, or has 2^32 bytes or more.
std::vector<std::string> NamesInZip(ByteSource& source)
{
  constexpr std::uint64_t longestEnd = 22 + 0xFFFF;
  constexpr std::size_t entrySize = 46;
  source.Seek(source.Start() + (source.Size() - source.Start() > longestEnd
                                   ? source.Size() - source.Start() - longestEnd
                                   : 0));
  const Result<std::string_view> end = source.Peek(static_cast<std::size_t>(source.Remaining()));
  const std::size_t at = end ? end->rfind("PK\x05\x06") : std::string_view::npos;
  if (at == std::string_view::npos)
  {
    return {};
  }
  const std::uint64_t bytes = LittleEndian(*end, at + 12, 4);
  const std::uint64_t begin = LittleEndian(*end, at + 16, 4);
  if (begin > source.Size() || bytes > source.Size() - begin)
  {
    return {};
  }
  source.Seek(begin);
  const Result<std::string_view> directory =
    source.Peek(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, ByteSource::blockSize)));
  std::vector<std::string> names;
  std::string_view rest = directory ? *directory : std::string_view();
  while (rest.size() > entrySize && rest.starts_with("PK\x01\x02"))
  {
    const auto length = static_cast<std::size_t>(LittleEndian(rest, 28, 2));
    const auto more =
      static_cast<std::size_t>(LittleEndian(rest, 30, 2) + LittleEndian(rest, 32, 2));
    names.emplace_back(rest.substr(entrySize, length));
    rest.remove_prefix(std::min(entrySize + length + more, rest.size()));
  }
  return names;
}

// If the archive itself is a format (such as .3mf), names the format, by the extension of a name in
// the archive or of the file. Otherwise names those files in the archive that could be read.
std::string TellZip(const std::vector<std::string>& names, std::string_view itsEnding)
{
  constexpr Mark inside[] = { { ".model", ".3mf" }, { ".usd", ".usdz" }, { ".usda", ".usdz" },
    { ".usdc", ".usdz" }, { ".kml", ".kmz" }, { ".amf", ".amf" }, { ".brp", ".fcstd" },
    { ".npy", ".npz" }, { ".dae", ".dae" }, { ".ifc", ".ifc" }, { ".3drep", ".3dxml" },
    { ".3dxml", ".3dxml" } };
  std::string readable;
  for (const std::string& name : names)
  {
    const std::string ending = FileEnding(name);
    const Mark* const mark = std::find_if(
      std::begin(inside), std::end(inside), [&](const Mark& each) { return each.begin == ending; });
    if (mark != std::end(inside))
    {
      return "is " + TellUnread(*FindUnread(mark->ending));
    }
    readable = readable.empty() && IsRead(ending) && ending != ".txt" ? name : readable;
  }
  const bool isNamed = std::any_of(std::begin(inside), std::end(inside),
    [&](const Mark& each) { return each.ending == itsEnding; });
  if (isNamed && readable.empty())
  {
    return "is " + TellUnread(*FindUnread(itsEnding));
  }
  return "is compressed (.zip)" + (readable.empty() ? "" : ", and holds " + QuotedText(readable)) +
         ": unpack it first, by unzip";
}

// --- What is reported ----------------------------------------------------------------------------

// What the user can do with a file in an unsupported format, whatever its ending.
std::string UnreadHint(
  ByteSource& source, std::string_view begin, std::string_view format, std::string_view ending)
{
  constexpr std::array<std::array<std::string_view, 2>, 8> programs{ { { ".gz", "gunzip" },
    { ".bz2", "bunzip2" }, { ".xz", "unxz" }, { ".zst", "unzstd" }, { ".7z", "7z x" },
    { ".rar", "unrar x" }, { ".tar", "tar xf" }, { ".z", "uncompress" } } };
  if (begin.starts_with("version https://git-lfs.github.com/spec/"))
  {
    return "is a pointer of Git LFS, not the file that it stands for: run git lfs pull";
  }
  if (format == ".zip")
  {
    return TellZip(NamesInZip(source), ending);
  }
  if (format == ".gz" && ending == ".spz") // a format that gzip has compressed
  {
    format = ending;
  }
  const auto* const program = std::find_if(
    programs.begin(), programs.end(), [format](const auto& each) { return each[0] == format; });
  if (program != programs.end())
  {
    return std::string(format == ".tar" ? "is an archive (" : "is compressed (") +
           std::string(format) + "): unpack it first, by " + std::string((*program)[1]);
  }
  const Unread* const known = FindUnread(format);
  return known ? "is " + TellUnread(*known) : std::string();
}

}

std::string_view FormatOfContent(std::string_view begin, std::uint64_t size)
{
  const bool isStl = IsBinaryStl(begin, size);
  begin = begin.substr(0, contentFormatBytes);
  const std::string_view line = begin; // text of a fixed width
  begin.remove_prefix(begin.starts_with(utf8Mark) ? utf8Mark.size() : 0);
  TakeBlanks(begin);
  for (const Mark& mark : marks)
  {
    if (begin.starts_with(mark.begin))
    {
      return mark.ending == ".step" && begin.find("IFC") != std::string_view::npos ? ".ifc"
                                                                                   : mark.ending;
    }
  }
  for (const Mark& element : elements)
  {
    if (begin.starts_with('<') && begin.find(element.begin) != std::string_view::npos)
    {
      return element.ending;
    }
  }
  if (begin.starts_with('{'))
  {
    return FormatOfJson(begin);
  }
  if (begin.starts_with("MM") && size > 6 && LittleEndian(begin, 2, 4) == size)
  {
    return ".3ds";
  }
  if (begin.starts_with("FORM") && begin.size() > 12 && begin.substr(8, 3) == "LWO")
  {
    return ".lwo";
  }
  if (line.size() > 262 && line.substr(257, 5) == "ustar")
  {
    return ".tar";
  }
  if (line.size() > 80 && line.substr(72, 8) == "S      1")
  {
    return ".iges";
  }
  std::string_view rest = begin;
  if (TakeWord(rest) == "0" && TakeWord(rest) == "SECTION")
  {
    return ".dxf";
  }
  return isStl ? ".stl" : std::string_view();
}

std::string OtherFormatHint(ByteSource& source, std::string_view ending)
{
  const Result<std::string_view> peeked = source.Peek(contentFormatBytes);
  const std::string begin(peeked ? peeked->substr(0, contentFormatBytes) : std::string_view());
  std::string_view format = FormatOfContent(begin, source.Size());
  std::string hint = UnreadHint(source, begin, format, ending);
  source.Seek(source.Start());
  format = format.empty() ? FormatOfText(begin) : format;
  if (!hint.empty() || format.empty() || format == ending ||
      (format == ".gltf" && ending == ".glb") || (format == ".las" && ending == ".laz"))
  {
    return hint;
  }
  return "looks like a " + std::string(format) + " file, although its name " +
         (ending.empty() ? "has no ending" : "ends in " + std::string(ending)) +
         ": rename it to end in " + std::string(format);
}

std::string UnknownEndingHint(ByteSource& source, std::string_view ending)
{
  const std::string hint = OtherFormatHint(source, ending);
  const Unread* const known = FindUnread(ending);
  const std::string quoted = "the ending '" + std::string(ending) + "' ";
  return !hint.empty() ? hint
         : known       ? quoted + "is that of " + TellUnread(*known)
                       : quoted + "names no known mesh format; convert it to .ply";
}

}
