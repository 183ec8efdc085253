// SPDX-License-Identifier: BSD-3-Clause
// Copies texts for other programs to paste, by the X server's selection CLIPBOARD (ICCCM, section
// 2).
#pragma once

#include <memory>
#include <string>

namespace kdstream
{

// The content stays until this program ends or another program sets the clipboard.
class ScreenClipboard
{
public:
  ScreenClipboard();
  ~ScreenClipboard();
  ScreenClipboard(const ScreenClipboard&) = delete;
  ScreenClipboard& operator=(const ScreenClipboard&) = delete;

  // Copies a UTF-8 text of at most 64 KiB. Returns false if there is no X server.
  bool Put(std::string text);
  // Answers the requests since the last call; call this several times a second.
  void Serve();

private:
  struct State;
  std::unique_ptr<State> Own; // null without an X server
};

}
