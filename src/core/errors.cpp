#include "aberfit/core/errors.h"

namespace aberfit {
namespace {

std::string message(const std::string& file, const std::string& pointer, const std::string& found,
                    const std::string& allowed) {
  std::string text = file;
  if (!pointer.empty()) text += (text.empty() ? "" : ": ") + pointer;
  // For a missing item, `allowed` is a sentence about who needs what.
  if (found == kMissing) return text + (text.empty() ? "" : ": ") + found + "; " + allowed;
  if (!found.empty()) text += (text.empty() ? "found " : ": found ") + found;
  if (!text.empty() && !allowed.empty()) text += "; ";
  if (!allowed.empty()) text += (allowed.starts_with("did you mean") ? "" : "allowed: ") + allowed;
  return text;
}

}  // namespace

InputError::InputError(std::string file, std::string pointer, std::string found, std::string allowed)
    : std::runtime_error(message(file, pointer, found, allowed)),
      file_(std::move(file)),
      pointer_(std::move(pointer)),
      found_(std::move(found)),
      allowed_(std::move(allowed)) {}

FieldError::FieldError(std::string field, std::string found, std::string allowed)
    : std::runtime_error(message("", field, found, allowed)),
      field_(std::move(field)),
      found_(std::move(found)),
      allowed_(std::move(allowed)) {}

}  // namespace aberfit
