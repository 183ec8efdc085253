// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry to a server's conversation with one client. Each line of the input is a step:
//
//   {…}  a message from the client, as it is (as is any line that begins with no letter below)
//   b    a binary message
//   p N  up to N messages are sent
//   e    the conversation's task is started elsewhere; f N: number N of these tasks ends
//   d    the server is stopping
//   t N  the clock advances by N seconds
//   x N  the model: 0 whole, 1 in memory, 2 cannot be read, 3 changed, 4 damaged, 5 no memory,
//        6 its tree is damaged
//   o N  as the first line: the client has a token for 0 everything, 1 levels, 2 previews
//
// For any input the server follows the protocol: the messages that it sends are well formed, blobs
// belong to the model, and a request that was begun ends once and says what was sent. In the end
// the conversation is idle.
#include "server/access/Testing/ForgedToken.h"
#include "server/session/Conversation.h"
#include "server/session/Testing/MemoryCatalog.h"
#include "server/session/Testing/PullMessage.h"

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string_view>
#include <vector>

using namespace kdstream;

namespace
{

void Require(bool holds, const char* what)
{
  if (!holds)
  {
    std::fprintf(stderr, "FuzzConversation: %s\n", what);
    std::abort();
  }
}

struct World
{
  MemoryCatalog catalog;
  std::shared_ptr<MemoryModel> model = catalog.Add("dragon", 1, 4, 70000);
  std::int64_t now = 1000;
  std::shared_ptr<const TokenGuard> guard =
    std::make_shared<const TokenGuard>(forged::Keys(), [this] { return this->now; });

  World() { this->catalog.Add("vase", 2, 0, 100); }

  void SetFault(unsigned what)
  {
    auto& m = *this->model;
    m.inMemory = what == 1;
    m.fails = what == 2   ? std::optional(ErrorCode::InputOutput)
              : what == 3 ? std::optional(ErrorCode::Changed)
                          : std::nullopt;
    m.damaged.clear();
    if (what == 4)
    {
      m.damaged = { protocol::BlobId::Partition(1), protocol::BlobId::TreePage(1) };
    }
    m.throws = what == 5;
    m.treeDamaged = what == 6;
  }
};

World& TheWorld()
{
  static World world;
  return world;
}

Permission PermissionOf(unsigned detail)
{
  auto& world = TheWorld();
  if (detail == 0)
  {
    return {};
  }
  const std::string claims =
    std::string(R"({"sub":"ann","exp":2000,"models":["dragon"],"detail":")") +
    (detail == 1 ? "levels" : "preview") + "\"}";
  auto pass = world.guard->Admit(forged::Token(forged::header, claims));
  Require(pass.HasValue(), "the token is not taken");
  return { world.guard, *pass };
}

class Visit
{
public:
  explicit Visit(unsigned detail)
    : ConversationTest(TheWorld().catalog, Limits(), PermissionOf(detail))
  {
  }
  static ConversationLimits Limits()
  {
    ConversationLimits limits;
    limits.partitions = 1000;
    return limits;
  }

  void Take(std::string_view line)
  {
    unsigned number = 0;
    const auto digits = line.substr(std::min<std::size_t>(2, line.size()));
    (void)std::from_chars(digits.data(), digits.data() + digits.size(), number);
    const bool isCommand = !line.empty() && line.size() < 8 && (line.size() == 1 || line[1] == ' ');
    switch (isCommand ? line[0] : 0)
    {
      case 'b':
        this->ConversationTest.ReceiveBinary();
        break;
      case 'p':
        for (unsigned i = 0; i <= number % 64 && this->Send(this->ConversationTest.NextMessage());
             ++i)
        {
        }
        break;
      case 'e':
        this->Begin();
        break;
      case 'f':
        this->Finish(number);
        break;
      case 'd':
        this->ConversationTest.Drain();
        break;
      case 't':
        TheWorld().now += number;
        break;
      case 'x':
        TheWorld().SetFault(number % 7);
        break;
      default:
        if (this->ConversationTest.AcceptsMessages())
        {
          this->ConversationTest.Receive(
            line, std::chrono::seconds(line.size() % 16 == 15 ? 3 : 0));
        }
    }
  }

