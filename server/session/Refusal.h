// SPDX-License-Identifier: BSD-3-Clause
// The answer to a client that cannot have what it asks for; the same by GET and by stream.
#pragma once

#include "filters/core/Result.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace kdstream
{

struct Refusal
{
  std::uint16_t status = 500;           // an HTTP status
  std::string message;                  // does not mention anything inside the server
  std::chrono::seconds retryAfter{ 0 }; // when to retry; 0: unknown

  // Whether the cause is the store, or the machine that holds it; needed for metrics.
  bool IsFailure() const { return this->status >= 500; }
};

// The message of 429, for a client that may ask again after `wait`.
std::string TooManyRequests(std::chrono::seconds wait);

// The refusal for a part that `model` should have; `what` is a blob's name, or "tree". 404 if there
// is no such blob; 410 if the store has been changed; 503 for temporary causes (memory, the disk);
// 500 for damage.
Refusal RefusePart(const std::string& model, const std::string& what, const Error& error);

// The refusal for a model whose store has been changed: 503 until it is opened again, 500 if there
// is no complete store any more. error: from ServedModel::CheckUnchanged.
Refusal RefuseModel(const std::string& model, const Error& error);

}
