// SPDX-License-Identifier: BSD-3-Clause
// Texts for other programs to paste, by the X server's selection CLIPBOARD (ICCCM, section 2).
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

  // Copies UTF-8, at most 64 KiB. False if there is no X server.
  bool Put(std::string text);
  // Answers requests since the last call: call it several times a second.
  void Serve();

private:
  struct State;
  std::unique_ptr<State> Own; // null without an X server
};

}