  // Whatever happened before, in the end the conversation becomes idle.
  void End()
  {
    while (!this->Away.empty())
    {
      this->Finish(0);
    }
    constexpr unsigned most = 100'000;
    unsigned sent = 0;
    while (this->Send(PullMessage(this->ConversationTest)))
    {
      Require(++sent < most, "it sends for ever");
    }
    Require(
      this->ConversationTest.Closing() || this->ConversationTest.IsIdle(), "it waits for nothing");
    Require(this->Requests.empty() || this->ConversationTest.Closing(), "a request has no end");
  }

private:
  struct Request
  {
    std::uint64_t reported = 0, whole = 0, failed = 0, bytes = 0;
  };

  void Begin()
  {
    if (auto task = this->ConversationTest.TakeTask())
    {
      task->Run();
      this->Away.push_back(std::move(task));
    }
  }

  void Finish(unsigned number)
  {
    if (!this->Away.empty())
    {
      const auto place =
        this->Away.begin() + static_cast<std::ptrdiff_t>(number % this->Away.size());
      this->ConversationTest.Finish(*place);
      this->Away.erase(place);
    }
  }

  bool Send(const std::optional<Conversation::Message>& message)
  {
    if (!message)
    {
      return false;
    }
    if (const auto* text = std::get_if<std::string>(&*message))
    {
      const auto parsed = protocol::ParseServerMessage(*text);
      Require(parsed.HasValue(), "no message of the protocol");
      this->Look(*parsed);
    }
    else
    {
      this->Look(std::get<std::vector<std::uint8_t>>(*message));
    }
    return true;
  }

  void Look(const protocol::ServerMessage& message)
  {
    const auto found = this->Requests.find(message.request);
    const bool begun = found != this->Requests.end();
    if (const auto* begin = std::get_if<protocol::BeginAnswer>(&message.body))
    {
      Require(!begun, "begun twice");
      this->Requests[message.request].reported = begin->blobs;
    }
    else if (const auto* end = std::get_if<protocol::EndAnswer>(&message.body))
    {
      const auto did = begun ? found->second : Request{};
      Require(begun || end->cancelled, "the end of what was not begun");
      Require(end->blobs == did.whole && end->failed == did.failed && end->bytes == did.bytes,
        "it counts wrongly");
      Require(end->cancelled || did.reported == did.whole + did.failed, "blobs are missing");
      this->Forget(message.request);
    }
    else if (const auto* error = std::get_if<protocol::ErrorAnswer>(&message.body))
    {
      if (error->blob)
      {
        Require(begun, "an error of a blob that was not asked for");
        ++found->second.failed;
      }
      else
      {
        this->Forget(message.request);
      }
    }
    else if (std::holds_alternative<protocol::OpenedAnswer>(message.body))
    {
      Require(!begun, "opened what is no opening");
    }
    else
    {
      Require(begun, "the progress of nothing");
    }
  }

  void Look(const std::vector<std::uint8_t>& bytes)
  {
    const auto frame = protocol::ParseFrame(bytes);
    Require(frame.HasValue(), "no frame");
    const auto request = this->Requests.find(frame->header.request);
    Require(request != this->Requests.end(), "a frame of no request");
    request->second.bytes += frame->payload.size();
    const auto blob = this->Assembler.Accept(*frame);
    Require(blob.HasValue(), "a frame that does not fit");
    if (*blob)
    {
      ++request->second.whole;
      bool known = false;
      for (const auto& [id, model] : TheWorld().catalog.models)
      {
        const auto whole = model->blobs.find((*blob)->id);
        known = known || (whole != model->blobs.end() && *whole->second == (*blob)->bytes);
      }
      Require(known, "another blob");
    }
  }

  void Forget(std::uint32_t request)
  {
    this->Requests.erase(request);
    this->Assembler.Forget(request);
  }

  Conversation ConversationTest;
  protocol::FrameAssembler Assembler;
  std::map<std::uint32_t, Request> Requests; // begun, and not ended
  std::vector<std::shared_ptr<Task>> Away;
};

}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  std::string_view text(reinterpret_cast<const char*>(data), size);
  auto& world = TheWorld();
  world.now = 1000;
  world.SetFault(0);
  unsigned detail = 0;
  if (text.size() >= 4 && text.substr(0, 2) == "o " && text[3] == '\n')
  {
    detail = static_cast<unsigned char>(text[2]) % 3;
    text.remove_prefix(4);
  }
  Visit visit(detail);
  while (!text.empty())
  {
    const auto end = std::min(text.find('\n'), text.size());
    visit.Take(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  visit.End();
  return 0;
}
