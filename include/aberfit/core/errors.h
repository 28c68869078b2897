#pragma once
#include <stdexcept>
#include <string>

namespace aberfit {

/// Bad input from outside (study file, data file, command line): the program prints `what()` and exits 2.
/// Says where (file and, inside JSON, the pointer), what was found and what is allowed.
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

/// A value of a task that cannot be used, told by those who know no file. field: its dotted name in the study
/// format, "target.psd.method"; whoever knows the file makes an InputError of it (study/field_errors.h).
class FieldError : public std::runtime_error {
 public:
  FieldError(std::string field, std::string found, std::string allowed);

  const std::string& field() const { return field_; }
  const std::string& found() const { return found_; }
  const std::string& allowed() const { return allowed_; }

 private:
  std::string field_, found_, allowed_;
};

/// A computation that could not deliver a result at all: the program exits 3. Numerical trouble that still
/// leaves a result is a status and a warning inside that result instead.
class ComputationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A run that was asked to stop before there was anything to keep: the program exits 4.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace aberfit
