#pragma once
#include <stdexcept>
#include <string>

namespace aberfit {

/// Value of `found` for a missing item; `allowed` is then a sentence, "a study needs ...".
inline constexpr const char* kMissing = "missing";

/// Bad input from outside (study file, data file, command line): the program prints `what()` and exits 2. It
/// gives the place (file and, inside JSON, the pointer), what was found and what is allowed.
class InputError : public std::runtime_error {
 public:
  InputError(std::string file, std::string pointer, std::string found, std::string allowed);

  const std::string& file() const { return file_; }
  const std::string& pointer() const { return pointer_; }
  const std::string& found() const { return found_; }
  const std::string& allowed() const { return allowed_; }

 private:
  std::string file_, pointer_, found_, allowed_;
};

/// A value of a task that cannot be used, thrown by code that does not know the file. field: its dotted name
/// in the study format, "target.psd.method". It becomes an InputError with the file (study/field_errors.h).
class FieldError : public std::runtime_error {
 public:
  FieldError(std::string field, std::string found, std::string allowed);

  const std::string& field() const { return field_; }
  const std::string& found() const { return found_; }
  const std::string& allowed() const { return allowed_; }

 private:
  std::string field_, found_, allowed_;
};

/// A computation without any result: the program exits 3. Trouble that leaves a result is a warning in it.
class ComputationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A run that was interrupted before it had a result: the program exits 4.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace aberfit
