// SPDX-License-Identifier: BSD-3-Clause
// Errors as values: what every function outside VTK returns when its input may be bad.
//
// A Result<T> holds either a T or an Error. The message names the offending value and its place
// ("vertex 17: x is not finite"); the function that opened the file adds the file's name (OfFile).
// Nothing in core, codec, meshio, store, protocol, session or client throws for bad input, logs, or
// exits.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace kdstream
{

enum class ErrorCode
{
  InvalidInput,    // the bytes or the mesh are not what they claim to be
  InvalidArgument, // an option outside its documented range
  Unsupported,     // well-formed, but this version does not support it
  NotFound,        // no such file, model, piece
  Damaged,         // a checksum or a structure inside a store is wrong
  Changed,         // a file is no longer what it was when it was opened
  LimitExceeded,   // a memory or size limit forbids the work
  InputOutput,     // the operating system refused
  DiskFull,        // no room to write: the disk or a quota is full, or the file would be too long
  Cancelled        // the caller's progress function asked to stop
};

// What the user can do about a refused input: programs print this after the message
// (filters/program/Program.cxx).
enum class Remedy
{
  Unknown,       // not named: OfInput takes the remedy of the error code
  InMessage,     // the message names the remedy
  Repair,        // the content is wrong: correct it, or export it again
  CopyAgain,     // the file is cut off
  Rename,        // the file is not of the format that its name has
  Retry,         // another program writes to it
  SaveOtherwise, // well-formed, but not supported: save it in another way
  Divide         // too large to be read: divide it
};

struct Error
{
  ErrorCode code = ErrorCode::InvalidInput;
  std::string message;
  // The file that the error is about; empty if only the caller knows it.
  std::string file = {};
  // The place in the file ("byte 4096"), if it is not in the message.
  std::string place = {};
  Remedy remedy = Remedy::Unknown;
};

// For an error about an input: adds the remedy of its error code, unless it has a remedy already.
inline Error OfInput(Error error)
{
  if (error.remedy == Remedy::Unknown)
  {
    error.remedy = error.code == ErrorCode::InvalidInput    ? Remedy::Repair
                   : error.code == ErrorCode::Unsupported   ? Remedy::SaveOtherwise
                   : error.code == ErrorCode::LimitExceeded ? Remedy::Divide
                                                            : Remedy::Unknown;
  }
  return error;
}

// An error InvalidInput with another remedy than that of the error code.
inline Error BadInput(std::string message, Remedy remedy)
{
  return { ErrorCode::InvalidInput, std::move(message), {}, {}, remedy };
}

// A value of type T, or the error that prevented it.
template <class T>
class [[nodiscard]] Result
{
public:
  Result(T value)
    : Content(std::in_place_index<0>, std::move(value))
  {
  }
  Result(Error error)
    : Content(std::in_place_index<1>, std::move(error))
  {
  }

  bool HasValue() const { return this->Content.index() == 0; }
  explicit operator bool() const { return this->HasValue(); }

  // REQUIRES: HasValue().
  T& Value()
  {
    assert(this->HasValue());
    return *std::get_if<0>(&this->Content);
  }
  const T& Value() const
  {
    assert(this->HasValue());
    return *std::get_if<0>(&this->Content);
  }
  T& operator*() { return this->Value(); }
  const T& operator*() const { return this->Value(); }
  T* operator->() { return &this->Value(); }
  const T* operator->() const { return &this->Value(); }

  // REQUIRES: !HasValue().
  const Error& GetError() const
  {
    assert(!this->HasValue());
    return *std::get_if<1>(&this->Content);
  }

private:
  std::variant<T, Error> Content;
};

// Success, or the error that prevented it.
template <>
class [[nodiscard]] Result<void>
{
public:
  Result() = default;
  Result(Error error)
    : Content(std::move(error))
  {
  }

  bool HasValue() const { return !this->Content.has_value(); }
  explicit operator bool() const { return this->HasValue(); }

  // REQUIRES: !HasValue().
  const Error& GetError() const
  {
    assert(!this->HasValue());
    return *this->Content;
  }

private:
  std::optional<Error> Content;
};

// Adds the file's name to the result's error, unless that names a file already. For the function
// that opened the file.
template <class T>
Result<T> OfFile(const std::string& file, Result<T> result)
{
  if (!result && result.GetError().file.empty())
  {
    Error error = result.GetError();
    error.file = file;
    return error;
  }
  return result;
}

// The same for the error of a result.
template <class T>
Result<T> OfInput(Result<T> result)
{
  return result ? std::move(result) : Result<T>(OfInput(result.GetError()));
}

using Status = Result<void>;

}

// Passes an error on: returns from the function with the error of the Status or Result, if it has
// one. For functions that return a Status or a Result.
//
//   KDSTREAM_TRY(output.Open(file));
//   Result<Grid> grid = MakeGrid(box);
//   KDSTREAM_TRY(grid);
//   Use(*grid);
#define KDSTREAM_TRY(...) KDSTREAM_TRY_AS(KDSTREAM_JOIN(outcomeOfLine, __LINE__), __VA_ARGS__)
#define KDSTREAM_TRY_AS(outcome, ...)             \
  do                                              \
  {                                               \
    if (auto&& outcome = (__VA_ARGS__); !outcome) \
    {                                             \
      return outcome.GetError();                  \
    }                                             \
  } while (false)
#define KDSTREAM_JOIN(a, b) KDSTREAM_JOIN_TOKENS(a, b)
#define KDSTREAM_JOIN_TOKENS(a, b) a##b
