// SPDX-License-Identifier: BSD-3-Clause
// A session that zooms into a model and gets one blob in each frame. First it runs natively, from a
// store. Then it runs again, natively or as WebAssembly, from a tape that the first run has
// written.
#pragma once

#include "filters/model/ModelJson.h"
#include "viewer/session/ViewerSession.h"

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace kdstream::bench
{

using Bytes = std::vector<std::uint8_t>;

inline double SecondsOf(const std::function<void()>& work)
{
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

struct Arrivals
{
  ModelDescription model;
  double zoom = 1;
  std::function<Bytes(const protocol::BlobId&)> find;
  // Called before a blob is passed to the session (arrive), and after it to begin a frame (draw).
  std::function<void(const protocol::BlobId&, const Bytes&)> arrive;
  std::function<void(ViewerSession&)> draw;
  // Calls its argument, which passes the blob to the session. The session decodes the blob, and
  // chooses what to show and to request.
  std::function<void(const std::function<void()>&)> give = [](const auto& work) { work(); };

  void Run() const
  {
    SessionOptions options;
    options.refinement.triangles = 300'000; // a phone's budget
    options.mostStatistics = 0;
    ViewerSession session(options);
    session.Resize({ 1600, 960, 1 });
    static_cast<void>(session.SelectModel(this->model.id));
    std::deque<std::pair<std::uint32_t, protocol::BlobId>> outstanding;
    for (bool isNear = false;; this->draw(session))
    {
      this->TakeRequests(session, outstanding);
      if (!outstanding.empty())
      {
        const auto [request, blob] = outstanding.front();
        outstanding.pop_front();
        const Bytes bytes = this->find(blob);
        this->arrive(blob, bytes);
        this->give([&, request = request, blob = blob]
          { session.BlobArrived(request, blob, bytes, 0.01, false); });
      }
      else if (!std::exchange(isNear, true))
      {
        session.EnterFullScreen();
        session.Zoom(this->zoom, 800, 480);
      }
      else if (session.IsIdle())
      {
        return;
      }
    }
  }

private:
  template <class OutstandingList>
  void TakeRequests(ViewerSession& session, OutstandingList& outstanding) const
  {
    for (const SessionRequest& request : session.TakeRequests())
    {
      if (request.kind == SessionRequest::Kind::Open)
      {
        session.Opened(request.id, this->model);
        this->TakeRequests(session, outstanding);
      }
      if (request.kind == SessionRequest::Kind::Cancel)
      {
        std::erase_if(outstanding, [&](const auto& each) { return each.first == request.id; });
      }
      for (const protocol::BlobId& blob : request.blobs)
      {
        outstanding.emplace_back(request.id, blob);
      }
    }
  }
};

// The model, and every blob that was requested. The file is only for the machine and the run that
// have written it.
struct Tape
{
  std::string model; // as JSON
  double zoom = 1;
  std::map<std::string, Bytes> blobs; // by BlobName

  bool Write(const char* path) const
  {
    std::FILE* file = std::fopen(path, "wb");
    bool whole = file != nullptr;
    const auto put = [&](const void* bytes, std::size_t count)
    { whole = whole && (count == 0 || std::fwrite(bytes, count, 1, file) == 1); };
    const auto putBytes = [&](const auto& bytes)
    {
      const std::uint64_t count = bytes.size();
      put(&count, sizeof(count));
      put(bytes.data(), bytes.size());
    };
    put(&this->zoom, sizeof(this->zoom));
    putBytes(this->model);
    for (const auto& [name, bytes] : this->blobs)
    {
      putBytes(name);
      putBytes(bytes);
    }
    return file && std::fclose(file) == 0 && whole;
  }

  bool Read(const char* path)
  {
    std::FILE* file = std::fopen(path, "rb");
    bool whole = file != nullptr;
    const auto take = [&](void* bytes, std::size_t count)
    { whole = whole && (count == 0 || std::fread(bytes, count, 1, file) == 1); };
    const auto takeBytes = [&](auto& bytes)
    {
      std::uint64_t count = 0;
      take(&count, sizeof(count));
      bytes.resize(whole ? static_cast<std::size_t>(count) : 0);
      take(bytes.data(), bytes.size());
    };
    take(&this->zoom, sizeof(this->zoom));
    takeBytes(this->model);
    while (whole)
    {
      std::string name;
      Bytes bytes;
      takeBytes(name);
      takeBytes(bytes);
      if (whole)
      {
        this->blobs[name] = std::move(bytes);
      }
    }
    return file && std::fclose(file) == 0 && !this->blobs.empty();
  }
};

}
