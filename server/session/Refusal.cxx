// SPDX-License-Identifier: BSD-3-Clause
#include "server/session/Refusal.h"

namespace kdstream
{

std::string TooManyRequests(std::chrono::seconds wait)
{
  return "too many requests: try again in " + std::to_string(wait.count()) + " s";
}

Refusal RefusePart(const std::string& model, const std::string& what, const Error& error)
{
  switch (error.code)
  {
    case ErrorCode::NotFound:
      return { 404, model + " has no " + what };
    case ErrorCode::Changed:
      return { 410, model + " has a new digest: read its model.json again" };
    case ErrorCode::LimitExceeded:
    case ErrorCode::InputOutput:
    case ErrorCode::DiskFull:
    case ErrorCode::Cancelled:
      return { 503, what + " of " + model + " cannot be read now: try again" };
    case ErrorCode::InvalidArgument:
      return { 400, error.message };
    case ErrorCode::InvalidInput:
    case ErrorCode::Unsupported:
    case ErrorCode::Damaged:
      break;
  }
  return { 500, what + " of " + model + " is damaged on the server" };
}

Refusal RefuseModel(const std::string& model, const Error& error)
{
  if (error.code == ErrorCode::Damaged)
  {
    return { 500, model + " is damaged on the server" };
  }
  return { 503, model + " is being replaced: try again" };
}

}
