// SPDX-License-Identifier: BSD-3-Clause
// Makes a recording: see Recorder.h.
#include "viewer/client/Testing/Replay/Recorder.h"

#include "filters/model/ModelJson.h"
#include "filters/protocol/BinaryFrame.h"
#include "filters/protocol/ResourcePath.h"
#include "server/session/Testing/PullMessage.h"
#include "viewer/session/Testing/MemoryServer.h"

#include <cmath>
#include <utility>

namespace kdstream::testing
{

class TroubledCatalog::TroubledModel : public ServedModel
{
public:
  TroubledModel(
    std::shared_ptr<const ServedModel> whole, const std::set<protocol::BlobId>& unreadable)
    : Whole(std::move(whole))
    , Unreadable(unreadable)
  {
  }
  const ModelDescription& Description() const override { return this->Whole->Description(); }
  Result<std::span<const Box>> Boxes() const override { return this->Whole->Boxes(); }
  Result<BlobBytes> ReadBlob(const protocol::BlobId& blob) const override
  {
    if (this->Unreadable.count(blob) != 0)
    {
      return Error{ ErrorCode::Damaged, "its checksum is wrong" };
    }
    return this->Whole->ReadBlob(blob);
  }

private:
  std::shared_ptr<const ServedModel> Whole;
  const std::set<protocol::BlobId>& Unreadable;
};

std::vector<std::shared_ptr<const ServedModel>> TroubledCatalog::Models() const
{
  return this->Whole.Models();
}

std::shared_ptr<const ServedModel> TroubledCatalog::Find(std::string_view id) const
{
  auto whole = this->Whole.Find(id);
  return whole ? std::make_shared<TroubledModel>(std::move(whole), this->unreadable) : nullptr;
}

Recorder::Recorder(const Catalog& models, bool hasStream, const std::string& file)
  : catalog(models)
  , HasStream(hasStream)
  , Recording(file + ".recording", std::ios::binary)
  , Trace(file + ".trace", std::ios::binary)
  , Session([this](std::string_view line) { this->Trace << line << '\n'; })
{
  std::vector<ModelSummary> list;
  for (const auto& model : models.Models())
  {
    list.push_back(Summarize(model->Description()));
  }
  this->Do(Kind::Models, {}, WriteModelList(list));
}

void Recorder::Do(Kind kind, std::vector<double> numbers, std::string payload)
{
  this->Input({ kind, this->Now, std::move(numbers), std::move(payload) });
  if (kind == Kind::Draw && this->drawsEach)
  {
    this->CountHoles();
  }
}

void Recorder::CountHoles()
{
  const ViewerScene scene = this->Session.Session().Scene();
  if (std::exchange(this->DrawnVersion, scene.surfaceVersion) != scene.surfaceVersion)
  {
    ++this->SurfacesDrawn;
    this->BoundaryEdges += CountBoundaryEdges(scene.surface->Whole().triangles);
  }
}

void Recorder::Carry(std::size_t bytes)
{
  this->Wait(this->bytesPerSecond > 0 ? static_cast<double>(bytes) / this->bytesPerSecond : 0);
}

void Recorder::Input(RecordedInput input)
{
  this->Recording << FormatInput(input);
  for (const ServerLine::Action& action : this->Session.Apply(input))
  {
    switch (action.kind)
    {
      case ServerLine::Action::Kind::Connect:
        this->Connecting = true;
        this->Stream.reset();
        break;
      case ServerLine::Action::Kind::Send:
        if (this->Stream)
        {
          this->Stream->Receive(action.text);
        }
        break;
      case ServerLine::Action::Kind::Close:
        this->Connecting = false;
        this->Stream.reset();
        break;
      case ServerLine::Action::Kind::Fetch:
        this->Fetches.push_back(action.fetch);
        break;
    }
  }
}

void Recorder::Tap(double x, double y)
{
  this->Do(Kind::Touches, { 1, x, y });
  this->Wait(0.07);
  this->Do(Kind::Touches);
  this->Wait(0.12);
}

void Recorder::DoubleTap(double x, double y)
{
  this->Tap(x, y);
  this->Tap(x + 3, y - 2);
  this->Wait(0.5);
}

void Recorder::Drag(double x, double y, double dx, double dy)
{
  constexpr int steps = 7;
  for (int i = 0; i <= steps; ++i)
  {
    this->Do(Kind::Touches, { 1, x + dx * i / steps, y + dy * i / steps });
    this->Do(Kind::Draw);
    this->Wait(1.0 / 60);
  }
  this->Do(Kind::Touches);
  this->Wait(0.5);
}

void Recorder::Pinch(double x, double y, double fromGap, double toGap, double dx, double dy)
{
  constexpr int steps = 9;
  for (int i = 0; i <= steps; ++i)
  {
    const double part = static_cast<double>(i) / steps;
    const double half = fromGap * std::pow(toGap / fromGap, part) / 2;
    const double middleX = x + dx * part, middleY = y + dy * part;
    this->Do(Kind::Touches, { 1, middleX - half * 0.8, middleY - half * 0.6, 2,
                              middleX + half * 0.8, middleY + half * 0.6 });
    this->Do(Kind::Draw);
    this->Wait(1.0 / 60);
  }
  this->Do(Kind::Touches, { 2, x, y });
  this->Do(Kind::Touches);
  this->Wait(0.5);
}

bool Recorder::Answer()
{
  this->Wait(0.003);
  if (this->Connecting)
  {
    this->Connecting = false;
    if (this->serverIsUp && this->HasStream)
    {
      this->Stream = std::make_unique<Conversation>(this->catalog);
      this->Do(Kind::Opened);
    }
    else
    {
      const bool refused = this->serverIsUp;
      this->Do(Kind::Ended, { refused ? 1.0 : 0.0 }, refused ? "no stream" : "no answer");
    }
    return true;
  }
  if (!this->Fetches.empty())
  {
    this->AnswerFetch();
    return true;
  }
  auto message = this->Stream ? PullMessage(*this->Stream) : std::nullopt;
  if (!message)
  {
    return false;
  }
  if (auto* text = std::get_if<std::string>(&*message))
  {
    this->Do(Kind::Text, {}, std::move(*text));
    return true;
  }
  const auto& bytes = std::get<std::vector<std::uint8_t>>(*message);
  this->Carry(bytes.size());
  if (const auto parsed = protocol::ParseFrame(bytes);
      parsed && parsed->header.offset + parsed->payload.size() == parsed->header.total)
  {
    this->sent.push_back(parsed->header.blob);
  }
  std::string frame(bytes.begin(), bytes.end());
  if (std::exchange(this->Damage, false))
  {
    frame[frame.size() * 2 / 3] ^= 4;
  }
  this->Do(Kind::Frame, {}, std::move(frame));
  return true;
}

void Recorder::AnswerFetch()
{
  const HttpFetch fetch = std::move(this->Fetches.front());
  this->Fetches.pop_front();
  if (!this->serverIsUp)
  {
    this->Do(Kind::NotFetched, {}, "no answer");
    return;
  }
  HttpReply reply = this->Fetch(fetch.target);
  this->Carry(reply.body.size());
  if (!reply.body.empty() && std::exchange(this->Damage, false))
  {
    reply.body[reply.body.size() * 2 / 3] ^= 4;
  }
  this->Do(Kind::Fetched, { static_cast<double>(reply.status) }, std::move(reply.body));
}

HttpReply Recorder::Fetch(const std::string& target)
{
  const auto path = protocol::ParseResourcePath(target);
  const auto model = path ? this->catalog.Find(path->model) : nullptr;
  if (!model)
  {
    return { 404, R"({"error":"no such model"})" };
  }
  if (path->kind == protocol::ResourcePath::Kind::Model)
  {
    return { 200, WriteModel(model->Description()) };
  }
  const auto blob = model->ReadBlob(path->blob);
  if (blob)
  {
    this->sent.push_back(path->blob);
  }
  return blob ? HttpReply{ 200, { (*blob)->begin(), (*blob)->end() } }
              : HttpReply{ 500, R"({"error":")" + blob.GetError().message + "\"}" };
}

std::size_t Recorder::Settle(std::size_t answers)
{
  std::size_t given = 0;
  for (; given < answers && this->Answer(); ++given)
  {
    if (this->drawsEach || given % 6 == 5)
    {
      this->Do(Kind::Draw);
    }
  }
  this->Do(Kind::Draw);
  return given;
}

void Recorder::Settle()
{
  constexpr std::size_t all = 1000000;
  while (this->Settle(all) > 0)
  {
    // repeated, because the last frame may have requested more
  }
}

void Recorder::Break()
{
  if (this->HasStream)
  {
    this->Stream.reset();
    this->Do(Kind::Ended, { 0 }, "reset by peer");
  }
  else if (!this->Fetches.empty())
  {
    this->Fetches.pop_front();
    this->Do(Kind::NotFetched, {}, "reset by peer");
  }
}

bool Recorder::Finish()
{
  this->Session.Finish();
  this->Recording.close();
  this->Trace.close();
  return this->Recording.good() && this->Trace.good();
}

}
