#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/study/study.h"

namespace aberfit {

/// The values that a case sets in the study: JSON pointers, and values as JSON texts.
using CaseValues = std::vector<std::pair<std::string, std::string>>;

/// Studies that differ from one study in a few values. A case is read as if the file had these values, so
/// defaults follow them. Whatever a case leaves unchanged is read and measured once. Many threads may use a
/// const object.
class StudyCases {
 public:
  /// Like parse_study. Throws InputError if the study has no `vary` block.
  StudyCases(const std::string& text, const std::string& path, const std::vector<std::string>& changes = {});
  /// Like read_study.
  static StudyCases read(const std::string& path, const std::vector<std::string>& changes = {});
  ~StudyCases();
  StudyCases(StudyCases&&) noexcept;

  /// The study itself.
  const Study& study() const;
  /// One case, without the blocks `vary`, `verify` and `output`. Throws InputError like read_study.
  Study at(const CaseValues& values) const;
  /// Hash of a case (core/content_hash.h), the same in every run and on every machine. It covers `vary.run`,
  /// a line end, and the resolved study as JSON with sorted keys and without blanks. Texts for readers and
  /// the blocks `vary`, `verify` and `output` do not count; `solve` counts only if it is computed. The hash
  /// of a file's content stands for a `file` or `mask` that exists.
  std::string id(const Study& of_case) const;
  /// The same for a case that cannot be read: hash of the study as written, with `values` set.
  std::string id_of_unreadable(const CaseValues& values) const;
  /// Hash of what all cases have in common: two cases with the same base and values are the same. Empty if a
  /// file varies.
  const std::string& base() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace aberfit
