// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/rendering/Testing/RenderTools.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kdstream::test
{
namespace
{

constexpr std::array headless{ WindowBackend::Egl, WindowBackend::OsMesa };

// Sets or unsets an environment variable until the end of a scope.
class ScopedVariable
{
public:
  ScopedVariable(const char* name, const char* value)
    : Name(name)
  {
    if (const char* old = std::getenv(name))
    {
      this->Old = old;
    }
    value ? setenv(name, value, 1) : unsetenv(name);
  }
  ~ScopedVariable()
  {
    this->Old ? setenv(this->Name, this->Old->c_str(), 1) : unsetenv(this->Name);
  }
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

private:
  const char* Name;
  std::optional<std::string> Old;
};

void Show(const Stage& stage, const Surface& surface)
{
  EXPECT_TRUE(stage.scene->Update(surface, depths, { 0, 0, 0 }));
  EXPECT_TRUE(stage.scene->SetCamera(CameraAt({ 0, 0, 0 })));
}

std::size_t ResidentBytes()
{
  std::ifstream file("/proc/self/statm");
  std::size_t total = 0;
  std::size_t resident = 0;
  file >> total >> resident;
  return resident * 4096;
}

std::size_t OpenFiles()
{
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

std::size_t Threads()
{
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<std::size_t>(std::distance(begin(tasks), end(tasks)));
}

TEST(OffscreenWindow, HasNamesForItsBackends)
{
  for (const WindowBackend backend :
    { WindowBackend::Auto, WindowBackend::Egl, WindowBackend::OsMesa, WindowBackend::X11 })
  {
    const auto parsed = ParseWindowBackend(NameOf(backend));
    ASSERT_TRUE(parsed);
    EXPECT_EQ(*parsed, backend);
  }
  for (const char* wrong : { "", "EGL", "glx", "egl " })
  {
    const auto parsed = ParseWindowBackend(wrong);
    ASSERT_FALSE(parsed) << wrong;
    EXPECT_EQ(parsed.GetError().code, ErrorCode::InvalidArgument);
  }
}

TEST(OffscreenWindow, RefusesSizesOutOfRange)
{
  for (const auto& [width, height] : { std::pair{ 0, 10 }, std::pair{ 10, 0 }, std::pair{ -1, 10 },
         std::pair{ largestWindowSide + 1, 10 }, std::pair{ 10, largestWindowSide + 1 } })
  {
    const auto window = MakeOffscreenWindow(WindowBackend::Auto, width, height);
    ASSERT_FALSE(window) << width << "x" << height;
    EXPECT_EQ(window.GetError().code, ErrorCode::InvalidArgument);
    EXPECT_NE(window.GetError().message.find(std::to_string(width) + "x" + std::to_string(height)),
      std::string::npos);
  }
}

TEST(OffscreenWindow, DrawsTheSameOnEglAndOsMesa)
{
  const Surface sphere = BumpySphere(60);
  for (const auto& [width, height] : { std::pair{ 320, 240 }, std::pair{ 97, 211 } })
  {
    const Stage egl(WindowBackend::Egl, width, height);
    const Stage osMesa(WindowBackend::OsMesa, width, height);
    Show(egl, sphere);
    Show(osMesa, sphere);
    const WindowPicture picture = egl.Draw();
    EXPECT_EQ(Compare(picture, osMesa.Draw()).pixels, 0u);
    // It shows the sphere: stone in the middle, and dark background in the corner.
    EXPECT_GT(
      BrightnessAround(picture, 0.5, 0.4, 5), 1.5 * BrightnessAround(picture, 0.05, 0.05, 3));
  }
}

TEST(OffscreenWindow, SmoothsEdges)
{
  // Between stone and background there are mixed pixels, about as many as the outline is long.
  const Stage stage(WindowBackend::Egl, 200, 200);
  Show(stage, BumpySphere(60));
  const WindowPicture smooth = stage.Draw();
  stage.window->SetMultiSamples(0);
  EXPECT_GT(Compare(smooth, stage.Draw()).pixels, 300u);
}

TEST(OffscreenWindow, FollowsChangesOfSize)
{
  const Surface sphere = BumpySphere(40);
  for (const WindowBackend backend : headless)
  {
    const Stage changing(backend, 33, 44);
    Show(changing, sphere);
    changing.Draw();
    for (const auto& [width, height] :
      { std::pair{ 200, 150 }, std::pair{ 1, 1 }, std::pair{ largestWindowSide, 8 },
        std::pair{ 8, largestWindowSide }, std::pair{ 120, 160 } })
    {
      changing.window->SetSize(width, height);
      const WindowPicture picture = changing.Draw();
      ASSERT_EQ(picture.width, width);
      ASSERT_EQ(picture.height, height);
      const Stage fresh(backend, width, height);
      Show(fresh, sphere);
      EXPECT_EQ(Compare(picture, fresh.Draw()).pixels, 0u) << width << "x" << height;
    }
  }
}

TEST(OffscreenWindow, AlternatesWithOthers)
{
  const Surface fine = BumpySphere(50);
  const Surface coarse = BumpySphere(5);
  std::vector<Stage> stages;
  std::vector<WindowPicture> first;
  for (const WindowBackend backend :
    { WindowBackend::Egl, WindowBackend::OsMesa, WindowBackend::OsMesa, WindowBackend::Egl })
  {
    const int size = 100 + 20 * static_cast<int>(stages.size());
    stages.emplace_back(backend, size, size);
    Show(stages.back(), stages.size() % 2 == 0 ? coarse : fine);
    first.push_back(stages.back().Draw());
  }
  EXPECT_GT(Compare(first[1], stages[1].Draw()).pixels + 1, 0u);
  for (const std::size_t i : { 0, 1, 2, 3, 2, 1, 0, 3, 3, 1, 1, 2, 0 })
  {
    EXPECT_EQ(Compare(stages[i].Draw(), first[i]).pixels, 0u) << i;
    EXPECT_TRUE(stages[i].window->IsCurrent());
    for (std::size_t other = 0; other < stages.size(); ++other)
    {
      EXPECT_EQ(stages[other].window->IsCurrent(), other == i);
    }
  }

  // A window may be destroyed while another one is current.
  stages[0].Draw();
  stages.erase(stages.begin() + 1);
  first.erase(first.begin() + 1);
  for (std::size_t i = 0; i < stages.size(); ++i)
  {
    EXPECT_EQ(Compare(stages[i].Draw(), first[i]).pixels, 0u) << i;
  }
  stages.erase(stages.begin());
  EXPECT_EQ(Compare(stages[0].Draw(), first[1]).pixels, 0u);
}

TEST(OffscreenWindow, AndItsSceneMayEndInEitherOrder)
{
  for (const WindowBackend backend : headless)
  {
    Stage sceneFirst(backend, 50, 50);
    Show(sceneFirst, BumpySphere(10));
    sceneFirst.Draw();
    sceneFirst.scene.reset();
    sceneFirst.Draw();

    Stage windowFirst(backend, 50, 50);
    Show(windowFirst, BumpySphere(10));
    const WindowPicture picture = windowFirst.Draw();
    windowFirst.window = nullptr;
    const Stage next(backend, 50, 50);
    next.window->AddRenderer(&windowFirst.scene->Renderer());
    next.window->RemoveRenderer(&next.scene->Renderer());
    EXPECT_EQ(Compare(next.Draw(), picture).pixels, 0u);
  }
}

TEST(OffscreenWindow, LeavesNoFiles)
{
  const Surface sphere = BumpySphere(20);
  const auto makeOne = [&](int i)
  {
    const Stage stage(headless[static_cast<std::size_t>(i) % 2], 256, 256);
    Show(stage, sphere);
    stage.Draw();
  };
  for (int i = 0; i < 10; ++i)
  {
    makeOne(i);
  }
  const std::size_t bytes = ResidentBytes();
  const std::size_t files = OpenFiles();
  const std::size_t threads = Threads();
  for (int i = 0; i < 50; ++i)
  {
    makeOne(i);
  }
  EXPECT_EQ(OpenFiles(), files);
  EXPECT_EQ(Threads(), threads);
  // A window's frame buffers take 4 samples × 8 bytes × 256² = 2 MiB; 50 leaked windows would take
  // 100 MiB.
  const std::size_t after = ResidentBytes();
  RecordProperty("resident_bytes_before", std::to_string(bytes));
  RecordProperty("resident_bytes_after", std::to_string(after));
  EXPECT_LT(after, bytes + (std::size_t{ 16 } << 20));
}

TEST(OffscreenWindow, ManyLiveSideBySide)
{
  const Surface sphere = BumpySphere(10);
  std::vector<Stage> stages;
  for (std::size_t i = 0; i < 12; ++i)
  {
    stages.emplace_back(headless[i % 2], 64, 64);
    Show(stages.back(), sphere);
  }
  const WindowPicture picture = stages.front().Draw();
  for (const Stage& stage : stages)
  {
    EXPECT_EQ(Compare(stage.Draw(), picture).pixels, 0u);
  }
}

TEST(OffscreenWindow, SaysThatThereIsNoDisplay)
{
  {
    const ScopedVariable unset("DISPLAY", nullptr);
    const auto window = MakeOffscreenWindow(WindowBackend::X11, 64, 64);
    ASSERT_FALSE(window);
    EXPECT_EQ(window.GetError().code, ErrorCode::NotFound);
  }
  const ScopedVariable wrong("DISPLAY", ":65000");
  const auto window = MakeOffscreenWindow(WindowBackend::X11, 64, 64);
  ASSERT_FALSE(window);
  EXPECT_EQ(window.GetError().code, ErrorCode::NotFound);
  EXPECT_NE(window.GetError().message.find(":65000"), std::string::npos);
}

TEST(OffscreenWindow, IsFoundAutomatically)
{
  const ScopedVariable unset("DISPLAY", nullptr);
  const Surface sphere = BumpySphere(20);
  const Stage stage(WindowBackend::Auto, 80, 60);
  const Stage egl(WindowBackend::Egl, 80, 60);
  Show(stage, sphere);
  Show(egl, sphere);
  EXPECT_EQ(Compare(stage.Draw(), egl.Draw()).pixels, 0u);
}

// CMake runs this in an environment in which Mesa only offers OpenGL 3.1.
TEST(WithoutOpenGl, DISABLED_SaysWhatEachMisses)
{
  const ScopedVariable unset("DISPLAY", nullptr);
  const auto window = MakeOffscreenWindow(WindowBackend::Auto, 64, 64);
  ASSERT_FALSE(window);
  for (const char* reason : { "EGL: no context with OpenGL 3.2 core",
         "OSMesa: no context with OpenGL 3.2 core", "X11: the environment variable DISPLAY" })
  {
    EXPECT_NE(window.GetError().message.find(reason), std::string::npos)
      << window.GetError().message;
  }
}

// CMake runs this in an environment in which libEGL finds no driver.
TEST(WithoutEgl, DISABLED_AutoTakesOsMesa)
{
  const auto egl = MakeOffscreenWindow(WindowBackend::Egl, 64, 64);
  ASSERT_FALSE(egl);
  EXPECT_EQ(egl.GetError().code, ErrorCode::NotFound);
  EXPECT_NE(egl.GetError().message.find("EGL: no device"), std::string::npos)
    << egl.GetError().message;

  const Stage stage(WindowBackend::Auto, 64, 64);
  Show(stage, BumpySphere(20));
  const Stage osMesa(WindowBackend::OsMesa, 64, 64);
  Show(osMesa, BumpySphere(20));
  EXPECT_EQ(Compare(stage.Draw(), osMesa.Draw()).pixels, 0u);
}

}
}
