#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "aberfit/study/study.h"

namespace aberfit {

/// What a case puts into the study: JSON pointers with their values as JSON texts.
using CaseValues = std::vector<std::pair<std::string, std::string>>;

/// Studies that differ from one in a few values. A case is read as the file would be with these values in it,
/// so defaults follow them; what it does not change is read and measured once. Const use from many threads.
class StudyCases {
 public:
  /// As parse_study; the study has the block `vary`, which throws InputError where it is absent.
  StudyCases(const std::string& text, const std::string& path, const std::vector<std::string>& changes = {});
  /// As read_study.
  static StudyCases read(const std::string& path, const std::vector<std::string>& changes = {});
  ~StudyCases();
  StudyCases(StudyCases&&) noexcept;

  /// The study itself.
  const Study& study() const;
  /// One case, without the blocks `vary`, `verify` and `output`. Throws InputError as read_study does.
  Study at(const CaseValues& values) const;
  /// Hash of a case (core/content_hash.h), the same in every run and on every machine. It covers what is
  /// computed (`vary.run`), a line end, and the resolved study as JSON with sorted keys and without blanks.
  /// Texts for people and the blocks `vary`, `verify` and `output` do not count, nor does `solve` where it is
  /// not computed. A `file` or `mask` that is there is replaced by the hash of its content.
  std::string id(const Study& of_case) const;
  /// The same of a case that cannot be read: of the study as written with `values` in it.
  std::string id_of_unreadable(const CaseValues& values) const;
  /// Hash of all that cases have in common: two cases of the same base with the same values are the same.
  /// Empty where a file is among what varies.
  const std::string& base() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace aberfit
