// kdstream-generate: models of any size, made up.
#include "Data/Generate/ClosedGrid.h"
#include "Data/Generate/Vase.h"
#include "filters/app/Program.h"

#include <iterator>

namespace
{

using namespace kdstream;

struct Kind
{
  const char* name;
  generate::PaintedSurface (*make)(std::uint64_t seed);
  double columnsPerRing;
};
constexpr Kind kinds[] = { { "vase", generate::MakeVase, generate::vaseColumnsPerRing } };

struct CommandLine
{
  std::string kind, file;
  std::uint64_t vertices = 300000, seed = 1;
};

int Generate(const std::string& program, const CommandLine& line)
{
  const auto kind = std::find_if(
    std::begin(kinds), std::end(kinds), [&line](const Kind& k) { return k.name == line.kind; });
  const auto grid = generate::ClosedGrid::Of(line.vertices, kind->columnsPerRing);
  if (!grid)
  {
    return PrintError(program, "", grid.GetError());
  }
  const Status written = generate::WritePly(*grid, kind->make(line.seed), line.file);
  return written ? exitDone : PrintError(program, line.file, written.GetError());
}

}

int main(int argc, char** argv)
{
  CommandLine line;
  CLI::App app("Makes up a model and writes it as a binary PLY file with colours, as a stream.\n\n"
               "  vase   a closed, hollow vase with fine relief, painted\n\n"
               "Example: kdstream-generate vase vase.ply --vertices 300000",
    "kdstream-generate");
  app.set_version_flag("--version", KDSTREAM_VERSION);
  std::vector<std::string> names;
  for (const Kind& kind : kinds)
  {
    names.emplace_back(kind.name);
  }
  app.add_option("KIND", line.kind, "what to make")->required()->check(CLI::IsMember(names));
  app.add_option("FILE", line.file, "PLY file to write")->required();
  app.add_option("--vertices", line.vertices, "about how many it has")->capture_default_str();
  app.add_option("--seed", line.seed, "another one makes another grain")->capture_default_str();
  return RunProgram(app, argc, argv, [&]() { return Generate(app.get_name(), line); });
}
